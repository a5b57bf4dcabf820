"""What the report says of files, sessions and orders: each fact once, under its right name."""

from __future__ import annotations

import dataclasses
import html
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from analysis.commands import main as command
from analysis.formatting import NO_BREAK
from analysis.recordings import StudyRecordings, load_recordings
from analysis.report import render_report
from analysis.results import StudyResults, compute_results
from analysis.sections.orders import changed_orders, uneven_orders
from analysis.sections.participants import pages
from analysis.sections.quality import flags
from analysis.sections.summary import Tile, tiles
from analysis.tables.study_tables import StudyTables
from study.enrolment.register import Register
from study.events.events import Deviation, Paused, Resumed, SessionEnded
from study.events.fields import Record
from study.events.inputs import RecordingInterrupted, RecordingRestored
from study.recording.client import Recorder
from study.recording.register_folders import FILE_NAME
from synthetic_study import Plan, Session, write_session

AB, BA = ("manual", "assisted"), ("assisted", "manual")


def person(participant: str, index: int, **changes: object) -> Plan:
    """Return a small session of a person; even places run the first order, odd ones the other."""
    small = {"trials": 1, "timesteps": 4, "phase_four": False, "planned": 2}
    plan = {**small, "operator_kind": "person", **changes}
    return Plan(participant, index, **plan)  # type: ignore[arg-type]


def results_in(folder: Path) -> StudyResults:
    study = load_recordings([folder])
    return compute_results(study, StudyTables(study))


@pytest.fixture(scope="module")
def visited(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three participants of two planned, one of whom came twice, a pilot, and a damaged file."""
    folder: Path = tmp_path_factory.mktemp("visited")
    write_session(folder, person("P01", 0))
    write_session(folder, person("P02", 1, stop_after=5))
    write_session(folder, person("P03", 2))
    write_session(folder, person("P04", 3))
    again = write_session(folder, person("P01", 4))
    again.rename(folder / "second_visit.mcap")
    (folder / "torn.mcap").write_bytes(b"torn")
    with Register(folder) as register:
        register.reserve("synthetic", [AB, BA], pseudonym="P04", pilot=True)
    return folder


def tile(results: StudyResults, name: str) -> Tile:
    (found,) = (each for each in tiles(results) if each.name == name)
    return found


def test_the_header_says_which_number_counts_what(visited: Path) -> None:
    """Participants beside those planned; complete sessions beside all; files by what they are."""
    results = results_in(visited)
    page = html.unescape(render_report(results)).replace("\N{NO-BREAK SPACE}", " ")
    facts = dict(re.findall(r"<dt>(Participants|Sessions)</dt><dd>(.*?)</dd>", page))
    assert facts["Participants"] == "3 in this report, 1 drop-out among them, 2 planned"
    assert re.sub("<.*?>", "", facts["Sessions"]) == (
        "2 of 3 complete, 2 files left out, 1 file unreadable"
    )
    complete = tile(results, "sessions complete")
    assert (complete.value, complete.of) == ("2", "of 3")
    # The slot of who ended early goes on to the third: nobody is one more than planned.
    assert complete.text.replace(NO_BREAK, " ") == "1 drop-out"


def test_what_is_left_out_is_no_problem(visited: Path) -> None:
    """A second visit and a pilot are left out, with the reason; only the torn file is a problem."""
    results = results_in(visited)
    assert tile(results, "files with problems").value == "1"
    rows = {(row.kind, row.session): row for row in flags(results)}
    second = rows["File left out", "P01"]
    assert second.text == ("second_visit.mcap: another session of P01; session_00.mcap is analysed")
    assert rows["File left out", "P04"].text == "session_03.mcap: a pilot session"
    assert rows["File", "torn.mcap"].treatment == "Cannot be used"
    done = CliRunner().invoke(command.app, ["tables", str(visited), "-o", str(visited / "tables")])
    assert "Left out: session_03.mcap: a pilot session" in done.output
    assert "Cannot be used: torn.mcap: it is no recording" in done.output


def deviating() -> list[Record]:
    """Return a session paused by everybody in turn, and ended by the experimenter."""
    now, still = 10**9, 3 * 10**9
    reason = "ended by the experimenter: hot"
    found = Session(person("P01", 0, stop_after=9)).run()[:-1]
    found += [
        *(Paused(now, "operator"), Resumed(now, still)),
        Deviation(now, "experimenter_paused", "the experimenter paused the session", 8),
        *(Paused(now, "experimenter"), Resumed(now, still)),
        *(RecordingInterrupted(now, "no space left"), Paused(now, "recording interrupted")),
        RecordingRestored(now, 2),
        Deviation(now, "recording_interrupted", "no space left; recorded in part 2 from here", 8),
        Resumed(now, still),
        # The participant had paused already: nothing stood still for the experimenter.
        Paused(now, "operator"),
        Deviation(now, "experimenter_paused", "the experimenter paused the session", 8),
        Resumed(now, still),
        Deviation(now, "robot_stopped", "robot 2 stopped: pose lost", 8),
        Deviation(now, "ended_early", f"{reason}; at stage survey, phase 3", -1),
    ]
    return [*found, SessionEnded(now + 1, complete=False, reason=reason)]


@pytest.fixture(scope="module")
def deviated(tmp_path_factory: pytest.TempPathFactory) -> StudyResults:
    """The results of that session alone."""
    folder = tmp_path_factory.mktemp("deviated")
    recorder = Recorder.start(folder, "P01", {}, {"session_id": "s0000"})
    for record in deviating():
        recorder.write(record, record.t_ns)
    recorder.close()
    return results_in(folder)


TOLD = [
    "Stood still for 3.0 s: participant",
    "The experimenter paused the session; stood still for 3.0 s",
    "Recording interrupted: no space left; recorded in part 2 from here; stood still for 3.0 s",
    "The experimenter paused the session",
    "Stood still for 3.0 s: participant",
    "Robot 2 stopped: pose lost",
]


def test_each_deviation_is_told_once(deviated: StudyResults) -> None:
    """Neither kind nor reason twice, a pause with what brought it about, an end in one row."""
    found = [(row.kind, row.text) for row in flags(deviated)]
    assert [text for kind, text in found if kind == "Deviation"] == TOLD
    end = "Ended early by the experimenter: hot; at stage survey, phase 3"
    assert [text for _, text in found if "hot" in text] == [end]
    assert ("Incomplete session", end) in found
    assert tile(deviated, "deviations").value == str(len(TOLD) + 1)


def test_a_participants_page_tells_the_same(deviated: StudyResults) -> None:
    """In the same words, an early end among them."""
    (page,) = pages(deviated)
    end = "Ended early by the experimenter: hot; at stage survey, phase 3"
    assert [note for note in page.notes if note in (*TOLD, end)] == [*TOLD, end]
    assert not any("(ended_early)" in note for note in page.notes)


def test_who_paused_is_called_the_participant(deviated: StudyResults) -> None:
    """In the table too; what is recorded of it stays "operator"."""
    rows = deviated.tables.frame("deviations")
    paused = rows[rows["code"] == "paused"]
    assert next(iter(paused["text"])) == "Stood still for 3.0 s: participant"
    recorded = deviated.study.first.recording.records(Paused.topic)
    assert next(record.reason for _, record in recorded if isinstance(record, Paused)) == "operator"


def test_an_order_run_against_the_plan_is_flagged(tmp_path: Path) -> None:
    """The register beside the recordings tells what the plan had, first sessions and later ones."""
    with Register(tmp_path) as register:
        for index, given in enumerate([AB, (), BA]):
            write_session(tmp_path, person(f"P0{index + 1}", index))
            ran = register.reserve("synthetic", [BA, AB], pseudonym=f"P0{index + 1}", order=given)
            assert ran.order == (AB, BA, BA)[index]
    # P01: set by hand. P02: as the plan had it. P03: the register has another than was run.
    rows = [(row.session, row.text) for row in flags(results_in(tmp_path)) if row.kind == "Order"]
    assert rows == [
        ("P01", "Manual then Assisted was run; the plan had Assisted then Manual"),
        ("P03", "Manual then Assisted was run; the plan had Assisted then Manual"),
    ]
    # Without a register nothing is known of a plan.
    (tmp_path / FILE_NAME).unlink()
    assert not [row for row in flags(results_in(tmp_path)) if row.kind == "Order"]


def test_orders_outside_the_design_and_uneven_ones_are_flagged(results: StudyResults) -> None:
    """That much the recordings tell by themselves."""

    def designed(design: str, order: tuple[str, ...] | None = None) -> StudyRecordings:
        sessions = [
            dataclasses.replace(
                session,
                protocol={**session.protocol, "phase_three": {"trials": 3, "order": design}},
                opened=dataclasses.replace(
                    session.opened, order=order if order and place < 4 else session.opened.order
                ),
            )
            for place, session in enumerate(results.study.sessions)
        ]
        return dataclasses.replace(results.study, sessions=tuple(sessions))

    facts = results.facts
    assert changed_orders(designed("ab_ba"), facts) == []
    assert uneven_orders(designed("ab_ba"), facts) == ""
    found = changed_orders(designed("fixed"), facts)
    assert [who for who, _ in found] == ["P02", "P04", "P06", "P08"]
    assert found[0][1] == "Assisted then Manual was run; it is none of the design's orders"
    uneven = uneven_orders(designed("ab_ba", AB), facts)
    # P07 ended early: as in a register made of the recordings, it counts in no order.
    assert uneven.replace(NO_BREAK, " ") == (
        "5 × Manual then Assisted; 2 × Assisted then Manual; "
        "1 session that ended early is not counted"
    )
    shown = flags(dataclasses.replace(results, study=designed("ab_ba", AB)))
    assert ("Order", "all", f"Not balanced: {uneven}") in [
        (row.kind, row.session, row.text) for row in shown
    ]
