"""The map as the engine reads it: a WAD written from a layout, always the same bytes.

Nothing of the engine's or of its game files is copied: the WAD names textures and sprites that
the game file beside it has. The engine builds the rest (nodes, blockmap) when it loads the map.
"""

from __future__ import annotations

import dataclasses
import struct

from study.layouts import Layout
from study.tasks._doom.acs import FIXED, SET_VELOCITY, Op, Program
from study.tasks._doom.conventions import (
    HEALTH,
    LIVE,
    MAP,
    PLACED,
    SET_STATE,
    SET_VELOCITY_FIRST,
    TICS,
    TIMESTEPS,
)
from study.tasks._doom.plane import GRID, UNITS, Kind, cut_lines, on_grid, player_radius
from study.tasks._navigation_parameters import FULL_HEALTH

_PHASE, _VELOCITY_X, _VELOCITY_Y = range(3)
"""Variables of the map: tics of this timestep, velocity of the next placing."""

_WALK, _RUN = 25, 50
"""What the engine's walking and running give as a command, before a player's own factor."""

_EXACT_PUSH, _STOCK_PUSH = 32 / 65536, 2048 / 65536
"""Map units a tic that a command of 1 pushes: with friction 0 and with the engine's own."""

_STOCK_KEPT = 0xE800 / 65536
"""How much of its velocity a player keeps from tic to tic with the engine's own friction."""

_FLOORS = {"room": "FLOOR4_8", "hazard": "FLOOR1_6", "goal": "GRNLITE1"}
_FLOORS |= {"pack": "FLAT22", "start": "FLAT5_4"}
_WALLS = ("STONE2", "BROWN1", "BIGBRIK1", "GRAY1")


@dataclasses.dataclass(frozen=True, slots=True)
class Motion:
    """How the player moves and what the floor does to it.

    Attributes:
        forward, back: way of one timestep, metres; with stock motion the way at full speed.
        stock: whether the engine's own friction acts: a player speeds up and coasts.
        damage: health lost per timestep in a hazard, points.
        heal: health gained per timestep on a pack, points.
    """

    forward: float
    back: float
    stock: bool
    damage: float
    heal: float


def write_wad(layout: Layout, motion: Motion) -> bytes:
    """Return the WAD of a map.

    Raises:
        ValueError: the layout cannot be cut into sectors (`plane.cut_lines`).
    """
    lumps = [
        ("DECORATE", _decorate(layout, motion).encode()),
        ("ZMAPINFO", _map_info().encode()),
        (MAP, b""),
        ("TEXTMAP", _text_map(layout).encode()),
        ("BEHAVIOR", _behavior(layout, motion)),
        ("ENDMAP", b""),
    ]
    body, directory = b"", b""
    for name, content in lumps:
        directory += struct.pack("<II8s", 12 + len(body), len(content), name.encode())
        body += content
    return struct.pack("<4sII", b"PWAD", len(lumps), 12 + len(body)) + body + directory


def full_speed(way: float, *, stock: bool, command: int) -> float:
    """Return the factor by which a player's push must differ from the engine's own.

    Args:
        way: of one timestep at full speed, metres.
        stock: whether the engine's own friction acts.
        command: `_WALK` or `_RUN`.
    """
    units = way * UNITS / TICS
    if stock:
        # The push is added to what is kept: full speed is push / (1 - kept).
        return units * (1 - _STOCK_KEPT) / (command * _STOCK_PUSH)
    return units / (command * _EXACT_PUSH)


def _decorate(layout: Layout, motion: Motion) -> str:
    walk = full_speed(motion.forward, stock=motion.stock, command=_WALK)
    run = full_speed(motion.back, stock=motion.stock, command=_RUN)
    return f"""\
actor FleetRobot : PlayerPawn
{{
  Radius {player_radius(layout):.6f}
  Height 56
  Friction {1 if motion.stock else 0}
  Player.DisplayName "Robot"
  Player.ForwardMove {walk:.6f}, {run:.6f}
  States
  {{
  Spawn:
  See:
  Missile:
  Melee:
  Pain:
  Death:
    PLAY A -1
    Stop
  }}
}}
actor FleetPack 20000
{{
  Radius 1
  Height 16
  +NOINTERACTION
  States
  {{
  Spawn:
    MEDI A -1
    Stop
  }}
}}
actor FleetGoal 20001
{{
  Radius 1
  Height 16
  +NOINTERACTION
  States
  {{
  Spawn:
    COLU A -1 Bright
    Stop
  }}
}}
"""


def _map_info() -> str:
    return f"""\
gameinfo
{{
  playerclasses = "FleetRobot"
}}
map {MAP} "Rooms"
{{
  nointermission
  noinfighting
}}
"""


def _text_map(layout: Layout) -> str:
    lines = cut_lines(layout)
    points = list(dict.fromkeys(point for line in lines for point in (line.start, line.end)))
    kinds = sorted({kind for line in lines for kind in (line.front, line.back) if kind})
    text = ['namespace = "zdoom";']
    text += [_block("vertex", x=x / GRID, y=y / GRID) for x, y in points]
    sides = 0
    for line in lines:
        ends = {"v1": points.index(line.start), "v2": points.index(line.end)}
        if line.back is None:
            text.append(_block("linedef", **ends, sidefront=sides, blocking=True))
        else:
            text.append(
                _block(
                    "linedef", **ends, sidefront=sides, sideback=sides + 1, twosided=True
                )
            )  # fmt: skip
        sides += 1 if line.back is None else 2
    for line in lines:
        wall = "-" if line.back else _WALLS[line.front[1] % len(_WALLS)]
        for kind in (line.front, line.back):
            if kind is not None:
                text.append(_block("sidedef", sector=kinds.index(kind), texturemiddle=wall))
    text += [_sector(kind) for kind in kinds]
    start, goal = layout.start_mark, layout.goal
    places = [(1, start.x, start.y), *((20000, pack.x, pack.y) for pack in layout.packs)]
    for number, x, y in [*places, (20001, goal.x, goal.y)]:
        text.append(_thing(number, on_grid(x) / GRID, on_grid(y) / GRID))
    return "\n".join(text) + "\n"


def _sector(kind: Kind) -> str:
    return _block(
        "sector",
        heightfloor=0,
        heightceiling=128,
        texturefloor=_FLOORS[kind[0]],
        textureceiling="CEIL5_1",
        lightlevel=200 if kind[0] in {"room", "start"} else 255,
    )


def _thing(number: int, x: float, y: float) -> str:
    always = {f"skill{skill}": True for skill in range(1, 6)}
    modes = {"single": True, "coop": True, "dm": True}
    return _block("thing", x=x, y=y, angle=0, type=number, **always, **modes)


def _block(name: str, **fields: float | str | bool) -> str:
    """Return one UDMF block on one line."""

    def written(value: float | str | bool) -> str:  # noqa: FBT001 - a field's value
        if isinstance(value, bool):
            return str(value).lower()
        return f'"{value}"' if isinstance(value, str) else repr(value)

    inside = " ".join(f"{key}={written(value)};" for key, value in fields.items())
    return f"{name} {{ {inside} }}"


def _behavior(layout: Layout, motion: Motion) -> bytes:
    program = Program()
    _place_script(program)
    _velocity_script(program)
    _live_script(program, layout, motion)
    return program.behavior()


def _place_script(program: Program) -> None:
    """Put the player to x, y (16.16), angle (turn / 65536) and health (16.16)."""
    x, y, angle, health = range(4)
    program.script(SET_STATE, 4)
    program.add(Op.PUSH, 0, Op.LOAD_LOCAL, x, Op.LOAD_LOCAL, y, Op.PUSH, 0, Op.PUSH, 0)
    program.add(Op.SET_POSITION, Op.DROP)
    program.add(Op.PUSH, 0, Op.LOAD_LOCAL, angle, Op.SET_ANGLE)
    program.add(Op.PUSH, 0, Op.LOAD_MAP, _VELOCITY_X, Op.LOAD_MAP, _VELOCITY_Y)
    program.push(0, 0, 0)
    program.add(Op.CALL, 6, SET_VELOCITY, Op.DROP)
    program.add(Op.LOAD_LOCAL, health, Op.STORE_GLOBAL, HEALTH)
    _show_health(program)
    # What runs always comes after this in the same tic, and counts it.
    program.push(-1)
    program.add(Op.STORE_MAP, _PHASE)
    program.add(Op.LOAD_GLOBAL, PLACED, Op.PUSH, 1, Op.ADD, Op.STORE_GLOBAL, PLACED)
    program.add(Op.TERMINATE)


def _velocity_script(program: Program) -> None:
    """Say how fast (x, y, 16.16) the player goes after the next placing."""
    program.script(SET_VELOCITY_FIRST, 2)
    program.add(Op.LOAD_LOCAL, 0, Op.STORE_MAP, _VELOCITY_X)
    program.add(Op.LOAD_LOCAL, 1, Op.STORE_MAP, _VELOCITY_Y, Op.TERMINATE)


def _live_script(program: Program, layout: Layout, motion: Motion) -> None:
    """At the end of every timestep: round the place to the grid, let hazard and pack act."""
    x, y, change, aside, above = range(5)
    program.script(LIVE, 0, at_enter=True)
    program.label("tic")
    program.add(Op.PUSH, 1, Op.DELAY)
    program.add(Op.LOAD_MAP, _PHASE, Op.PUSH, 1, Op.ADD, Op.STORE_MAP, _PHASE)
    program.add(Op.LOAD_MAP, _PHASE, Op.PUSH, TICS, Op.LESS, Op.GO_IF, "tic")
    program.add(Op.PUSH, 0, Op.STORE_MAP, _PHASE)
    step = FIXED // GRID
    for read, variable in ((Op.ACTOR_X, x), (Op.ACTOR_Y, y)):
        program.add(Op.PUSH, 0, read, Op.PUSH, step // 2, Op.ADD)
        program.add(Op.PUSH, -step, Op.AND_BITS, Op.STORE_LOCAL, variable)
    program.add(Op.PUSH, 0, Op.LOAD_LOCAL, x, Op.LOAD_LOCAL, y, Op.PUSH, 0, Op.PUSH, 0)
    program.add(Op.SET_POSITION, Op.DROP)
    program.add(Op.LOAD_GLOBAL, HEALTH, Op.STORE_LOCAL, change)
    for number, hazard in enumerate(layout.hazards):
        sides = (
            (x, Op.AT_LEAST, hazard.left),
            (x, Op.AT_MOST, hazard.right),
            (y, Op.AT_LEAST, hazard.bottom),
            (y, Op.AT_MOST, hazard.top),
        )
        for variable, compare, edge in sides:
            program.add(Op.LOAD_LOCAL, variable, Op.PUSH, on_grid(edge) * step, compare)
            program.add(Op.GO_UNLESS, f"past hazard {number}")
        program.add(Op.LOAD_LOCAL, change, Op.PUSH, round(motion.damage * FIXED))
        program.add(Op.SUBTRACT, Op.STORE_LOCAL, change, Op.GO, "hazards done")
        program.label(f"past hazard {number}")
    program.label("hazards done")
    for number, pack in enumerate(layout.packs):
        reach = on_grid(pack.radius) * step
        for variable, middle, offset in ((x, pack.x, aside), (y, pack.y, above)):
            program.add(Op.LOAD_LOCAL, variable, Op.PUSH, on_grid(middle) * step)
            program.add(Op.SUBTRACT, Op.STORE_LOCAL, offset)
            # A square of what is far would not fit into 32 bits.
            program.add(Op.LOAD_LOCAL, offset, Op.PUSH, reach, Op.GREATER)
            program.add(Op.GO_IF, f"past pack {number}")
            program.add(Op.LOAD_LOCAL, offset, Op.PUSH, -reach, Op.LESS)
            program.add(Op.GO_IF, f"past pack {number}")
        program.add(Op.LOAD_LOCAL, aside, Op.LOAD_LOCAL, aside, Op.FIXED_MULTIPLY)
        program.add(Op.LOAD_LOCAL, above, Op.LOAD_LOCAL, above, Op.FIXED_MULTIPLY, Op.ADD)
        program.add(Op.PUSH, reach, Op.PUSH, reach, Op.FIXED_MULTIPLY, Op.GREATER)
        program.add(Op.GO_IF, f"past pack {number}")
        program.add(Op.LOAD_LOCAL, change, Op.PUSH, round(motion.heal * FIXED), Op.ADD)
        program.add(Op.STORE_LOCAL, change, Op.GO, "packs done")
        program.label(f"past pack {number}")
    program.label("packs done")
    full = round(FULL_HEALTH * FIXED)
    program.add(Op.LOAD_LOCAL, change, Op.PUSH, full, Op.AT_MOST, Op.GO_IF, "not too much")
    program.add(Op.PUSH, full, Op.STORE_LOCAL, change)
    program.label("not too much")
    program.add(Op.LOAD_LOCAL, change, Op.PUSH, 0, Op.AT_LEAST, Op.GO_IF, "not too little")
    program.add(Op.PUSH, 0, Op.STORE_LOCAL, change)
    program.label("not too little")
    program.add(Op.LOAD_LOCAL, change, Op.STORE_GLOBAL, HEALTH)
    _show_health(program)
    program.add(Op.LOAD_GLOBAL, TIMESTEPS, Op.PUSH, 1, Op.ADD, Op.STORE_GLOBAL, TIMESTEPS)
    program.add(Op.GO, "tic")


def _show_health(program: Program) -> None:
    """Give the player its health, rounded down plus one: it never dies by the engine's rules."""
    program.push(0, 0)
    program.add(Op.LOAD_GLOBAL, HEALTH, Op.PUSH, 16, Op.SHIFT_RIGHT, Op.PUSH, 1, Op.ADD)
    program.add(Op.SET_PROPERTY)
