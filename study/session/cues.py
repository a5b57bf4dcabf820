"""Cues: short messages in the tiles, from states and outcomes alone. Never points."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.events.task_description import TaskDescription
from study.screens import Cue, CueKind

SECOND = 1_000_000_000
LOW_HEALTH = 30.0
STUCK_SECONDS = 5.0
STUCK_METRES = 1.0
_RUNNING, _GOAL, _LOST = int(Outcome.RUNNING), int(Outcome.GOAL), int(Outcome.LOST)
_SHOWN_NS = {
    "lost": SECOND,
    "time_up": SECOND,
    "goal": 600_000_000,
    "damage": 600_000_000,
    "pack": 600_000_000,
}
_RANK: dict[CueKind, int] = {
    "lost": 0,
    "goal": 1,
    "time_up": 2,
    "damage": 3,
    "stuck": 4,
    "low": 5,
    "pack": 6,
}


class Cues:
    """Keeps the cue of every robot.

    A robot is stuck when it has stayed within a metre for five seconds, until it moves.
    """

    def __init__(self, description: TaskDescription, states: npt.NDArray[np.float32]) -> None:
        self._health = description.health_field
        self._places = [description.x_field, description.y_field]
        self._has_place = min(self._places) >= 0
        robots = len(states)
        self._momentary: list[Cue | None] = [None] * robots
        self._anchors = self._place(states)
        self._anchored_ns = np.zeros(robots, dtype=np.int64)

    def _place(self, states: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        if not self._has_place:
            return np.zeros((len(states), 2), dtype=np.float32)
        return states[:, self._places]

    def start(self, t_ns: int) -> None:
        """The trial begins to run, or goes on after a pause."""
        self._anchored_ns[:] = t_ns

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
        places = self._place(after)
        moved = restarted | (np.abs(places - self._anchors).max(axis=1) > STUCK_METRES)
        np.copyto(self._anchors, places, where=moved[:, None])
        self._anchored_ns[moved] = t_ns
        change = (
            after[:, self._health] - before[:, self._health]
            if self._health >= 0
            else np.zeros(len(after), dtype=np.float32)
        )
        # A robot that ended stays in its last state for a timestep: its cue runs already.
        for robot in np.flatnonzero(~restarted & ((outcomes != _RUNNING) | (change != 0))):
            outcome, amount = int(outcomes[robot]), float(change[robot])
            if outcome == _GOAL:
                self._momentary[robot] = Cue("goal", 0.0, t_ns)
            elif outcome != _RUNNING:
                # Time that is up costs nothing: it must not look like a loss.
                kind: CueKind = "lost" if outcome == _LOST else "time_up"
                self._momentary[robot] = Cue(kind, 0.0, t_ns)
            else:
                self._offer(int(robot), Cue("damage" if amount < 0 else "pack", amount, t_ns))

    def _offer(self, robot: int, cue: Cue) -> None:
        shown = self._momentary[robot]
        if (
            shown is None
            or not self._is_shown(shown, cue.since_ns)
            or _RANK[cue.kind] <= _RANK[shown.kind]
        ):
            self._momentary[robot] = cue

    def _is_shown(self, cue: Cue, t_ns: int) -> bool:
        return t_ns - cue.since_ns < _SHOWN_NS[cue.kind]

    def cue(self, robot: int, health: float, t_ns: int) -> Cue | None:
        """Return the cue that a robot's tile shows now, the most urgent one."""
        momentary = self._momentary[robot]
        if momentary is not None and not self._is_shown(momentary, t_ns):
            momentary = self._momentary[robot] = None
        if momentary is not None and momentary.kind != "pack":
            return momentary
        since_ns = int(self._anchored_ns[robot])
        if self._has_place and t_ns - since_ns >= STUCK_SECONDS * SECOND:
            return Cue("stuck", (t_ns - since_ns) / SECOND, since_ns)
        if health < LOW_HEALTH:
            return Cue("low", health, t_ns)
        return momentary
