"""Illustrations of the instructions: the map explained, the keys, choosing, switching."""

from __future__ import annotations

import functools
import math

import pygame

from study.events.scene import DiscMark, RectangleMark, Scene
from study.messages import noted
from study.screens import PageScreen, Tile
from study.shell.drawing import chrome, leaders, maps, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.grid import TilePlace, place_tiles, plate_on
from study.shell.drawing.looks import TileView
from study.shell.drawing.motion import Pose
from study.shell.drawing.plate import PlateLook
from study.shell.drawing.robots import DRIVEN_SCALE, HALO, draw_robot
from study.shell.drawing.tile import draw_tile

SHOWN_HEALTH = 80.0
HEADING = 1.2
SMALLEST_MAP = 120
"""Width of a map in design pixels below which nothing on it can be told."""
CLEARANCE = 2.2
"""Metres of free space that are enough around the robot of an illustration."""


@functools.lru_cache(maxsize=8)
def free_place(scene: Scene) -> tuple[float, float]:
    """Return a place on the map clear of walls and marks, rather to the right, metres."""
    best = (-math.inf, scene.width / 2, scene.height / 2)
    rooms = [mark for mark in scene.rectangles if mark.role == "room"]
    blocked = [mark for mark in scene.rectangles if mark.role != "room"]
    for row in range(1, int(scene.height / 0.25)):
        for column in range(1, int(scene.width / 0.25)):
            x, y = column * 0.25, row * 0.25
            if rooms and not any(_distance(room, x, y) == 0 for room in rooms):
                continue
            clear = [_distance(mark, x, y) for mark in blocked]
            clear += [math.hypot(d.x - x, d.y - y) - d.radius for d in scene.discs]
            score = min([CLEARANCE, *clear]) + 0.03 * x - 0.02 * y
            best = max(best, (score, x, y))
    return best[1], best[2]


def _distance(mark: RectangleMark, x: float, y: float) -> float:
    """Return how far a point lies from a rectangle, 0 inside."""
    across = max(mark.x - x, x - mark.x - mark.width, 0.0)
    return math.hypot(across, max(mark.y - y, y - mark.y - mark.height, 0.0))


def _tile(scene: Scene, robot: int) -> tuple[Tile, Pose]:
    x, y = free_place(scene)
    tile = Tile(robot=robot, x=x, y=y, heading=HEADING, health=SHOWN_HEALTH, cue=None, episode=0)
    return tile, Pose(x, y, HEADING)


def _map_place(
    canvas: Canvas, scene: Scene, place: pygame.Rect, labels: int, bar: int, *, single: bool
) -> TilePlace:
    """Return the largest tile in a place that leaves room for labels at its right."""
    edge = canvas.u(6)
    strip = 0 if scene.plate is not None else canvas.u(44)
    width = place.width - labels - 2 * edge
    height = place.height - 2 * edge - bar - strip
    width = min(width, round(height * scene.width / scene.height))
    if width < canvas.u(SMALLEST_MAP):
        # Something is drawn nevertheless: the screen is tried again at a smaller scale.
        canvas.no_room("the map")
        width = canvas.u(SMALLEST_MAP)
    height = round(width * scene.height / scene.width)
    left = place.left + edge
    if not labels:
        left = place.left + (place.width - width) // 2
    top = place.top + (place.height - height - bar - strip) // 2 + bar + strip
    drawn = pygame.Rect(left, top, width, height)
    return TilePlace(drawn, plate_on(scene, drawn, strip), bar, single)


def draw_annotated_map(canvas: Canvas, screen: PageScreen, place: pygame.Rect) -> None:
    """Draw a driven tile with the names of what is on it."""
    scene = screen.scene
    if scene is None:
        return
    labels = canvas.u(176)
    tile_place = _map_place(canvas, scene, place, labels, 0, single=False)
    tile, pose = _tile(scene, min(4, max(0, screen.robots - 1)))
    look = PlateLook(driven=True, suggested=False, accept_key="", has_dwell=False, note="",
                     has_health=screen.has_health)  # fmt: skip
    draw_tile(canvas, scene, TileView(tile_place, tile, look, pose, ground=palette.CARD))
    view = maps.MapView(scene, tile_place.map)
    start = next((disc for disc in scene.discs if disc.role == "start"), None)
    if start is not None:
        x, y = view.point(start.x, start.y)
        x += maps.disc_radius(view, start) + canvas.u(8)
        canvas.write(canvas.say("start"), x, y, canvas.u(18), colour=palette.SECONDARY)
    right = tile_place.map.right + canvas.u(34)
    leaders.draw(canvas, _notes(view, pose), pygame.Rect(
        right, place.top, place.right - right, place.height
    ), tile_place.map.right)  # fmt: skip


def _notes(view: maps.MapView, pose: Pose) -> list[leaders.Note]:
    """Return what is named on a map, each with the point that its line starts from."""
    scene = view.scene
    notes: list[leaders.Note] = []
    packs = [disc for disc in scene.discs if disc.role == "health_pack"]
    if packs:
        pack = max(packs, key=lambda disc: disc.x + disc.y)
        x, y = view.point(pack.x, pack.y)
        notes.append(leaders.Note(noted("Health pack"), noted("gives health"),
                                  (x + maps.disc_radius(view, pack) * 0.5, y)))  # fmt: skip
    goals = [disc for disc in scene.discs if disc.role == "goal"]
    if goals:
        notes.append(leaders.Note(noted("Goal"), noted("bring it here"), _rim(view, goals[0])))
    if any(mark.role == "wall" for mark in scene.rectangles):
        edge = (view.place.right - 0.006 * view.place.width, view.place.centery - 1.0)
        notes.append(leaders.Note(noted("Wall"), noted("blocks the way"), edge, level=True))
    x, y = view.point(pose.x, pose.y)
    halo = view.robot_radius * DRIVEN_SCALE * HALO
    notes.append(leaders.Note(noted("Your robot"), noted("tip in front"), (x + halo, y)))
    hazards = [mark for mark in scene.rectangles if mark.role == "hazard"]
    if hazards:
        hazard = max(hazards, key=lambda mark: mark.x + mark.width - mark.y)
        drawn = view.rectangle(hazard)
        notes.append(leaders.Note(
            noted("Hazard"), noted("costs health"), (drawn.right - drawn.width * 0.25, drawn.bottom
                                       - drawn.height * 0.12)
        ))  # fmt: skip
    return notes


def _rim(view: maps.MapView, goal: DiscMark) -> tuple[float, float]:
    x, y = view.point(goal.x, goal.y)
    reach = maps.disc_radius(view, goal) * math.sqrt(0.5)
    return x + reach, y + reach


def draw_arrow_keys(canvas: Canvas, place: pygame.Rect) -> None:
    """Draw the arrow keys with what they do."""
    u = canvas.u
    y = place.top + u(32)
    title = canvas.say("Drive with the arrow keys")
    canvas.write(title, place.left + u(24), y, u(22), weight="semibold",
                 width=place.width - u(48))  # fmt: skip
    room = place.bottom - y - u(20)
    cap = min(u(64), (room - u(44)) / 2.3)
    pitch = cap * 1.14
    x = place.centerx
    rows = pitch * 2 + u(26)
    upper = y + u(16) + (room - u(8) - rows) / 2 + cap / 2
    lower = upper + pitch
    for direction, column, row in (
        ("↑", x, upper), ("←", x - pitch, lower), ("↓", x, lower), ("→", x + pitch, lower),
    ):  # fmt: skip
        width = chrome.cap_width(canvas, direction, cap)
        chrome.draw_cap(canvas, direction, column - width / 2, row, cap)
    size, side = u(19), cap / 2 + u(12)
    beside = x - pitch - side - place.left - u(8)
    canvas.write(canvas.say("forward"), x + side, upper, size, weight="semibold",
                 width=place.right - u(8) - x - side)  # fmt: skip
    canvas.write(canvas.say("turn left"), x - pitch - side, lower, size, weight="semibold",
                 align="right", width=beside)  # fmt: skip
    canvas.write(canvas.say("turn right"), x + pitch + side, lower, size, weight="semibold",
                 width=beside)  # fmt: skip
    canvas.write(
        canvas.say("back"), x, lower + cap / 2 + u(20), size, weight="semibold", align="centre"
    )


def draw_choosing(canvas: Canvas, screen: PageScreen, place: pygame.Rect) -> None:
    """Draw a row of tiles, one of them chosen, and the ways to choose it."""
    u = canvas.u
    title_y = place.top + u(32)
    canvas.write(
        canvas.say("Choose a robot"), place.left + u(24), title_y, u(22), weight="semibold"
    )
    shown = min(4, screen.robots)
    last = min(screen.robots, max(shown, 10))
    numbers = range(last - shown, last)
    chosen = numbers[min(1, shown - 1)]
    ways_y = place.bottom - u(34)
    row = pygame.Rect(
        place.left + u(24), title_y + u(26), place.width - u(48), ways_y - u(30) - title_y - u(26)
    )
    keyed = bool(screen.robot_keys) and row.height > u(120)
    cap = u(30) if keyed else 0
    height = row.height - (cap + u(14) if keyed else 0)
    width = min((row.width - (shown - 1) * u(18)) / shown, height * 1.34)
    height = round(width / 1.34)
    pitch = width + min(u(40), (row.width - shown * width) / max(1, shown - 1))
    left = row.left if row.width < u(640) else row.centerx - (pitch * (shown - 1) + width) / 2
    for column, robot in enumerate(numbers):
        tile = pygame.Rect(round(left + column * pitch), row.top, round(width), height)
        drawn = screen.scene is None or not screen.scene.camera
        _small_tile(canvas, tile, robot, chosen=robot == chosen, drawn=drawn)
        if keyed and robot < len(screen.robot_keys):
            name = chrome.key_tokens(screen.robot_keys[robot])[0]
            start = tile.centerx - chrome.cap_width(canvas, name, cap) / 2
            chrome.draw_cap(canvas, name, start, tile.bottom + u(14) + cap / 2, cap)
    _ways_to_choose(canvas, screen, chosen, place, ways_y)


def _ways_to_choose(
    canvas: Canvas, screen: PageScreen, chosen: int, place: pygame.Rect, y: int
) -> None:
    u = canvas.u
    key = screen.robot_keys[chosen] if chosen < len(screen.robot_keys) else str(chosen + 1)
    ways = [(key, canvas.say("its key")), ("Tab", canvas.say("next"))]
    tail = canvas.say("or click it")
    left, right = place.left + u(24), place.right - u(24)
    total = sum(chrome.keys_width(canvas, *way, u(36), u(19)) + u(26) for way in ways)
    total += canvas.text_width(tail, u(19))
    if place.width >= u(640) and total <= right - left:
        left = place.centerx - total // 2
    chrome.draw_hints(canvas, ways, tail, left, right, y)


def _small_tile(
    canvas: Canvas, place: pygame.Rect, robot: int, *, chosen: bool, drawn: bool
) -> None:
    """Draw a tile reduced to number and frame, and its robot where robots are drawn."""
    u = canvas.u
    if chosen:
        canvas.box(place.inflate(u(12), u(12)), u(6), palette.BLUE)
    canvas.surface.fill(palette.CARD if chosen else palette.FLOOR, place)
    pygame.draw.rect(canvas.surface, palette.WALL, place, max(1, u(2)))
    plate = pygame.Rect(place.left, place.top, round(place.width * 0.46), round(place.height * 0.5))
    canvas.surface.fill(palette.BLUE if chosen else palette.PLATE, plate)
    size = min(plate.height * 0.8, u(44))
    canvas.write(
        str(robot + 1), plate.centerx, plate.centery, size, weight="bold", align="centre",
        colour=palette.CARD if chosen else palette.INK,
    )  # fmt: skip
    if chosen:
        canvas.write(
            canvas.say("YOU"), (plate.right + place.right) / 2, plate.centery,
            min(u(22), size * 0.66), weight="bold", colour=palette.BLUE_DARK, align="centre",
            width=place.right - plate.right,
        )  # fmt: skip
    if not drawn:
        return
    heading = (0.3, 0.5, 2.6, 1.6)[robot % 4]
    x, y = place.left + place.width * 0.68, place.top + place.height * 0.74
    if chosen:
        draw_robot(canvas, x, y, place.height * 0.085, heading, driven=True)
    else:
        draw_robot(canvas, x, y, place.height * 0.11, heading, driven=False)


def draw_switching(canvas: Canvas, screen: PageScreen, place: pygame.Rect) -> None:
    """Draw a large tile with the ring of the dwell, or tiles where all robots are seen."""
    scene = screen.scene
    if scene is None:
        return
    if screen.figure == "assisted_all" and screen.robots > 1:
        _draw_all_switched(canvas, screen, scene, place)
        return
    tile_place = _map_place(canvas, scene, place, 0, canvas.u(42), single=True)
    _draw_tile_of(canvas, screen, scene, tile_place, min(6, max(0, screen.robots - 1)))


def _draw_all_switched(
    canvas: Canvas, screen: PageScreen, scene: Scene, place: pygame.Rect
) -> None:
    """Draw some tiles of a fleet, one of them driven and with the ring of the dwell."""
    shown = min(4, screen.robots)
    places = place_tiles(place, scene, shown, canvas.scale)
    if places[0].map.width < canvas.u(SMALLEST_MAP):
        canvas.no_room("the maps")
    for robot, tile_place in enumerate(places):
        driven = robot == min(2, shown - 1)
        _draw_tile_of(canvas, screen, scene, tile_place, robot, driven=driven)


def _draw_tile_of(
    canvas: Canvas,
    screen: PageScreen,
    scene: Scene,
    place: TilePlace,
    robot: int,
    *,
    driven: bool = True,
) -> None:
    """Draw a robot's tile, with the ring of the dwell if it is driven."""
    tile, pose = _tile(scene, robot)
    look = PlateLook(driven=driven, suggested=False, accept_key="", has_dwell=driven, note="",
                     has_health=screen.has_health)  # fmt: skip
    left = 0.62 if driven else -1.0
    shown = TileView(place, tile, look, pose, dwell_left=left, ground=palette.CARD)
    draw_tile(canvas, scene, shown)
