"""The WAD that is written of a layout: read back, it is the layout. No engine is needed."""

from __future__ import annotations

import hashlib
import re
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.layouts import Disc, Door, Layout, Rectangle, named_layout
from study.tasks._doom.acs import Op, Program
from study.tasks._doom.plane import GRID, UNITS, Line, cut_lines, player_radius
from study.tasks._doom.wad import Motion, write_wad
from study.terrain import Terrain

THREE_ROOMS = named_layout("three_rooms")
EXACT = Motion(forward=0.5, back=0.3, stock=False, damage=5.0, heal=10.0)


def _lumps(wad: bytes) -> dict[str, bytes]:
    """Read a WAD's directory."""
    kind, count, directory = struct.unpack_from("<4sII", wad)
    assert kind == b"PWAD"
    found = {}
    for number in range(count):
        place, size, name = struct.unpack_from("<II8s", wad, directory + 16 * number)
        found[name.rstrip(b"\0").decode()] = wad[place : place + size]
    assert directory + 16 * count == len(wad)
    return found


def _blocks(text: str, kind: str) -> list[dict[str, str]]:
    """Read the blocks of one kind of a UDMF map."""
    return [
        dict(re.findall(r"(\w+)=([^;]+);", inside))
        for inside in re.findall(rf"^{kind} {{([^}}]*)}}", text, re.M)
    ]


def _kind_at(lines: list[Line], x: float, y: float) -> tuple[str, int] | None:
    """Return what is at a place: what faces the first line that a ray to the right meets."""
    best, found = float("inf"), None
    for line in lines:
        (ax, ay), (bx, by) = line.start, line.end
        if (ay > y) != (by > y):
            crossing = ax + (y - ay) / (by - ay) * (bx - ax)
            if x < crossing < best:
                # A line that goes up has its front on the right, away from us.
                best, found = crossing, line.back if by > ay else line.front
    return found


def test_a_layout_always_gives_the_same_bytes() -> None:
    """The map is part of what makes a recording repeatable."""
    first, second = (write_wad(THREE_ROOMS, EXACT) for _ in range(2))
    assert first == second
    assert list(_lumps(first)) == [
        "DECORATE", "ZMAPINFO", "MAP01", "TEXTMAP", "BEHAVIOR", "ENDMAP",
    ]  # fmt: skip
    assert (
        hashlib.sha256(first).digest()
        != hashlib.sha256(
            write_wad(THREE_ROOMS, Motion(0.4, 0.3, stock=False, damage=5.0, heal=10.0))
        ).digest()
    )


def test_the_map_read_back_is_whole() -> None:
    """Every number refers to something; every side faces a sector; things are where they were."""
    text = _lumps(write_wad(THREE_ROOMS, EXACT))["TEXTMAP"].decode()
    vertices, lines, sides, sectors, things = (
        _blocks(text, kind) for kind in ("vertex", "linedef", "sidedef", "sector", "thing")
    )
    used = []
    for line in lines:
        assert line["v1"] != line["v2"]
        assert max(int(line["v1"]), int(line["v2"])) < len(vertices)
        used += [int(line[side]) for side in ("sidefront", "sideback") if side in line]
        assert ("sideback" in line) == (line.get("twosided") == "true")
        assert ("sideback" in line) != (line.get("blocking") == "true")
    assert sorted(used) == list(range(len(sides)))
    assert {int(side["sector"]) for side in sides} == set(range(len(sectors)))
    places = {(int(thing["type"]), float(thing["x"]), float(thing["y"])) for thing in things}
    start, goal = THREE_ROOMS.start_mark, THREE_ROOMS.goal
    assert places == {
        (1, start.x * UNITS, start.y * UNITS),
        (20001, goal.x * UNITS, goal.y * UNITS),
        *((20000, pack.x * UNITS, pack.y * UNITS) for pack in THREE_ROOMS.packs),
    }


def test_walls_stop_a_player_where_they_stop_a_robot() -> None:
    """A square of the player's size fits into the cut floor just where a centre is legal."""
    lines = cut_lines(THREE_ROOMS)
    walls = np.array([(*line.start, *line.end) for line in lines if line.back is None])
    walls = walls / (UNITS * GRID)
    low, high = np.minimum(walls[:, :2], walls[:, 2:]), np.maximum(walls[:, :2], walls[:, 2:])
    half = player_radius(THREE_ROOMS) / UNITS
    random = np.random.default_rng(1)
    places = random.uniform((0, 0), (THREE_ROOMS.width, THREE_ROOMS.height), (4000, 2))
    legal = Terrain(THREE_ROOMS).is_legal(places[:, 0], places[:, 1])
    for place, expected in zip(places, legal, strict=True):
        touches = ((place + half > low) & (place - half < high)).all(axis=1).any()
        on_floor = _kind_at(lines, *(place * UNITS * GRID)) is not None
        assert (on_floor and not touches) == expected, place


@given(st.floats(0.36, 19.64), st.floats(0.36, 14.64))
def test_floors_are_painted_as_the_layout_has_them(x: float, y: float) -> None:
    """Hazards, packs and goal are seen where they act."""
    terrain = Terrain(THREE_ROOMS)
    at = np.array([x]), np.array([y])
    near = np.array([x - 0.02, x + 0.02, x, x]), np.array([y, y, y - 0.02, y + 0.02])
    kind = _kind_at(cut_lines(THREE_ROOMS), x * UNITS * GRID + 0.5, y * UNITS * GRID + 0.5)
    if not terrain.is_legal(*near).all():
        return
    assert kind is not None
    # A disc is painted as a polygon of sixteen corners, which is a little smaller.
    for name, ask in (("hazard", terrain.in_hazard), ("pack", terrain.at_pack)):
        if len({*ask(*near).tolist(), *ask(*at).tolist()}) == 1:
            assert (kind[0] == name) == bool(ask(*at)[0])


def test_a_disc_across_two_floors_is_refused() -> None:
    """A layout that cannot be cut says why."""
    room = Rectangle(0.0, 0.0, 10.0, 10.0)
    crossing = Layout(
        width=20.0,
        height=10.0,
        rooms=(room, Rectangle(10.0, 0.0, 20.0, 10.0)),
        doors=(Door((0, 1), "vertical", 10.0, 4.0, 6.0),),
        hazards=(Rectangle(3.0, 3.0, 5.0, 5.0),),
        packs=(Disc(5.0, 4.0, 0.5),),
        start=room,
        start_mark=Disc(1.0, 1.0, 0.5),
        goal=Disc(15.0, 5.0, 1.0),
        robot_radius=0.35,
    )
    with pytest.raises(ValueError, match="one kind of floor"):
        cut_lines(crossing)


def test_scripts_are_words_and_labels_are_addresses() -> None:
    """The directory points at each script's first instruction, a jump at its label's."""
    program = Program()
    program.script(7, 2)
    program.label("again")
    program.push(5)
    program.add(Op.DELAY, Op.GO, "again")
    program.script(8, 0, at_enter=True)
    program.add(Op.TERMINATE)
    behavior = program.behavior()
    words = struct.unpack(f"<{len(behavior) // 4}i", behavior)
    assert behavior[:4] == b"ACS\0"
    assert words[1] == 4 * 8
    assert words[2:8] == (Op.PUSH, 5, Op.DELAY, Op.GO, 8, Op.TERMINATE)
    assert words[8:] == (2, 7, 8, 2, 4008, 28, 0, 0)
