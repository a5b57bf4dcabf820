"""One engine with one robot in it. Only workers use it: an engine can take its process down."""

from __future__ import annotations

import contextlib
import dataclasses
import shlex
import sys
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

import numpy as np
import numpy.typing as npt

from study.tasks._doom.conventions import (
    HEALTH,
    MAP,
    PLACED,
    SET_STATE,
    SET_VELOCITY_FIRST,
    TICS,
    TIMESTEPS,
)
from study.tasks._doom.leftovers import forget_memory
from study.tasks._doom.plane import GRID

_FIXED = 65536
_DEAF_TICS = 10
"""For so long after its start an engine does not hear commands."""

_PLACING_TICS = 3
"""A placing takes one tic; more is given before it counts as failed."""

Frames = npt.NDArray[np.uint8]


class EngineError(Exception):
    """The engine is not what it should be: gone, another map, or somewhere else than told."""


class Pose(NamedTuple):
    """An engine's state in whole numbers, nothing of it rounded.

    Attributes:
        x, y: place, 1/`GRID` map units.
        angle: 1/65536 turns, counterclockwise from the x axis.
        health: 1/65536 points.
        velocity_x, velocity_y: 1/65536 map units a tic; 0 with exact motion.
    """

    x: int
    y: int
    angle: int
    health: int
    velocity_x: int = 0
    velocity_y: int = 0


@dataclasses.dataclass(frozen=True, slots=True)
class Command:
    """What the player is told for a timestep.

    Attributes:
        forward, backward: whether it pushes.
        turn: by how much it turns each tic, 1/65536 turns, counterclockwise.
    """

    forward: bool
    backward: bool
    turn: int


class Engine:
    """One running game.

    Args:
        wad: file that `wad.write_wad` wrote; the working folder takes what the engine writes.
        launcher: what `write_launcher` wrote.
        width, height: of a frame, pixels.
        start: where the map puts the player, 1/`GRID` map units: shows that it is our map.

    Raises:
        EngineError: the engine does not start, or has loaded another map.
    """

    def __init__(
        self, wad: Path, launcher: Path, width: int, height: int, start: tuple[int, int]
    ) -> None:
        import vizdoom  # noqa: PLC0415 - only where engines run

        self._failures: tuple[type[Exception], ...] = tuple(
            kind for kind in vars(vizdoom).values() if _is_failure(kind)
        )
        button, variable = vizdoom.Button, vizdoom.GameVariable
        game = vizdoom.DoomGame()
        self._game: Any = game
        game.set_vizdoom_path(str(launcher))
        game.set_doom_scenario_path(str(wad))
        game.set_doom_map(MAP.lower())
        game.set_window_visible(False)
        game.set_screen_resolution(getattr(vizdoom.ScreenResolution, f"RES_{width}X{height}"))
        game.set_screen_format(vizdoom.ScreenFormat.RGB24)
        for hide in (
            game.set_render_hud,
            game.set_render_weapon,
            game.set_render_crosshair,
            game.set_render_decals,
            game.set_render_particles,
            game.set_render_messages,
        ):
            hide(False)  # noqa: FBT003 - the engine's own call
        # A picture is then of the state alone: standing and walking robots do not sway.
        game.add_game_args("+movebob 0 +stillbob 0")
        game.set_episode_timeout(0)
        game.set_seed(0)
        game.set_available_buttons(
            [button.MOVE_FORWARD, button.MOVE_BACKWARD, button.SPEED, button.TURN_LEFT_RIGHT_DELTA]
        )
        user = [getattr(variable, f"USER{number}") for number in (HEALTH, TIMESTEPS, PLACED)]
        game.set_available_game_variables(
            [
                variable.POSITION_X,
                variable.POSITION_Y,
                variable.ANGLE,
                variable.VELOCITY_X,
                variable.VELOCITY_Y,
                *user,
            ]
        )
        self._guarded(game.init)
        forget_memory(game.get_instance_id())
        self._look()
        self._values = self._read()
        found = tuple(round(float(value) * GRID) for value in self._values[:2])
        if found != start:
            self.close()
            raise EngineError(f"the engine has another map: it starts at {found}, not at {start}")
        self._advance(Command(forward=False, backward=False, turn=0), _DEAF_TICS)

    def place(self, pose: Pose) -> None:
        """Put the robot into a state; its next timestep begins there.

        Raises:
            EngineError: it is not there afterwards.
        """
        x, y = (value * (_FIXED // GRID) for value in (pose.x, pose.y))
        game, before = self._game, self._values[7]
        # Of scripts called in one tic the engine runs the last one first.
        for script in (
            f"{SET_STATE} {x} {y} {pose.angle} {pose.health}",
            f"{SET_VELOCITY_FIRST} {pose.velocity_x} {pose.velocity_y}",
        ):
            self._guarded(game.send_game_command, f"puke {script}")
        for _ in range(_PLACING_TICS):
            self._advance(Command(forward=False, backward=False, turn=0), 1)
            self._values = self._read()
            if self._values[7] != before:
                break
        found = self.pose()
        if found != pose:
            raise EngineError(f"the robot was put to {pose} and is at {found}")

    def step(self, command: Command, frames: Frames | None = None) -> Pose:
        """Take one timestep.

        Args:
            command: what the player does in each of its tics.
            frames: uint8 [`TICS`, height, width, 3]: filled with the picture after each tic;
                without it the engine draws the last one only.

        Raises:
            EngineError: the engine is gone, or has not done what it was told.
        """
        angle, done = self.pose().angle, self._values[6]
        if frames is None:
            self._advance(command, TICS)
        else:
            for frame in frames:
                self._advance(command, 1)
                self.copy_frame(frame)
        self._values = self._read()
        pose = self.pose()
        if self._values[6] != done + 1:
            raise EngineError(f"{self._values[6] - done:.0f} timesteps in {TICS} tics")
        if pose.angle != (angle + TICS * command.turn) % _FIXED:
            raise EngineError(f"told to turn by {TICS * command.turn}: {angle} to {pose.angle}")
        return pose

    def pose(self) -> Pose:
        """Return where the robot is."""
        x, y, angle, velocity_x, velocity_y, health = self._values[:6]
        return Pose(
            x=round(x * GRID),
            y=round(y * GRID),
            angle=round(angle / 360 * _FIXED) % _FIXED,
            health=round(health),
            velocity_x=round(velocity_x * _FIXED),
            velocity_y=round(velocity_y * _FIXED),
        )

    def copy_frame(self, into: Frames) -> None:
        """Copy the picture, uint8 [height, width, 3].

        Raises:
            EngineError: the engine is gone.
        """
        into[...] = self._state.screen_buffer

    def close(self) -> None:
        """End the engine. Calling it twice is harmless."""
        with contextlib.suppress(Exception):
            self._game.close()

    def _advance(self, command: Command, tics: int) -> None:
        degrees = -command.turn * 360 / _FIXED
        # Backwards is the engine's running speed, forwards its walking speed: see wad.py.
        buttons = [command.forward, command.backward, command.backward, degrees]
        self._guarded(self._game.make_action, buttons, tics)
        self._look()

    def _look(self) -> None:
        self._state = self._guarded(self._game.get_state)
        if self._state is None:
            raise EngineError("the engine has ended the game")

    def _read(self) -> list[float]:
        return [float(value) for value in self._state.game_variables]

    def _guarded(self, call: Any, *arguments: object) -> Any:  # noqa: ANN401 - of the engine
        try:
            return call(*arguments)
        except self._failures as error:
            raise EngineError(f"{type(error).__name__}: {error}") from error


def _is_failure(kind: object) -> TypeGuard[type[Exception]]:
    return isinstance(kind, type) and issubclass(kind, Exception)


def write_launcher(folder: Path) -> Path:
    """Write a program that runs the engine so that it dies with who started it.

    The kernel is asked for that (PR_SET_PDEATHSIG): an engine whose process was killed would
    wait for its next command for ever.
    """
    import vizdoom  # noqa: PLC0415 - only where engines run

    engine = str(Path(vizdoom.__file__ or "").parent / "vizdoom")
    code = (
        "import ctypes,os,sys;ctypes.CDLL(None).prctl(1,9,0,0,0);os.execv(sys.argv[1],sys.argv[1:])"
    )
    path = folder / "engine"
    path.write_text(
        f"#!/bin/sh\nexec {shlex.quote(sys.executable)} -IS -c {shlex.quote(code)} "
        f'{shlex.quote(engine)} "$@"\n'
    )
    path.chmod(0o700)
    return path
