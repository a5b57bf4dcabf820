"""The fleet run: header with progress and time, the tiles, the legend."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import pygame

from study.events.scene import Role
from study.messages import Messages, noted
from study.screens import FleetScreen, Tile
from study.shell.drawing import chrome, frames, header, legend, palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.fleet_places import NOBODY, NOBODY_SIZE, Layout, layout, nobody_room
from study.shell.drawing.grid import TilePlace
from study.shell.drawing.looks import Looks, TileView, looks_of
from study.shell.drawing.motion import Motion, Pose, fraction
from study.shell.drawing.pictures import Pictures, Shot
from study.shell.drawing.plate import PlateLook
from study.shell.drawing.rehearsal import all_cues, rehearsal
from study.shell.drawing.robots import HEADING_STEPS, HEADINGS
from study.shell.drawing.tile import draw_moved, draw_tile

SWITCHED = noted("Switched to robot {number}")


class FleetPainter:
    """Draws fleet runs, picture by picture: what did not change is left standing.

    Args:
        pictures: of the robots, where the task takes some.

    Attributes:
        motion: where the robots were before; it takes note of every screen drawn.
    """

    def __init__(self, pictures: Pictures | None = None) -> None:
        self.motion = Motion()
        self._pictures = pictures or Pictures()
        self._ground: object = None
        self._shown: dict[tuple[int, bool], Looks] = {}
        self._strips: object = None
        self._laid_out: tuple[object, Layout] | None = None

    def draw(
        self, canvas: Canvas, screen: FleetScreen, now_ns: int, *, onto: bool
    ) -> list[pygame.Rect] | None:
        """Draw the screen as it is at a session time.

        Args:
            canvas: to draw on.
            screen: what is shown.
            now_ns: session time.
            onto: whether the canvas still shows the picture drawn last.

        Returns:
            The places that changed, pixels; None if all of it did.
        """
        self.motion.observe(screen)
        places = self._layout(canvas, screen)
        since = (now_ns - screen.switched_ns) / 1e9 if screen.switched_ns >= 0 else -1.0
        message = _message(canvas.messages, screen, since, enlarged=places.large is not None)
        ground = (canvas.scale, places, message, screen.operated < 0, bool(screen.tiles))
        whole = not onto or ground != self._ground
        if whole:
            canvas.surface.fill(palette.PAGE)
            self._shown.clear()
            self._strips = None
        self._ground = ground
        over_legend = bool(message) and places.message > canvas.size[1] - legend.height(canvas)
        changed = self._draw_strips(canvas, screen, legend_shown=not over_legend)
        if over_legend and changed:
            _draw_message(canvas, message, places.message)
        for shown in self._views(canvas, screen, places, now_ns, since):
            name = (shown.tile.robot, shown.place.single)
            looks = looks_of(screen.scene, shown)
            before = self._shown.get(name)
            if before == looks:
                continue
            self._shown[name] = looks
            moved = before and draw_moved(canvas, screen.scene, shown, before, looks)
            if not moved:
                draw_tile(canvas, screen.scene, shown, looks)
            changed.append(moved or frames.frame_rect(canvas, shown.place))
        # The operated robot's large tile replaces another's in the same place.
        for name in [n for n in self._shown if n[1] and n[0] != screen.operated]:
            if places.large is not None:
                del self._shown[name]
        if whole:
            _draw_nobody(canvas, screen, places)
        # A tile painted anew paints its bar's place, too, and the line may stand there.
        if message and not over_legend and (whole or changed):
            _draw_message(canvas, message, places.message)
        return None if whole else changed

    def rehearsal(self, canvas: Canvas, screen: FleetScreen) -> Iterator[None]:
        """Paint, step by step and out of sight, what may be seen in the fleet run of a screen.

        Of the first robot that is the tile and the large tile, driven and not driven, in all
        states; besides all robots' numbers, digits of their health, and headings.
        """
        # The line of guidance is there for moments only, and where it is tiles are smaller.
        screen = dataclasses.replace(screen, message="")
        for tile in screen.tiles[:1]:
            for operated in (tile.robot, -1):
                views = self._views_alone(canvas, screen, tile, operated)
                yield from rehearsal(canvas, screen.scene, views, all_cues(canvas.messages))
            for number in range(max(screen.robots, HEADINGS)):
                robot = number % screen.robots
                other = dataclasses.replace(tile, robot=robot, health=9.0 * number % 101)
                pose = Pose(tile.x, tile.y, 2 * math.pi * number / HEADING_STEPS, ())
                for operated in (robot, -1):
                    views = self._views_alone(canvas, screen, other, operated)
                    turned = [dataclasses.replace(view, pose=pose) for view in views]
                    yield from rehearsal(canvas, screen.scene, turned, [None])

    def _views_alone(
        self, canvas: Canvas, screen: FleetScreen, tile: Tile, operated: int
    ) -> list[TileView]:
        """Return a tile where the first one goes, and as the large one if its robot is operated."""
        screen = dataclasses.replace(screen, operated=operated)
        places = layout(canvas, screen)
        alone = dataclasses.replace(screen, tiles=(tile,))
        one = dataclasses.replace(places, tiles=places.tiles[:1])
        return self._views(canvas, alone, one, screen.t_ns, -1.0)

    def _layout(self, canvas: Canvas, screen: FleetScreen) -> Layout:
        """Return where a screen's parts go; thought out anew only if that may have changed."""
        key = (
            canvas.size, canvas.scale, screen.view, screen.robots, screen.operated,
            screen.suggested, bool(screen.message), tuple(tile.robot for tile in screen.tiles),
            screen.scene,
        )  # fmt: skip
        if self._laid_out is None or self._laid_out[0] != key:
            self._laid_out = (key, layout(canvas, screen))
        return self._laid_out[1]

    def _draw_strips(
        self, canvas: Canvas, screen: FleetScreen, *, legend_shown: bool
    ) -> list[pygame.Rect]:
        """Draw header and legend, which change at most a few times a second."""
        width, height = canvas.size
        items = tuple(_legend_items(screen))
        key = header.key(canvas, screen)
        if self._strips == (key, items):
            return []
        self._strips = (key, items)
        top = pygame.Rect(0, 0, width, chrome.header_height(canvas))
        canvas.remember("header", key, top, lambda: header.draw(canvas, screen))
        low = legend.height(canvas)
        bottom = pygame.Rect(0, height - low, width, low)
        if legend_shown:
            canvas.remember("legend", items, bottom, lambda: legend.draw(canvas, list(items)))
        else:
            legend.draw(canvas, [])
        return [top, bottom]

    def _views(
        self, canvas: Canvas, screen: FleetScreen, places: Layout, now_ns: int, since: float
    ) -> list[TileView]:
        """Return every tile to be drawn, the enlarged one last."""
        drawn = list(zip(screen.tiles, places.tiles, strict=True))
        if places.large is not None:
            drawn += [(t, places.large) for t in screen.tiles if t.robot == screen.operated]
        arrows = _arrows_drive(screen)
        return [
            self._view(canvas, screen, tile, place, now_ns, since, arrows=arrows)
            for tile, place in drawn
        ]

    def _view(
        self,
        canvas: Canvas,
        screen: FleetScreen,
        tile: Tile,
        place: TilePlace,
        now_ns: int,
        since: float,
        *,
        arrows: bool,
    ) -> TileView:
        driven = tile.robot == screen.operated
        dwell_left = self.motion.dwell_left(screen, now_ns) if driven else -1.0
        look = PlateLook(
            driven=driven,
            suggested=tile.robot == screen.suggested and not driven,
            accept_key=screen.accept_key,
            has_dwell=dwell_left >= 0,
            note=_note(canvas.messages, screen) if place.single else "",
            key=_own_key(screen, tile.robot),
            announced=driven and screen.switch_seconds_left >= 0,
            has_health=screen.has_health,
            arrows=arrows,
        )
        return TileView(
            place=place,
            tile=tile,
            look=look,
            pose=self.motion.pose(screen, tile, now_ns),
            landing=_landing(screen, since) if driven else -1.0,
            dwell_left=dwell_left,
            shot=self._shot(screen, tile, now_ns) if screen.scene.camera else None,
        )

    def _shot(self, screen: FleetScreen, tile: Tile, now_ns: int) -> Shot:
        """Return the picture of a robot as far on its way as its place on the map would be."""
        share = fraction(now_ns, screen.t_ns, screen.timestep_seconds)
        return self._pictures.of(tile.robot, share)


def _landing(screen: FleetScreen, since: float) -> float:
    """Return the share of the landing's time that has passed ``since`` s after it; -1 after it."""
    return since / screen.landing_seconds if 0 <= since < screen.landing_seconds else -1.0


def _message(messages: Messages, screen: FleetScreen, since: float, *, enlarged: bool) -> str:
    """Return the line of guidance; after an automatic switch the name of the robot."""
    if screen.message:
        return screen.message
    tiled = screen.view == "tiles" and screen.robots > 1 and not enlarged
    if tiled and screen.allocation == "assisted" and _landing(screen, since) >= 0:
        return messages.say(SWITCHED, number=screen.operated + 1)
    return ""


def _own_key(screen: FleetScreen, robot: int) -> str:
    """Return the key that chooses a robot if it is not the robot's number."""
    key = screen.robot_keys[robot] if robot < len(screen.robot_keys) else ""
    return "" if key == str(robot + 1) else key


def _arrows_drive(screen: FleetScreen) -> bool:
    """Whether all four arrow keys drive, and nothing else."""
    tokens = set(chrome.key_tokens(screen.keys[0][0])) if screen.keys else set()
    return tokens in (set(chrome.ARROWS), set(chrome.ARROW_NAMES))


def _note(messages: Messages, screen: FleetScreen) -> str:
    others = screen.robots - 1
    if screen.view == "operated_only" and others > 0:
        return messages.count(
            "The other robot drives itself.", "The other {n} robots drive themselves.", others
        )
    return ""


def _legend_items(screen: FleetScreen) -> list[legend.Item]:
    scene = screen.scene
    if scene.camera and not scene.inset:
        # Of all that is drawn only the frame of a suggestion is ours.
        return ["suggested"] if screen.allocation == "suggested" else []
    roles = {mark.role for mark in scene.rectangles} | {disc.role for disc in scene.discs}
    one_tile = len(screen.tiles) <= 1
    items: list[legend.Item] = []
    if screen.allocation != "none":
        items.append("driven")
    if not one_tile or screen.operated < 0:
        items.append("autonomous")
    if screen.allocation == "suggested":
        items.append("suggested")
    ordered: tuple[Role, ...] = ("hazard", "health_pack", "start", "goal")
    items += [role for role in ordered if role in roles]
    if not one_tile:
        items.append("stuck")
    return items


def _draw_nobody(canvas: Canvas, screen: FleetScreen, places: Layout) -> None:
    """Say that no robot is driven where one would be shown."""
    size = canvas.u(26)
    if places.large is not None and screen.operated < 0:
        body = places.large.body
        canvas.box(body, canvas.u(10), palette.CARD, palette.EDGE, canvas.u(1.4))
        room = nobody_room(canvas, body)
        canvas.paragraph(canvas.say(NOBODY), room, canvas.u(NOBODY_SIZE), weight="semibold",
                         colour=palette.SECONDARY, align="centre")  # fmt: skip
    elif not screen.tiles:
        canvas.write(
            canvas.say(NOBODY), canvas.size[0] / 2, canvas.size[1] / 2, size, weight="semibold",
            colour=palette.SECONDARY, align="centre", width=canvas.size[0] - canvas.u(48),
        )  # fmt: skip


def _draw_message(canvas: Canvas, message: str, y: int) -> None:
    """Draw one line of guidance with its middle at y."""
    size, height = canvas.u(20), canvas.u(32)
    width = canvas.text_width(message, size, "semibold") + canvas.u(40)
    box = pygame.Rect(0, 0, min(width, canvas.size[0] - canvas.u(32)), height)
    box.center = (canvas.size[0] // 2, y)
    canvas.box(box, canvas.u(8), palette.INK)
    canvas.write(
        message, box.centerx, box.centery, size, weight="semibold",
        colour=palette.CARD, align="centre", width=box.width - canvas.u(24),
    )  # fmt: skip
