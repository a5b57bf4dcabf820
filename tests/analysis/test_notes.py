"""Notes of the experimenter: a table, and words on the participant's page."""

from __future__ import annotations

import html
from pathlib import Path

import pytest

from analysis.export.reconcile import reconcile
from analysis.recordings import StudyRecordings, load_recordings
from analysis.report import render_report
from analysis.results import compute_results
from analysis.tables.study_tables import StudyTables
from study.events.codes import Phase
from study.events.events import Deviation, Paused, Resumed, TrialStarted
from study.events.experimenter_records import ExperimenterNoted
from study.events.fields import Record
from study.events.participant_events import TextAnswered
from study.recording.client import Recorder
from synthetic_study import Plan, Session

TEXTS = (
    '=HYPERLINK("http://x")',
    "<script>alert(1)</script> & more",
    "\N{ROBOT FACE}\N{WAVING HAND SIGN} שלום مرحبا",
    "x" * 500,
)


def noted(plan: Plan) -> list[Record]:
    """Return a session with a note before its first trial of phase three, and more within it."""
    found: list[Record] = []
    begun = False
    for record in Session(plan).run():
        if isinstance(record, TrialStarted) and record.phase == Phase.THREE and not begun:
            begun = True
            found.append(ExperimenterNoted(record.t_ns, TEXTS[0], -1, 5))
            found.append(record)
            found += [
                ExperimenterNoted(record.t_ns, text, record.trial_id, 5) for text in TEXTS[1:]
            ]
            found += [
                TextAnswered(record.t_ns, "remarks", "words", text, 3, 1, "manual", "once", 5)
                for text in (*TEXTS, "")
            ]
            found.append(Deviation(record.t_ns, "experimenter_paused", "by hand", record.trial_id))
            found.append(Paused(record.t_ns, "experimenter"))
            found.append(Resumed(record.t_ns, 3_000_000_000))
        else:
            found.append(record)
    return found


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> StudyRecordings:
    """Two sessions, one with notes."""
    folder = tmp_path_factory.mktemp("noted")
    for number, participant in enumerate(("P01", "P02")):
        plan = Plan(participant, number, trials=2, timesteps=6, phase_four=False)
        recorder = Recorder.start(folder, participant, {}, {"session_id": f"s{number}"})
        for record in noted(plan) if number == 0 else Session(plan).run():
            recorder.write(record, record.t_ns)
        recorder.close()
    return load_recordings([folder])


def test_any_note_is_text(study: StudyRecordings, tmp_path: Path) -> None:
    """One row a note, as it was typed; no formula in a spreadsheet, no markup in the report."""
    tables = StudyTables(study)
    rows = tables.frame("notes")
    assert list(rows["text"]) == list(TEXTS)
    assert set(rows["participant"]) == {"P01"}
    assert rows["trial_id"][0] == -1
    assert set(rows["phase"][1:]) == {Phase.THREE}
    sheet = tables["notes"].to_csv("1 person")
    assert "'=HYPERLINK" in sheet
    assert ",=HYPERLINK" not in sheet
    counts = reconcile(study, {name: tables.rows(name) for name in tables.names()})
    assert all(count.agrees for count in counts)
    page = render_report(compute_results(study, tables))
    assert "<script>alert" not in page
    for text in TEXTS:
        assert html.escape(text, quote=False).replace('"', "&#34;") in page


def test_free_answers_are_a_table(study: StudyRecordings) -> None:
    """As typed, the open ones too; a line each on the participant's page, markup as text."""
    tables = StudyTables(study)
    rows = tables.frame("texts")
    rows = rows[rows["phase"] == Phase.THREE]
    assert list(rows["text"]) == [*TEXTS, ""]
    assert set(rows["condition"]) == {"manual"}
    assert "'=HYPERLINK" in tables["texts"].to_csv("1 person")
    page = render_report(compute_results(study, tables))
    # And that which the made-up session of P01 ends with.
    assert page.count("Answer to remarks, words") == len(TEXTS) + 1


def test_a_pause_of_the_experimenter_is_told_from_others(study: StudyRecordings) -> None:
    """The deviation at once, the pause with its length and reason when it ended."""
    rows = StudyTables(study).frame("deviations")
    rows = rows[rows["participant"] == "P01"]
    assert list(rows["code"])[:2] == ["experimenter_paused", "paused"]
    assert list(rows["text"])[1] == "Stood still for 3.0 s: experimenter"
