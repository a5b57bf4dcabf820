"""Counts of an export held against the recordings' own records."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from analysis.recordings import StudyRecordings
from analysis.tables import scores
from study.events.events import (
    Deviation,
    EpisodeEnded,
    FitRequested,
    QuestionAnswered,
    Resumed,
    Switched,
    Timestep,
)
from study.events.experimenter_records import ExperimenterNoted
from study.events.fit_events import FitGateJudged
from study.events.participant_events import InstrumentScored, TextAnswered

TOPICS: Mapping[str, tuple[str, ...]] = {
    "episodes": (EpisodeEnded.topic,),
    "responses": (QuestionAnswered.topic,),
    "texts": (TextAnswered.topic,),
    "fits": (FitRequested.topic,),
    "fit_gates": (FitGateJudged.topic,),
    "switches": (Switched.topic,),
    "timesteps": (Timestep.topic,),
}
"""Tables with exactly one row for each record of these topics."""

EVERY: Mapping[str, tuple[str, ...]] = {
    "notes": (ExperimenterNoted.topic,),
    "deviations": (Deviation.topic, Resumed.topic),
}
"""The same, with those records before which a resumed session began anew."""


@dataclasses.dataclass(frozen=True, slots=True)
class Count:
    """Rows of a table against records.

    Attributes:
        table: the table's name.
        rows: how many rows were written.
        records: how many records there are.
    """

    table: str
    rows: int
    records: int

    @property
    def agrees(self) -> bool:
        """Whether nothing was lost and nothing added."""
        return self.rows == self.records


def reconcile(study: StudyRecordings, rows: Mapping[str, int]) -> list[Count]:
    """Count the records behind each table.

    Args:
        study: the recordings.
        rows: rows written, by table.
    """
    counts = [Count("sessions", rows["sessions"], len(study.sessions))]
    begun = sum(len(session.trials) for session in study.sessions)
    counts += [Count(name, rows[name], begun) for name in ("trials", "timing")]
    counts += [
        Count(name, rows[name], _records(study, topics))
        for name, topics in TOPICS.items()
        if name in rows
    ]
    counts += [
        Count(name, rows[name], _every_record(study, topics))
        for name, topics in EVERY.items()
        if name in rows
    ]
    if "scores" in rows:
        # Sessions that recorded no score are scored from their answers: not records of theirs.
        computed = int((scores.build(study).frame["origin"] == scores.COMPUTED).sum())
        recorded = _records(study, (InstrumentScored.topic,))
        counts.append(Count("scores", rows["scores"] - computed, recorded))
    if "robots" in rows:
        counts.append(Count("robots", rows["robots"], _robots(study)))
    return counts


def _records(study: StudyRecordings, topics: tuple[str, ...]) -> int:
    if topics == (Timestep.topic,):
        return sum(
            len(block["trial_id"])
            for session in study.sessions
            for block in session.recording.columns(Timestep.topic)
        )
    return sum(1 for session in study.sessions for _ in session.recording.records(*topics))


def _every_record(study: StudyRecordings, topics: tuple[str, ...]) -> int:
    """Count records, those before which a resumed session began anew included."""
    return sum(len(list(s.recording.every_record(*topics))) for s in study.sessions)


def _robots(study: StudyRecordings) -> int:
    total = 0
    for session in study.sessions:
        for block in session.recording.columns(Timestep.topic):
            total += int(block["robots"].sum())
    return total
