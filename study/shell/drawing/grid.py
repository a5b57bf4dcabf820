"""Where the tiles of a fleet go. Plain geometry: no window needed."""

from __future__ import annotations

import dataclasses
import math

import pygame

from study.events.scene import Scene

SMALLEST_BAR_TILE = 190
"""Design pixels of width under which a tile's title bar moves into its plate."""
LEGIBLE_TILE = 165
"""Design pixels of width that tiles beside an enlarged one have if there is room."""
ENLARGEMENT = 1.8


@dataclasses.dataclass(frozen=True, slots=True)
class TilePlace:
    """One tile.

    Attributes:
        map: where the map is drawn, pixels.
        plate: where number, cue and health are written, pixels.
        bar: height of the bar above a framed tile, pixels; 0 if it has none.
        single: whether it is the only tile, drawn large.
    """

    map: pygame.Rect
    plate: pygame.Rect
    bar: int
    single: bool

    @property
    def has_corner_plate(self) -> bool:
        """Whether the plate lies in the map's empty corner, not in a strip above it."""
        return self.map.contains(self.plate)

    @property
    def body(self) -> pygame.Rect:
        """The whole tile without its bar and frame."""
        return self.map.union(self.plate)


def place_tiles(area: pygame.Rect, scene: Scene, tiles: int, scale: float) -> list[TilePlace]:
    """Lay out tiles, as large as the area allows.

    Args:
        area: where they go, pixels.
        scene: its shape is the shape of a tile.
        tiles: how many.
        scale: pixels to one design pixel.

    Returns:
        One place a tile, row by row from the top left.
    """
    single = tiles == 1
    bar = round((42 if single else 30) * scale)
    found = _grid(area, scene, tiles, bar, scale)
    if not single and found[0] < SMALLEST_BAR_TILE * scale:
        bar = 0
        found = _grid(area, scene, tiles, bar, scale)
    width, columns = found
    rows = math.ceil(tiles / columns)
    strip = _strip(scene, width, scale)
    height = round(width * scene.height / scene.width) + strip
    gap = _gap(single=single, scale=scale)
    across = _spread(area.width, columns, width, gap, 3.4 * gap)
    down = _spread(area.height, rows, height + bar, gap, 3.4 * gap)
    left = area.left + (area.width - columns * width - (columns - 1) * across) // 2
    top = area.top + (area.height - rows * (height + bar) - (rows - 1) * down) // 2
    places = []
    for tile in range(tiles):
        row, column = divmod(tile, columns)
        x = left + column * (width + across)
        y = top + row * (height + bar + down) + bar
        drawn = pygame.Rect(x, y + strip, width, height - strip)
        places.append(TilePlace(drawn, plate_on(scene, drawn, strip), bar, single))
    return places


def place_enlarged(
    area: pygame.Rect, scene: Scene, tiles: int, scale: float
) -> tuple[TilePlace, list[TilePlace]]:
    """Lay out all tiles, with room at their left for one of them enlarged.

    The enlarged one is as wide as leaves the tiles legible, and about `ENLARGEMENT` times as wide
    as they are at least.

    Returns:
        Where a tile is enlarged, and one place a tile.
    """
    best: tuple[float, int] | None = None
    for percent in range(62, 22, -4):
        split = round(area.width * percent / 100)
        rest = pygame.Rect(area.left + split, area.top, area.width - split, area.height)
        small = place_tiles(rest, scene, tiles, scale)[0].map.width
        large = place_tiles(area.clip((area.left, area.top, split, area.height)), scene, 1, scale)
        if large[0].map.width < ENLARGEMENT * small and best is not None:
            break
        best = (small, split)
        if small >= LEGIBLE_TILE * scale:
            break
    split = best[1] if best is not None else area.width // 2
    left = pygame.Rect(area.left, area.top, split, area.height)
    right = pygame.Rect(area.left + split, area.top, area.width - split, area.height)
    # Tiles that fill the height are shifted against the enlarged one, not out of the area.
    return place_tiles(left, scene, 1, scale)[0], place_tiles(right, scene, tiles, scale)


def _gap(*, single: bool, scale: float) -> int:
    return round((10 if single else 13) * scale)


def _strip(scene: Scene, width: float, scale: float) -> int:
    """Return the height of the plate above a map that leaves no room for it, pixels."""
    return 0 if _in_corner(scene) else round(max(30 * scale, 0.11 * width))


def _in_corner(scene: Scene) -> bool:
    """Whether plates lie in the map's empty corner; a picture has none."""
    return scene.plate is not None and not scene.camera


def _grid(area: pygame.Rect, scene: Scene, tiles: int, bar: int, scale: float) -> tuple[int, int]:
    """Return the largest possible tile width in pixels and its number of columns."""
    gap = _gap(single=tiles == 1, scale=scale)
    best = (0, 1)
    for columns in range(1, tiles + 1):
        rows = math.ceil(tiles / columns)
        across = (area.width - (columns + 1) * gap) / columns
        down = (area.height - (rows + 1) * gap) / rows - bar
        width = min(across, down * scene.width / scene.height)
        if not _in_corner(scene):
            width = min(across, (down - _strip(scene, width, scale)) * scene.width / scene.height)
        best = max(best, (int(width), columns), key=lambda found: found[0])
    return max(40, best[0]), best[1]


def _spread(room: int, count: int, length: int, smallest: int, largest: float) -> int:
    """Return the gap between tiles that shares out the room left over."""
    free = (room - count * length) / (count + 1)
    return round(max(smallest, min(free, largest)))


def plate_on(scene: Scene, drawn: pygame.Rect, strip: int) -> pygame.Rect:
    """Return the plate of a map drawn at ``drawn``, or the strip above it, pixels."""
    if strip or scene.plate is None:
        return pygame.Rect(drawn.left, drawn.top - strip, drawn.width, strip)
    x, y, width, height = scene.plate
    scale_x, scale_y = drawn.width / scene.width, drawn.height / scene.height
    left, right = drawn.left + x * scale_x, drawn.left + (x + width) * scale_x
    top, bottom = drawn.bottom - (y + height) * scale_y, drawn.bottom - y * scale_y
    return pygame.Rect(round(left), round(top), round(right - left), round(bottom - top))
