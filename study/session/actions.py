"""What every robot does at a timestep, and who decided it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.codes import ActionSource
from study.events.task_description import TaskDescription
from study.seat_settings import DIRECTIONS, KeyPart

Actions = npt.NDArray[np.int32]


def decide_actions(
    policy_actions: Actions,
    active: npt.NDArray[np.bool_],
    operated: int,
    wanted: int | None,
    idle: int,
    *,
    drives_itself: bool,
) -> tuple[Actions, Actions]:
    """Return actions and their `codes.ActionSource`, both int32 [n].

    Args:
        policy_actions: what the policy would do, int32 [n].
        active: robots whose episode goes on, bool [n].
        operated: index of the operated robot; -1 if none.
        wanted: the action that the operator asks for; None if no key acts.
        idle: the action that does nothing.
        drives_itself: whether the operated robot follows its policy while no key acts.
    """
    actions = policy_actions.copy()
    sources = np.where(active, ActionSource.POLICY, ActionSource.INACTIVE).astype(np.int32)
    if operated >= 0 and active[operated]:
        if wanted is not None:
            actions[operated] = wanted
            sources[operated] = (
                ActionSource.OPERATOR if wanted != idle else ActionSource.OPERATOR_IDLE
            )
        elif not drives_itself:
            actions[operated] = idle
            sources[operated] = ActionSource.OPERATOR_IDLE
    actions[~active] = idle
    return actions, sources


def drives_all_ways(description: TaskDescription) -> bool:
    """Return whether all four directions drive, and no other key."""
    return set(description.key_actions) == set(DIRECTIONS)


def key_actions(keys: KeyPart, description: TaskDescription) -> dict[str, int]:
    """Return the action that each key asks for."""
    return {
        getattr(keys, name) if name in DIRECTIONS else name: action
        for name, action in description.key_actions.items()
    }


def driving_keys(keys: KeyPart, description: TaskDescription) -> tuple[str, ...]:
    """Return the keys that drive: those of directions first, in the order of the header."""
    given = description.key_actions
    directions = tuple(getattr(keys, name) for name in DIRECTIONS if name in given)
    return (*directions, *(name for name in given if name not in DIRECTIONS))
