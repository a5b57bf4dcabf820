"""One robot's tile: its map, its robot, its plate and, where it applies, its frame."""

from __future__ import annotations

import dataclasses

import pygame

from study.events.scene import Scene
from study.shell.drawing import cues, frames, inset, landing, maps, marks, palette, plate
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.clips import clipped
from study.shell.drawing.looks import Body, Looks, TileView, has_picture, looks_of
from study.shell.drawing.pictures import draw_picture
from study.shell.drawing.robots import DRIVEN_SCALE, HALO, draw_robot

TRAIL_SIZES = (0.26, 0.2, 0.13)
CLOSING = 1 / 3
"""Share of the landing in which its rings close."""
FARTHEST = 6.6
"""Radii that marks and rings reach at most from a robot's middle."""
LARGE = -1
"""In place of a robot's number: whichever has the large tile."""


def draw_moved(
    canvas: Canvas, scene: Scene, shown: TileView, before: Looks, looks: Looks
) -> pygame.Rect | None:
    """Draw what changed of a tile where only a robot moved or a new picture came: much less of it.

    Args:
        canvas: to draw on; it still shows the tile as it was.
        scene: the map.
        shown: the tile.
        before: what `looks_of` said of it then.
        looks: what it says now.

    Returns:
        What was drawn anew, pixels; None if more than that changed, and nothing was drawn.
    """
    same = (before.still, before.health) == (looks.still, looks.health)
    # Rings and veils cover more than what lies round the robot.
    held = shown.tile.cue is not None and shown.tile.cue.kind == "held"
    if not same or held or shown.look.driven:
        return None
    if has_picture(scene, shown):
        return _draw_new_picture(canvas, scene, shown, fresh=before.shot != looks.shot)
    if before.shot != looks.shot:
        return None
    view = maps.MapView(scene, shown.place.map)
    places = _marks_place(view, before.body).union(_marks_place(view, looks.body))
    within = places.clip(shown.place.map).clip(canvas.surface.get_rect())
    robot = shown.tile.robot
    seat = LARGE if shown.place.single else robot
    if not canvas.repeat(("tile", seat), (robot, looks.still), within):
        return None
    if shown.look.has_health and not canvas.repeat(("health", seat), looks.health, within):
        return None
    _draw_on_map(canvas, view, shown, looks, within)
    return within


def _draw_new_picture(canvas: Canvas, scene: Scene, shown: TileView, *, fresh: bool) -> pygame.Rect:
    """Draw a tile's picture, or but its small map if the picture is no other; return where."""
    place = shown.place
    if fresh:
        draw_picture(canvas, shown.shot, place.map)
    drawn = place.map
    if scene.inset:
        small = inset.draw(
            canvas, scene, place, shown.pose, robot=shown.tile.robot, driven=shown.look.driven
        )
        drawn = place.map.union(small) if fresh else small
    return drawn.clip(canvas.surface.get_rect())


def draw_tile(canvas: Canvas, scene: Scene, shown: TileView, looks: Looks | None = None) -> None:
    """Draw a tile. All but its robot is painted anew only when it changes.

    Health changes often and on many tiles at once: it is kept apart from the rest.

    Args:
        canvas: to draw on.
        scene: the map.
        shown: the tile.
        looks: what `looks_of` says of it, where that is known.
    """
    with clipped(canvas.surface, frames.frame_rect(canvas, shown.place)):
        _draw_whole(canvas, scene, shown, looks or looks_of(scene, shown))


def _draw_whole(canvas: Canvas, scene: Scene, shown: TileView, looks: Looks) -> None:
    place, tile, look = shown.place, shown.tile, shown.look
    view = maps.MapView(scene, place.map)
    # Robots share the large tile, and what is remembered of it: a picture of each would fill
    # tens of megabytes.
    seat = LARGE if place.single else tile.robot
    canvas.remember(
        ("tile", seat),
        (tile.robot, looks.still),
        frames.frame_rect(canvas, place),
        lambda: _draw_still(canvas, scene, shown),
    )
    if look.has_health and not scene.pictures_only:
        row = plate.health_row(canvas, place)
        canvas.remember(
            ("health", seat),
            looks.health,
            row.place,
            lambda: plate.draw_health(canvas, row, tile, boxed=look.driven),
            # There is one large tile: what it looks like is of use to no other.
            alike=None if place.single else (row.place.size, row.text, row.pad, looks.health[1:]),
        )
    if has_picture(scene, shown):
        draw_picture(canvas, shown.shot, place.map)
        if scene.inset:
            inset.draw(canvas, scene, place, shown.pose, robot=tile.robot, driven=look.driven)
    else:
        _draw_on_map(canvas, view, shown, looks)
    if tile.cue is not None and tile.cue.kind == "held":
        cues.draw_veil(canvas, place.map)
    if shown.dwell_left >= 0:
        plate.draw_dwell(canvas, place, tile.robot, shown.dwell_left)
    if look.driven and place.single and shown.landing >= 0:
        text = canvas.say("Switched to robot {number}", number=tile.robot + 1)
        robot = view.robot_point(shown.pose.x, shown.pose.y, driven=True)
        with canvas.moving(), clipped(canvas.surface, place.body):
            landing.draw_label(canvas, view, robot, place.plate, text)


def _draw_on_map(
    canvas: Canvas,
    view: maps.MapView,
    shown: TileView,
    looks: Looks,
    within: pygame.Rect | None = None,
) -> None:
    """Draw the robot on its map, or as much of it as lies within a rectangle."""
    place, body = shown.place, looks.body
    # The plate belongs to the screen, not to the map: what reaches over it is cut off.
    clip = place.map if within is None else place.map.clip(within)
    covered = place.plate.clip(canvas.surface.get_rect() if within is None else within)
    still = (
        canvas.surface.subsurface(covered).copy()
        if _marks_place(view, body).colliderect(covered)
        else None
    )
    with clipped(canvas.surface, clip), canvas.moving():
        _draw_body(canvas, view, shown, body)
    if still is not None:
        canvas.surface.blit(still, covered)


def _marks_place(view: maps.MapView, body: Body) -> pygame.Rect:
    """Return what a robot and its marks reach at most, pixels."""
    reach = round(view.robot_radius * FARTHEST)
    return pygame.Rect(body.x - reach, body.y - reach, 2 * reach, 2 * reach)


def _draw_still(canvas: Canvas, scene: Scene, shown: TileView) -> None:
    """Draw all that does not move, but for the health."""
    place, tile, look = shown.place, shown.tile, shown.look
    canvas.surface.fill(shown.ground, frames.frame_rect(canvas, place))
    if look.driven:
        frames.driven_frame(canvas, place, tile.robot, announced=look.announced, arrows=look.arrows)
    elif look.suggested:
        frames.suggested_frame(canvas, place, tile.robot, look.accept_key)
    tint = plate.plate_colour(place, tile, look)
    floor = palette.CARD if look.driven else palette.FLOOR
    if has_picture(scene, shown):
        # Beside a picture of another shape there is floor, not a strip of the map.
        scene = dataclasses.replace(scene, rectangles=(), discs=(), gates=())
    maps.draw_map(canvas, scene, place.map, floor, palette.PLATE, tint)
    if not place.has_corner_plate:
        canvas.surface.fill(tint, place.plate)
    plate.draw_plate(canvas, place, tile, look)


def _draw_body(canvas: Canvas, view: maps.MapView, shown: TileView, body: Body) -> None:
    """Draw the robot with its trail and the marks of its cue."""
    tile, look, pose = shown.tile, shown.look, shown.pose
    radius = view.robot_radius
    x, y = body.x, body.y
    if tile.cue is not None:
        if tile.cue.kind == "goal":
            _reached_goal(canvas, view)
        cues.draw_mark(canvas, tile.cue, x, y, radius, driven=look.driven)
    for dot, size in zip(body.trail, TRAIL_SIZES, strict=False):
        marks.disc(canvas, *dot, max(1.0, radius * size), palette.TRAIL)
    if look.suggested:
        marks.dashed_ring(
            canvas, x, y, radius * 2.2, max(1.5, radius * 0.16), palette.INK, fill=palette.CARD
        )
    if look.driven and 0 <= shown.landing < CLOSING:
        _landing_rings(canvas, x, y, radius * DRIVEN_SCALE, shown.landing / CLOSING)

    def walls() -> None:
        # What lies on the floor round a robot ends at the walls, not somewhere on them.
        maps.draw_outer_walls(canvas, view)

    if not look.driven and (look.suggested or tile.cue is not None):
        walls()
    draw_robot(
        canvas, x, y, radius, pose.heading, driven=look.driven, label=str(tile.robot + 1),
        over_ring=walls,
    )  # fmt: skip


def _reached_goal(canvas: Canvas, view: maps.MapView) -> None:
    for disc in view.scene.discs:
        if disc.role == "goal":
            x, y = view.point(disc.x, disc.y)
            radius = maps.disc_radius(view, disc) * 1.15
            marks.disc(canvas, x, y, radius, palette.GREEN_TEXT)
            marks.tick(canvas, x, y, radius * 1.2, palette.CARD, radius * 0.2)


def _landing_rings(canvas: Canvas, x: float, y: float, radius: float, share: float) -> None:
    """Draw two rings that close on the robot."""
    for start, share_of_blue in ((5.2, 0.35), (3.9, 0.6)):
        reach = radius * (start + (HALO + 0.15 - start) * share)
        colour = palette.mixed(palette.BLUE, palette.CARD, share_of_blue)
        marks.passing_ring(canvas, x, y, reach, max(1.5, radius * 0.08), colour)
