"""One row a fleet run."""

from __future__ import annotations

import hashlib

import numpy as np

from analysis.recordings import Session, StudyRecordings, timestep_blocks
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.deviations import session_rows
from analysis.tables.sessions import order_text
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.codes import Outcome
from study.events.events import EpisodeEnded, Switched, TrialStarted
from study.events.fields import Record

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("order", "label", "conditions of phase three in the order run"),
    Column("robots", "integer", "number of robots"),
    Column("allocation", "label", "who decides which robot is operated"),
    Column("treated", "label", "condition that ran; empty if none of the protocol's did"),
    Column("view", "label", "what the participant sees"),
    Column("dwell", "integer", "timesteps between automatic switches", unit="timesteps"),
    Column("policy_id", "label", "which policy drives"),
    Column("scorer_id", "label", "which scorer is computed, or empty"),
    Column("start_states", "label", "first 12 digits of the start states' SHA-256"),
    Column("scored", "boolean", "whether its reward counts"),
    Column("complete", "boolean", "whether it ran to its end"),
    Column("planned_timesteps", "integer", "planned length", unit="timesteps"),
    Column("timesteps", "integer", "timesteps executed", unit="timesteps"),
    Column("team_reward", "number", "sum over robots and timesteps", unit="points"),
    Column("goals", "integer", "episodes that reached the goal"),
    Column("lost", "integer", "episodes in which the robot was lost"),
    Column("takeovers", "integer", "switches to a robot"),
    Column("deviations", "label", "codes of the deviations in it, by commas; empty if none"),
)


def treated_condition(session: Session, trial: TrialStarted) -> str:
    """Return the name of the condition that a fleet run really ran; empty if none did.

    A scorer that could not be fitted, or did not pass its gate, leaves a fleet run with another
    allocation, or with none that decides by scores. An assisted fleet run without a scorer has
    run no condition.
    """
    if not trial.condition:
        return ""
    declared = session.protocol.get("conditions")
    entries = [entry for entry in declared if isinstance(entry, dict)] if declared else []
    allocations = {str(entry.get("name")): str(entry.get("allocation")) for entry in entries}
    if trial.allocation not in ("manual", "none") and not trial.scorer_id:
        return ""
    scorers = {str(entry.get("name")): str(entry.get("scorer") or "") for entry in entries}

    def ran(name: str) -> bool:
        """Whether a condition asks for the allocation and the scorer that there were."""
        scorer = scorers.get(name, "")
        return allocations[name] == trial.allocation and (
            trial.allocation == "manual" or not scorer or trial.scorer_id == f"scorer:{scorer}"
        )

    if trial.condition not in allocations or ran(trial.condition):
        return trial.condition
    others = [name for name in allocations if ran(name)]
    return others[0] if len(others) == 1 else ""


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [row for session in study.sessions for row in _rows(session)]
    return Table.from_rows("trials", "One row a fleet run.", COLUMNS, rows)


def _rows(session: Session) -> list[dict[str, object]]:
    goals: dict[int, int] = {}
    lost: dict[int, int] = {}
    takeovers: dict[int, int] = {}
    for _, event in session.recording.records(EpisodeEnded.topic, Switched.topic):
        _count(event, goals, lost, takeovers)
    deviations: dict[object, set[str]] = {}
    for row in session_rows(session):
        if row["kept"]:
            deviations.setdefault(row["trial_id"], set()).add(str(row["code"]))
    broken = set(session.trials) - set(session.trial_ends)
    partial = _partial_rewards(session) if broken else {}
    rows: list[dict[str, object]] = []
    for trial_id, trial in sorted(session.trials.items()):
        end = session.trial_ends.get(trial_id)
        reward, timesteps = partial.get(trial_id, (0.0, 0))
        digest = hashlib.sha256(np.ascontiguousarray(trial.states, dtype="<f4").tobytes())
        rows.append(
            {
                **trial_keys(session, trial_id),
                "order": order_text(session.opened.order),
                "robots": trial.robots,
                "allocation": trial.allocation,
                "treated": treated_condition(session, trial),
                "view": trial.view,
                "dwell": trial.dwell,
                "policy_id": trial.policy_id,
                "scorer_id": trial.scorer_id,
                "start_states": digest.hexdigest()[:12],
                "scored": bool(trial.scored),
                "complete": bool(end is not None and end.complete),
                "planned_timesteps": trial.timesteps,
                "timesteps": end.timesteps if end else timesteps,
                "team_reward": end.team_reward if end else reward,
                "goals": goals.get(trial_id, 0),
                "lost": lost.get(trial_id, 0),
                "takeovers": takeovers.get(trial_id, 0),
                "deviations": ",".join(sorted(deviations.get(trial_id, set()))),
            }
        )
    return rows


def _count(
    event: Record, goals: dict[int, int], lost: dict[int, int], takeovers: dict[int, int]
) -> None:
    if isinstance(event, EpisodeEnded):
        tally = {Outcome.GOAL: goals, Outcome.LOST: lost}.get(Outcome(event.outcome))
        if tally is not None:
            tally[event.trial_id] = tally.get(event.trial_id, 0) + 1
    elif isinstance(event, Switched) and event.to_robot >= 0:
        takeovers[event.trial_id] = takeovers.get(event.trial_id, 0) + 1


def _partial_rewards(session: Session) -> dict[int, tuple[float, int]]:
    """Sum the rewards of fleet runs whose end is not recorded."""
    sums: dict[int, tuple[float, int]] = {}
    for block in timestep_blocks(session):
        ids = block["trial_id"].astype(np.int64)
        team = block["rewards"].astype(np.float64).sum(axis=1)
        for trial_id in np.unique(ids):
            mask = ids == trial_id
            reward, count = sums.get(int(trial_id), (0.0, 0))
            sums[int(trial_id)] = (reward + float(team[mask].sum()), count + int(mask.sum()))
    return sums
