"""Interpolation, trails and layout: plain geometry."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import pygame
import pytest
from hypothesis import given
from hypothesis import strategies as st

import sample_screens as samples
from study.screens import FleetScreen, Tile
from study.shell.drawing import palette
from study.shell.drawing.grid import place_tiles
from study.shell.drawing.leaders import spread
from study.shell.drawing.maps import DRIVEN_REACH, MapView
from study.shell.drawing.motion import Motion, along_trail, between, fraction

ANGLE = st.floats(-10, 10)
STEP_NS = round(samples.STEP * 1e9)


def at(x: float, heading: float = 0.0, *, episode: int = 1, robot: int = 0) -> Tile:
    return Tile(robot=robot, x=x, y=2.0, heading=heading, health=100.0, cue=None, episode=episode)


def screen(tile: Tile, timestep: int, **changes: object) -> FleetScreen:
    base = samples.fleet(1, operated=0)
    base = dataclasses.replace(base, tiles=(tile,), timestep=timestep, t_ns=timestep * STEP_NS)
    return dataclasses.replace(base, **changes)  # type: ignore[arg-type]


def test_fraction_runs_from_zero_to_one() -> None:
    """The share passed is 0 at the states, 1 a timestep later, and stays within."""
    assert fraction(100, 100, 0.1) == 0.0
    assert fraction(100 + 50_000_000, 100, 0.1) == pytest.approx(0.5)
    assert fraction(0, 100, 0.1) == 0.0
    assert fraction(10**12, 100, 0.1) == 1.0
    assert fraction(5, 0, 0.0) == 1.0


@given(before=ANGLE, after=ANGLE, share=st.floats(0, 1))
def test_heading_turns_the_shorter_way(before: float, after: float, share: float) -> None:
    """On the way no heading is further than half a turn from either end, and both are met."""
    turned = between(at(0, before), at(1, after), share).heading - before
    assert abs(turned) <= math.pi * share + 1e-9
    end = between(at(0, before), at(1, after), 1.0).heading
    assert math.cos(end) == pytest.approx(math.cos(after), abs=1e-9)
    assert math.sin(end) == pytest.approx(math.sin(after), abs=1e-9)


def test_robot_is_drawn_one_timestep_behind() -> None:
    """When states come the robot stands at the ones before; a timestep later at these."""
    motion, first, second = Motion(), screen(at(1.0), 1), screen(at(2.0), 2)
    motion.observe(first)
    assert motion.pose(first, first.tiles[0], first.t_ns).x == 1.0
    motion.observe(second)
    xs = [
        motion.pose(second, second.tiles[0], second.t_ns + share * STEP_NS // 4).x
        for share in range(5)
    ]
    assert xs == pytest.approx([1.0, 1.25, 1.5, 1.75, 2.0])


def test_same_states_again_change_nothing() -> None:
    """A screen that only differs in what is written keeps the robot on its way."""
    motion, first, second = Motion(), screen(at(1.0), 1), screen(at(2.0), 2)
    motion.observe(first)
    motion.observe(second)
    again = dataclasses.replace(second, operated=-1)
    motion.observe(again)
    assert motion.pose(again, again.tiles[0], again.t_ns + STEP_NS // 2).x == pytest.approx(1.5)


@pytest.mark.parametrize(
    "after",
    [
        screen(at(9.0, episode=2), 2),
        screen(at(9.0), 2, robots=2),
        screen(at(9.0), 2, trial=4),
        screen(at(9.0), 40),
        screen(at(9.0), 0),
        screen(at(9.0, robot=1), 2),
    ],
    ids=["episode", "robots", "trial", "gap", "backwards", "other robot"],
)
def test_no_interpolation_across_a_break(after: FleetScreen) -> None:
    """After a new start the robot is at once where it is."""
    motion = Motion()
    motion.observe(screen(at(1.0), 1))
    motion.observe(after)
    pose = motion.pose(after, after.tiles[0], after.t_ns)
    assert pose.x == 9.0
    assert pose.trail == ((9.0, 2.0),)


def test_trail_begins_at_the_robot_and_goes_back() -> None:
    """The trail leads from where the robot is drawn back over the places it passed."""
    motion, last = Motion(), screen(at(0.0), 0)
    for step in range(6):
        last = screen(at(float(step)), step)
        motion.observe(last)
    trail = motion.pose(last, last.tiles[0], last.t_ns + STEP_NS // 2).trail
    assert [x for x, _ in trail] == pytest.approx([4.5, 4.0, 3.0, 2.0, 1.0, 0.0])


@given(st.lists(st.tuples(st.floats(0, 20), st.floats(0, 20)), min_size=2, max_size=8))
def test_trail_points_lie_at_their_distances(path: list[tuple[float, float]]) -> None:
    """There are as many points as the path is long enough for."""
    length = sum(math.dist(a, b) for a, b in pairwise(path))
    distances = (1.0, 2.0, 4.0)
    found = along_trail(tuple(path), distances)
    assert len(found) in {
        sum(distance <= length + slack for distance in distances) for slack in (-1e-6, 0, 1e-6)
    }
    assert all(math.dist(path[0], p) <= d + 1e-6 for p, d in zip(found, distances, strict=False))


def test_dwell_drains_smoothly_and_refills_at_once() -> None:
    """Between timesteps the ring shrinks evenly; a new dwell is full at once."""
    motion = Motion()
    first, second = screen(at(1), 1, dwell_left=0.5), screen(at(1), 2, dwell_left=0.4)
    full = screen(at(1), 3, dwell_left=1.0)
    motion.observe(first)
    motion.observe(second)
    assert motion.dwell_left(second, second.t_ns + STEP_NS // 2) == pytest.approx(0.45)
    motion.observe(full)
    assert motion.dwell_left(full, full.t_ns) == 1.0


@given(
    tiles=st.integers(1, 60),
    size=st.sampled_from([(1280, 620), (1280, 840), (1920, 950), (2560, 1300)]),
    plate=st.booleans(),
)
def test_tiles_fit_the_area(tiles: int, size: tuple[int, int], *, plate: bool) -> None:
    """Tiles with their bars lie within the area, apart from one another, in the map's shape."""
    area = pygame.Rect((0, 64), size)
    scene = samples.SCENE if plate else samples.FULL_SCENE
    places = place_tiles(area, scene, tiles, 1.0)
    assert len(places) == tiles
    bodies = []
    for place in places:
        whole = place.body.inflate(12, 12)
        whole.top -= place.bar - 6 if place.bar else 0
        assert area.contains(place.body)
        assert place.body.top - place.bar >= area.top
        assert place.map.width / place.map.height == pytest.approx(4 / 3, rel=0.03)
        bodies.append(place.body)
    assert all(body.collidelistall(bodies) == [index] for index, body in enumerate(bodies))


@given(
    wanted=st.lists(st.floats(0, 400), min_size=1, max_size=6).map(sorted),
    pitch=st.floats(1, 60),
)
def test_names_beside_a_map_keep_apart(wanted: list[float], pitch: float) -> None:
    """Places stay within bounds and in order, a pitch apart where there is room."""
    places = spread(wanted, 0.0, 400.0, pitch)
    room = 400.0 / max(1, len(wanted) - 1)
    for upper, lower in pairwise(places):
        assert lower - upper >= min(pitch, room) - 1e-6
    assert places[0] >= -1e-6
    assert places[-1] <= 400.0 + 1e-6


@pytest.mark.parametrize(
    ("text", "ground"),
    [
        (palette.INK, palette.PAGE),
        (palette.SECONDARY, palette.PAGE),
        (palette.SECONDARY, palette.BLUE_TINT),
        (palette.SECONDARY, palette.YELLOW_TINT),
        (palette.CARD, palette.BLUE),
        (palette.BLUE_DARK, palette.BLUE_TINT),
        (palette.INK, palette.ORANGE),
        (palette.INK, palette.YELLOW),
        (palette.CARD, palette.GREEN_TEXT),
        (palette.CARD, palette.VERMILLION_TEXT),
        (palette.VERMILLION_TEXT, palette.CARD),
        (palette.GREEN_TEXT, palette.CARD),
        (palette.CARD, palette.AUTONOMOUS),
        (palette.CARD, palette.EDGE),
    ],
)
def test_text_has_contrast(text: palette.Colour, ground: palette.Colour) -> None:
    """Every pair of text and ground reaches WCAG's ratio of 4.5."""
    assert palette.contrast(text, ground) >= 4.5


@given(st.floats(0.0, 20.0), st.floats(0.0, 15.0), st.booleans())
def test_bodies_stay_clear_of_edges_and_plate(x: float, y: float, driven: bool) -> None:
    """Whoever stands at an outer wall or at the plate's is drawn a body's reach away from it."""
    scene = samples.fleet(4).scene
    assert scene.plate is not None
    left, low, width, height = scene.plate
    if left - 0.01 < x < left + width + 0.01 and low - 0.01 < y < low + height + 0.01:
        return
    view = MapView(scene, pygame.Rect(100, 50, 400, 300))
    reach = view.robot_radius * (DRIVEN_REACH if driven else 1.0)
    across, down = view.robot_point(x, y, driven=driven)
    assert view.place.inflate(-2 * reach + 2, -2 * reach + 2).collidepoint(across, down)
    (near, bottom), (far, top) = view.point(left, low), view.point(left + width, low + height)
    apart = math.hypot(across - min(max(across, near), far), down - min(max(down, top), bottom))
    assert apart >= reach - 1
