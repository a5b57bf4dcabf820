"""The map as data: drawing, grid and legal floor agree, and bad maps are refused."""

from __future__ import annotations

import dataclasses

import pytest

from study.errors import UnknownNameError
from study.layouts import Disc, Door, Layout, Rectangle, named_layout

TWO_ROOMS = Layout(
    width=8.0,
    height=4.0,
    rooms=(Rectangle(0, 0, 4, 4), Rectangle(4, 0, 8, 4)),
    doors=(Door((0, 1), "vertical", 4.0, 1.0, 3.0),),
    hazards=(),
    packs=(),
    start=Rectangle(0, 0, 4, 4),
    start_mark=Disc(1, 1, 0.5),
    goal=Disc(7, 2, 0.5),
    robot_radius=0.3,
)


def test_the_plate_is_the_empty_quadrant() -> None:
    """The three rooms leave exactly the top left quadrant to the tile's number."""
    assert named_layout("three_rooms").scene().plate == (0.0, 7.0, 9.4, 8.0)


def test_a_full_map_has_no_plate() -> None:
    """Rooms that fill the bounds leave no plate."""
    assert TWO_ROOMS.plate() is None


def test_walls_leave_the_doors_open() -> None:
    """No wall is drawn across a door's gap, and walls stop exactly at its ends."""
    walls = [
        wall for wall in TWO_ROOMS.walls() if wall.left < 4 < wall.right and wall.height > 1e-9
    ]
    upright = [(wall.bottom, wall.top) for wall in walls if wall.width < 1]
    assert upright == [(0, 1.0), (3.0, 4)]


def test_walls_are_drawn_once_and_within_the_map() -> None:
    """Rooms that share a wall do not draw it twice, and no wall leaves the bounds."""
    layout = named_layout("three_rooms")
    walls = layout.walls()
    assert len(walls) == 8
    for number, wall in enumerate(walls):
        assert Rectangle(0, 0, layout.width, layout.height).encloses(wall)
        assert wall not in walls[:number]


def test_the_scene_shows_everything_in_the_layout() -> None:
    """Rooms, hazards, packs, goal and start all have their marks."""
    scene = named_layout("three_rooms").scene()
    roles = [mark.role for mark in scene.rectangles] + [mark.role for mark in scene.discs]
    counts = {
        role: roles.count(role) for role in ("room", "hazard", "health_pack", "goal", "start")
    }
    assert counts == {"room": 3, "hazard": 3, "health_pack": 3, "goal": 1, "start": 1}


def test_grid_cells_are_free_where_a_robot_fits() -> None:
    """Cells of the rooms are free, cells of the empty quadrant are not."""
    grid = named_layout("three_rooms").map_grid(0.5, (0.0,), (50.0,))
    assert (len(grid.ys), len(grid.xs)) == (30, 40)
    assert grid.xs[0] == 0.25
    for y, row in zip(grid.ys, grid.free, strict=True):
        for x, free in zip(grid.xs, row, strict=True):
            assert free == ("0" if x < 9.4 and y > 7.0 else "1"), (x, y)


def test_a_passage_is_narrower_than_its_gap() -> None:
    """A robot's centre keeps its radius from both ends of a door."""
    assert TWO_ROOMS.doors[0].passage(0.25) == Rectangle(3.75, 1.25, 4.25, 2.75)


@pytest.mark.parametrize(
    ("doors", "reason"),
    [
        ((), "form no tree"),
        ((Door((0, 1), "vertical", 5.0, 1.0, 3.0),), "is not in a wall"),
        ((Door((0, 1), "vertical", 4.0, 1.0, 1.5),), "no robot fits"),
        (
            (Door((0, 1), "vertical", 4.0, 1.0, 2.0), Door((0, 1), "vertical", 4.0, 2.5, 3.5)),
            "form no tree",
        ),
    ],
    ids=["no door", "not in the wall", "too narrow", "a circle"],
)
def test_impossible_maps_are_refused(doors: tuple[Door, ...], reason: str) -> None:
    """Rooms that doors do not join to a tree of shared walls are no layout."""
    with pytest.raises(ValueError, match=reason):
        dataclasses.replace(TWO_ROOMS, doors=doors)


def test_an_unknown_layout_names_the_nearest() -> None:
    """A misspelt name is answered by the right one."""
    with pytest.raises(UnknownNameError, match="three_rooms"):
        named_layout("three_room")
