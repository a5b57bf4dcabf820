"""One row a fleet run with an operator: where the operator's attention went."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.typing as npt

from analysis.attention import STUCK_SECONDS, FleetLog, measures
from analysis.recordings import Session, StudyRecordings, timestep_blocks
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.codes import ActionSource
from study.events.inputs import KeyChanged, PointerPressed

_STEPS = "timesteps"
_POINTS = "points"

MEASURES = (
    Column("attended", "number", "part of the timesteps at which a robot is attended to"),
    Column("takeovers", "number", "how often a robot is taken over, those only passed left out"),
    Column("dwell", "number", "mean time from a takeover to leaving the robot", _STEPS),
    Column(
        "switch_lag",
        "number",
        "mean time from leaving a robot to the first action on the next",
        _STEPS,
    ),
    Column(
        "switch_cost",
        "number",
        "mean points below the settled pace in the first 8 timesteps of a takeover",
        _POINTS,
    ),
    Column("neglect_time", "number", "mean time that a running robot goes on unattended", _STEPS),
    Column("stuck_spells", "number", "how often a robot is stuck and unattended"),
    Column("stuck_helped", "number", "part of these that ended by a takeover"),
    Column("stuck_wait", "number", "mean wait of those until the takeover", _STEPS),
    Column("stuck_share", "number", "part of the unattended time in which robots are stuck"),
    Column(
        "neglect_tolerance",
        "number",
        "unattended time without trouble for each time that a robot got stuck or was lost",
        _STEPS,
    ),
    Column("fan_out", "number", "neglect tolerance over dwell, plus 1", "robots"),
    Column(
        "fan_out_with_wait", "number", "the same with the wait of a stuck robot added", "robots"
    ),
    Column("actions", "number", "timesteps at which the operator acted", "actions"),
    Column("reward_per_action", "number", "team reward over actions", "points an action"),
    Column("presses", "number", "keys and buttons pressed", "presses"),
    Column("reward_per_press", "number", "team reward over presses", "points a press"),
)
"""The measures of `analysis.attention`; each is missing where a fleet run does not give it."""

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("robots", "integer", "number of robots"),
    Column("allocation", "label", "who decides which robot is operated"),
    Column("timesteps", "integer", "timesteps recorded", _STEPS),
    *MEASURES,
)

_FIELDS = (
    "timestep",
    "operated",
    "choice_flag",
    "action_sources",
    "outcomes",
    "rewards",
    "states",
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings: fleet runs of two or more robots with an operator."""
    rows = [row for session in study.sessions for row in _rows(session)]
    text = "One row a fleet run of two or more robots with an operator."
    return Table.from_rows("attention", text, COLUMNS, rows)


def _rows(session: Session) -> Iterator[dict[str, Any]]:
    logs = _logs(session)
    for trial_id in sorted(logs):
        trial = session.trials[trial_id]
        log = logs[trial_id]
        yield {
            **trial_keys(session, trial_id),
            "robots": log.running.shape[1],
            "allocation": trial.allocation,
            "timesteps": len(log.operated),
            **measures(log),
        }


def _logs(session: Session) -> dict[int, FleetLog]:
    pieces: dict[int, list[dict[str, npt.NDArray[Any]]]] = {}
    for block in timestep_blocks(session):
        ids = block["trial_id"].astype(np.int64)
        if block["rewards"].shape[1] < 2:
            continue
        for trial_id in np.unique(ids):
            trial = session.trials.get(int(trial_id))
            if trial is not None and trial.allocation != "none":
                mask = ids == trial_id
                pieces.setdefault(int(trial_id), []).append(
                    {name: block[name][mask] for name in _FIELDS}
                )
    presses = _presses(session) if pieces else None
    return {
        trial_id: _log(session, found, None if presses is None else presses.get(trial_id, 0))
        for trial_id, found in pieces.items()
    }


def _log(
    session: Session, pieces: list[dict[str, npt.NDArray[Any]]], presses: int | None
) -> FleetLog:
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in _FIELDS}
    order = np.argsort(joined["timestep"], kind="stable")
    joined = {name: values[order] for name, values in joined.items()}
    x, y = session.task.x_field, session.task.y_field
    places = joined["states"][:, :, [x, y]].astype(np.float64) if min(x, y) >= 0 else None
    return FleetLog(
        operated=joined["operated"].astype(np.int64),
        flags=joined["choice_flag"].astype(np.int64),
        sources=joined["action_sources"].astype(np.int64),
        # What can be chosen may be less than what runs: in a correction round few are offered.
        running=joined["action_sources"] != ActionSource.INACTIVE,
        outcomes=joined["outcomes"].astype(np.int64),
        rewards=joined["rewards"].astype(np.float64),
        places=places,
        stuck_timesteps=_stuck_timesteps(session),
        presses=presses,
    )


def _stuck_timesteps(session: Session) -> int | None:
    timing = session.protocol.get("timing")
    rate = timing.get("timesteps_per_second") if isinstance(timing, dict) else None
    if isinstance(rate, bool) or not isinstance(rate, int | float) or not 0 < rate < math.inf:
        return None
    return max(1, round(STUCK_SECONDS * rate))


def _presses(session: Session) -> dict[int, int] | None:
    """Count keys and buttons pressed in each fleet run; None if the session holds none at all."""
    records = session.recording.records(KeyChanged.topic, PointerPressed.topic)
    pressed = [
        record.t_ns if isinstance(record, PointerPressed) or record.down else -1
        for _, record in records
        if isinstance(record, KeyChanged | PointerPressed)
    ]
    if not pressed:
        return None
    times = np.sort(np.array(pressed, np.int64))
    counts = {}
    for trial_id, trial in session.trials.items():
        end = session.trial_ends.get(trial_id)
        last = end.t_ns if end else times[-1]
        between = np.searchsorted(times, [trial.t_ns, last], side="right")
        counts[trial_id] = int(between[1] - between[0])
    return counts
