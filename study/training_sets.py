"""From what happened to what is fitted: demonstrations and choice sets.

Only executed operator actions are demonstrations (idling is none), and only choices that
the operator made train a scorer: never those of a scorer, nor a scorer's suggestion that was
accepted, never rows before the first selection, passed while cycling, or for a robot that could
not be chosen.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource
from study.events.events import Timestep

OPERATOR_SOURCES = (ChoiceSource.OPERATOR,)
"""A suggestion that was accepted is half a scorer's choice: fitted to it, a scorer would learn
from itself."""


FIRST_ROOM = 8192
"""Demonstrations that there is room for at first: a quarter of an hour at eight a second."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Demonstrations:
    """Executed operator actions, in order of time.

    Attributes:
        states: float32 [m, d], before the action.
        actions: int32 [m].
    """

    states: npt.NDArray[np.float32]
    actions: npt.NDArray[np.int32]

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return the arrays as a fit takes them."""
        return {"states": self.states, "actions": self.actions}


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class ChoiceSets:
    """Choices among the robots of a fleet, one row a timestep.

    Attributes:
        states: float32 [m, n, d].
        available: bool [m, n].
        chosen: int32 [m].
        trials: int32 [m], trial ids.
    """

    states: npt.NDArray[np.float32]
    available: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.int32]
    trials: npt.NDArray[np.int32]

    def arrays(self) -> dict[str, npt.NDArray[np.generic]]:
        """Return the arrays as a fit takes them."""
        return {
            "states": self.states,
            "available": self.available,
            "chosen": self.chosen,
            "trials": self.trials,
        }


class DemonstrationBuffer:
    """Demonstrations of timesteps as they happen, in a few bytes each.

    Room for many is taken with the first one, and twice as much whenever it is full: a condition
    that has begun takes no more memory by its end.
    """

    def __init__(self) -> None:
        self._states: npt.NDArray[np.float32] = np.empty((0, 0), np.float32)
        self._actions: npt.NDArray[np.int32] = np.empty(0, np.int32)
        self._count = 0

    def add(self, row: Timestep) -> None:
        """Take the operator's executed action of one timestep, if there was one."""
        operated = row.operated
        if operated >= 0 and row.action_sources[operated] == ActionSource.OPERATOR:
            state = row.states[operated]
            if self._count == len(self._actions):
                self._make_room(max(FIRST_ROOM, 2 * self._count), len(state))
            self._states[self._count] = state
            self._actions[self._count] = row.actions[operated]
            self._count += 1

    def _make_room(self, rows: int, state_size: int) -> None:
        # Filled, since pages that nobody has written to are not there yet.
        states = np.full((rows, state_size), np.nan, np.float32)
        actions = np.full(rows, -1, np.int32)
        if self._count:
            states[: self._count], actions[: self._count] = self._states, self._actions
        self._states, self._actions = states, actions

    def copy(self) -> DemonstrationBuffer:
        """Return one that goes on by itself, without room to spare."""
        copied = DemonstrationBuffer()
        copied._states = self._states[: self._count].copy()
        copied._actions = self._actions[: self._count].copy()
        copied._count = self._count
        return copied

    def collected(self, state_size: int) -> Demonstrations:
        """Return all demonstrations so far.

        Args:
            state_size: d.
        """
        states = self._states[: self._count].reshape(-1, state_size).copy()
        return Demonstrations(states, self._actions[: self._count].copy())


def demonstrations(timesteps: Iterable[Timestep], state_size: int) -> Demonstrations:
    """Collect the operator's executed actions.

    Args:
        timesteps: events of one or more trials.
        state_size: d.
    """
    buffer = DemonstrationBuffer()
    for row in timesteps:
        buffer.add(row)
    return buffer.collected(state_size)


def joined(parts: Sequence[Demonstrations], state_size: int) -> Demonstrations:
    """Return demonstrations one after the other.

    Args:
        parts: in order; may be none.
        state_size: d.
    """
    none = np.empty((0, state_size), np.float32), np.empty(0, np.int32)
    return Demonstrations(
        states=np.concatenate([none[0], *(part.states for part in parts)]),
        actions=np.concatenate([none[1], *(part.actions for part in parts)]),
    )


def is_usable_choice(row: Timestep) -> bool:
    """Whether a row is a choice of the operator's that a scorer may be fitted to."""
    return (
        row.choice_source in OPERATOR_SOURCES
        and row.choice_flag == ChoiceFlag.USABLE
        and row.operated >= 0
        and bool(row.available[row.operated])
    )


def choice_sets(
    timesteps: Iterable[Timestep], robots: int, state_size: int, *, of_larger: bool = False
) -> ChoiceSets:
    """Collect the operator's choices from trials with ``robots`` robots.

    Args:
        timesteps: events; rows of fleets of another size are passed over.
        robots: n.
        state_size: d.
        of_larger: whether choices in fleets of other sizes are taken too, if there were at most
            ``robots`` robots to choose from. Of a larger fleet those that could be chosen take
            the places, in order; places that are left over are not available.
    """
    usable = [row for row in timesteps if is_usable_choice(row)]
    if of_larger:
        return _offered_sets(usable, robots, state_size)
    rows = [row for row in usable if row.robots == robots]
    return ChoiceSets(
        states=np.array([row.states for row in rows], dtype=np.float32).reshape(
            -1, robots, state_size
        ),
        available=np.array([row.available for row in rows], dtype=np.bool_).reshape(-1, robots),
        chosen=np.array([row.operated for row in rows], dtype=np.int32),
        trials=np.array([row.trial_id for row in rows], dtype=np.int32),
    )


def _offered_sets(usable: list[Timestep], robots: int, state_size: int) -> ChoiceSets:
    rows = [
        row for row in usable if row.robots <= robots or np.count_nonzero(row.available) <= robots
    ]
    states = np.zeros((len(rows), robots, state_size), dtype=np.float32)
    available = np.zeros((len(rows), robots), dtype=np.bool_)
    chosen = np.zeros(len(rows), dtype=np.int32)
    for place, row in enumerate(rows):
        small = row.robots <= robots
        offered = np.arange(row.robots) if small else np.flatnonzero(row.available)
        states[place, : len(offered)] = row.states[offered]
        available[place, : len(offered)] = row.available[offered] != 0
        chosen[place] = int(np.flatnonzero(offered == row.operated)[0])
    trials = np.array([row.trial_id for row in rows], dtype=np.int32)
    return ChoiceSets(states, available, chosen, trials)


def arrays_sha256(arrays: dict[str, npt.NDArray[np.generic]]) -> str:
    """Return the SHA-256 of named arrays: names, types, shapes and bytes."""
    digest = hashlib.sha256()
    for name, array in sorted(arrays.items()):
        digest.update(f"{name}:{array.dtype.str}:{array.shape};".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
