"""Cues: short messages in the tiles, from states and outcomes alone. Never points."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.screens import Cue, CueKind

SECOND = 1_000_000_000
LOW_HEALTH = 30.0
STUCK_SECONDS = 5.0
STUCK_METRES = 1.0
_SHOWN_NS = {"lost": SECOND, "goal": 600_000_000, "damage": 600_000_000, "pack": 600_000_000}
_RANK: dict[CueKind, int] = {"lost": 0, "goal": 1, "damage": 2, "stuck": 3, "low": 4, "pack": 5}


class Cues:
    """Keeps the cue of every robot.

    A robot is stuck when it has stayed within a metre for five seconds, until it moves.
    """

    def __init__(self, description: TaskDescription, states: npt.NDArray[np.float32]) -> None:
        self._x, self._y = description.x_field, description.y_field
        self._health = description.health_field
        robots = len(states)
        self._momentary: list[Cue | None] = [None] * robots
        self._anchor = [self._place(state) for state in states]
        self._anchor_ns = [0] * robots

    def _place(self, state: npt.NDArray[np.float32]) -> tuple[float, float]:
        if self._x < 0 or self._y < 0:
            return (0.0, 0.0)
        return (float(state[self._x]), float(state[self._y]))

    def start(self, t_ns: int) -> None:
        """The trial begins to run."""
        self._anchor_ns = [t_ns] * len(self._anchor_ns)

    def observe(
        self,
        before: npt.NDArray[np.float32],
        after: npt.NDArray[np.float32],
        outcomes: npt.NDArray[np.int32],
        restarted: npt.NDArray[np.bool_],
        t_ns: int,
    ) -> None:
        """Take in one timestep.

        Args:
            before: states before the step, [n, d].
            after: states after it, [n, d].
            outcomes: codes.Outcome after the step, [n].
            restarted: robots that began a new episode in this step, [n].
            t_ns: session time.
        """
        for robot in range(len(self._momentary)):
            place = self._place(after[robot])
            if restarted[robot] or math.dist(place, self._anchor[robot]) > STUCK_METRES:
                self._anchor[robot] = place
                self._anchor_ns[robot] = t_ns
            if restarted[robot]:
                continue
            outcome = outcomes[robot]
            if outcome == Outcome.GOAL:
                self._momentary[robot] = Cue("goal", 0.0, t_ns)
            elif outcome in (Outcome.LOST, Outcome.TIME_UP):
                self._momentary[robot] = Cue("lost", 0.0, t_ns)
            elif self._health >= 0:
                change = float(after[robot, self._health] - before[robot, self._health])
                if change:
                    self._offer(robot, Cue("damage" if change < 0 else "pack", change, t_ns))

    def _offer(self, robot: int, cue: Cue) -> None:
        shown = self._momentary[robot]
        if shown is not None and self._is_shown(shown, cue.since_ns):
            if _RANK[shown.kind] < _RANK[cue.kind]:
                return
            if shown.kind == cue.kind and shown.amount == cue.amount:
                cue = Cue(cue.kind, cue.amount, cue.since_ns)
        self._momentary[robot] = cue

    def _is_shown(self, cue: Cue, t_ns: int) -> bool:
        return t_ns - cue.since_ns < _SHOWN_NS[cue.kind]

    def cue(self, robot: int, state: npt.NDArray[np.float32], t_ns: int) -> Cue | None:
        """Return the cue that a robot's tile shows now, the most urgent one."""
        momentary = self._momentary[robot]
        if momentary is not None and not self._is_shown(momentary, t_ns):
            momentary = self._momentary[robot] = None
        if momentary is not None and momentary.kind != "pack":
            return momentary
        stuck_for = (t_ns - self._anchor_ns[robot]) / SECOND
        if stuck_for >= STUCK_SECONDS and self._x >= 0:
            return Cue("stuck", stuck_for, self._anchor_ns[robot])
        if self._health >= 0 and state[self._health] < LOW_HEALTH:
            return Cue("low", float(state[self._health]), t_ns)
        return momentary
