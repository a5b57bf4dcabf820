"""Disturbed trials: told apart in the tables, and left out where the protocol says so."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from analysis.measures import analysed_data
from analysis.protocol_facts import TrialExclusionRule, protocol_facts
from analysis.recordings import StudyRecordings, load_recordings
from analysis.results import compute_results
from analysis.sections.quality import flags, rules
from analysis.tables.study_tables import StudyTables
from study.events.codes import Phase
from study.events.events import Deviation, Paused, Resumed, StageEntered, TrialStarted
from study.events.fields import Record
from study.events.inputs import RecordingInterrupted, RecordingRestored, SessionResumed
from study.recording.client import Recorder
from synthetic_study import Plan, Session

RULE = TrialExclusionRule("undisturbed", frozenset({"recording_interrupted", "resumed"}), "why")


def disturbed() -> list[Record]:
    """Return a session in which one trial is paused, one interrupted and one begun anew."""
    found: list[Record] = []
    three = 0
    for record in Session(Plan("P01", 0, trials=4, timesteps=6, phase_four=False)).run():
        starts = isinstance(record, TrialStarted) and record.phase == Phase.THREE
        three += starts
        now = record.t_ns
        if starts and three == 3:
            found.append(SessionResumed(now, 3, 1, 4.0))
            found.append(Deviation(now, "resumed", "part 3 goes on", -1))
            found.append(StageEntered(now, 9, "trial", "phase_three", 3, 1, "manual"))
        found.append(record)
        if starts and three == 1:
            found += [Paused(now, "operator"), Resumed(now, 2_000_000_000)]
        if starts and three == 2 and isinstance(record, TrialStarted):
            found.append(RecordingInterrupted(now, "disk full"))
            found.append(RecordingRestored(now, 2))
            found.append(Deviation(now, "recording_interrupted", "disk full", record.trial_id))
    return found


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> StudyRecordings:
    """The session, recorded in one file and read."""
    folder = tmp_path_factory.mktemp("disturbed")
    recorder = Recorder.start(folder, "P01", {}, {"session_id": "s1"})
    for record in disturbed():
        recorder.write(record, record.t_ns)
    assert recorder.close() == Path(folder / "P01.mcap")
    return load_recordings([folder])


def test_each_deviation_has_its_part_and_its_trial(study: StudyRecordings) -> None:
    """A pause and a failure belong to the trial that ran, a resume to the one begun anew."""
    tables = StudyTables(study)
    rows = tables.frame("deviations")
    assert list(rows["code"]) == ["paused", "recording_interrupted", "resumed"]
    assert list(rows["part"]) == [1, 2, 3]
    assert list(rows["trial"]) == [1, 2, 3]
    assert list(rows["phase"]) == [3, 3, 3]
    trials = tables.frame("trials")
    three = trials[trials["phase"] == Phase.THREE]
    assert list(three["deviations"])[:4] == ["paused", "recording_interrupted", "resumed", ""]


def test_a_rule_leaves_disturbed_trials_out_and_counts_them(study: StudyRecordings) -> None:
    """Without a rule all are kept; with one those it names are gone, and listed."""
    tables = StudyTables(study)
    facts = protocol_facts(study)
    assert facts.trial_exclusions == ()
    everything = analysed_data(study, tables, facts)
    assert len(everything.trials) == 8
    assert len(everything.excluded_trials) == 0
    ruled = analysed_data(study, tables, dataclasses.replace(facts, trial_exclusions=(RULE,)))
    assert len(ruled.trials) == 6
    assert list(ruled.excluded_trials["trial"]) == [2, 3]
    assert set(ruled.excluded_trials["rule"]) == {"undisturbed"}


def test_the_report_names_them(study: StudyRecordings) -> None:
    """The quality section says which trials a rule left out."""
    protocol = {
        **study.first.protocol,
        "trial_exclusions": [
            {"name": "undisturbed", "deviations": ["resumed"], "reason": "seen before"}
        ],
    }
    ruled = dataclasses.replace(
        study, sessions=(dataclasses.replace(study.first, protocol=protocol),)
    )
    results = compute_results(ruled, StudyTables(ruled))
    row = rules(results)[0]
    assert (row.what, row.found) == ("trials: resumed", "1\u00a0trial of P01")
    texts = [(flag.kind, flag.text, flag.treatment) for flag in flags(results)]
    assert (
        "Excluded trial",
        "Trial 3 under Manual: rule undisturbed (resumed)",
        "Not in the tests",
    ) in texts
    treatments = {text: treatment for kind, text, treatment in texts if kind == "Deviation"}
    assert treatments["Resumed: part 3 goes on"] == "Its trial is not in the tests"
    assert treatments["Recording interrupted: disk full"] == "Kept"
