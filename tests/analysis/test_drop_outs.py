"""Drop-outs, whose slots go on to others: told apart, and counted in neither balance nor plan."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path

import pytest
from typer.testing import CliRunner

import synthetic_study
from analysis.commands import main as command
from analysis.formatting import NO_BREAK
from analysis.recordings import load_recordings
from analysis.results import StudyResults, compute_results
from analysis.sections.quality import flags
from analysis.sections.summary import Tile, participants_fact, tiles
from analysis.tables.study_tables import StudyTables
from study.enrolment import editing
from study.enrolment.participants import HOLDING
from study.enrolment.register import Register
from study.errors import StudyError
from study.recording.enrolled import slots
from study.recording.register_folders import FILE_NAME
from synthetic_study import Plan, write_session

AB, BA = ("manual", "assisted"), ("assisted", "manual")
STOPPED = 8
"""Fleet runs after which a drop-out stops: two of the first block were run to their end."""
THROUGH = ("P01", "P05")


@pytest.fixture
def given_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two planned; three drop out of the second slot, one after the other."""
    designed = synthetic_study.PROTOCOL.replace("[phase_three]", '[phase_three]\norder = "ab_ba"')
    monkeypatch.setattr(synthetic_study, "PROTOCOL", designed)
    small = {"trials": 2, "timesteps": 4, "phase_four": False, "planned": 2}
    with Register(tmp_path) as register:
        for visit, who in enumerate(["P01", "P02", "P03", "P04", "P05"]):
            order = register.reserve("synthetic", [AB, BA], pseudonym=who).order
            stops = who not in THROUGH
            register.start("synthetic", who)
            register.finish("synthetic", who, "dropped" if stops else "complete", "")
            # Even places run the first order, odd ones the other.
            plan = Plan(who, 2 * visit + (order == BA), operator_kind="person", **small)  # type: ignore[arg-type]
            write_session(
                tmp_path, dataclasses.replace(plan, stop_after=STOPPED if stops else None)
            )
    return tmp_path


def results_in(folder: Path) -> StudyResults:
    study = load_recordings([folder])
    return compute_results(study, StudyTables(study))


def tile(results: StudyResults, name: str) -> Tile:
    (found,) = (each for each in tiles(results) if each.name == name)
    return dataclasses.replace(found, text=found.text.replace(NO_BREAK, " "))


def uneven(results: StudyResults) -> list[str]:
    """Return what is said of orders that were run unevenly."""
    return [
        row.text.replace(NO_BREAK, " ")
        for row in flags(results)
        if (row.kind, row.session) == ("Order", "all")
    ]


@pytest.mark.parametrize("registered", [True, False])
def test_drop_outs_count_in_neither_balance_nor_plan(given_on: Path, *, registered: bool) -> None:
    """As the register shows it; without one, as one made from the recordings would."""
    if not registered:
        (given_on / FILE_NAME).unlink()
    results = results_in(given_on)
    assert uneven(results) == []
    complete = tile(results, "sessions complete")
    assert (complete.value, complete.of, complete.text) == ("2", "of 5", "3 drop-outs")
    assert not complete.good
    fact = participants_fact(results).replace(NO_BREAK, " ")
    assert fact == "5 in this report, 3 drop-outs among them, 2 planned"
    trials = tile(results, "trials analysed")
    assert (trials.value, trials.of) == ("8", "of 8 planned")
    assert trials.text == "none broken off; 6 of drop-outs too"


def test_where_orders_are_uneven_drop_outs_are_told_apart(given_on: Path) -> None:
    """Those of the register by their slots, those without one by their end."""
    with Register(given_on) as register:
        (last,) = [each for each in register.participants() if each.pseudonym == "P05"]
        editing.mark(register, last, "dropped", "not seen again")
        for who in ("P06", "P07"):
            order = register.reserve("synthetic", [AB, BA], pseudonym=who, order=AB).order
            register.start("synthetic", who)
            register.finish("synthetic", who, "complete")
            plan = Plan(who, 20 + 2 * int(who[2]), trials=2, timesteps=4, phase_four=False)
            write_session(given_on, dataclasses.replace(plan, planned=2, operator_kind="person"))
            assert order == AB
    found = "Not balanced: 3 × Manual then Assisted; 0 × Assisted then Manual; "
    results = results_in(given_on)
    assert uneven(results) == [f"{found}4 drop-outs, who hold no slot, are not counted"]
    assert tile(results, "sessions complete").text == "4 drop-outs; 1 more than planned"
    (given_on / FILE_NAME).unlink()
    results = results_in(given_on)
    assert uneven(results) == [
        "Not balanced: 3 × Manual then Assisted; 1 × Assisted then Manual; "
        "3 sessions that ended early are not counted"
    ]


def test_the_table_has_the_slot_held_now(given_on: Path, tmp_path: Path) -> None:
    """Beside the place at the opening, which somebody else may have after a resume."""
    with Register(given_on) as register:
        assert register.resume("synthetic", "P04").slot == 3
        register.finish("synthetic", "P04", "complete")

    def table() -> dict[str, str]:
        """Return the slots that the table of sessions has."""
        out = tmp_path / "tables"
        done = CliRunner().invoke(command.app, ["tables", str(given_on), "-o", str(out)])
        assert done.exit_code == 0, done.output
        with (out / "sessions.csv").open(encoding="utf-8", newline="") as stream:
            return {row["participant"]: row["slot"] for row in csv.DictReader(stream)}

    assert table() == {"P01": "1", "P02": "0", "P03": "0", "P04": "3", "P05": "2"}
    (given_on / FILE_NAME).unlink()
    assert set(table().values()) == {"-1"}


def test_states_that_hold_a_slot_are_the_registers(tmp_path: Path) -> None:
    """What analysis reads, without the runtime, is what the register gives out."""
    held: dict[tuple[str, str], int] = {}
    with Register(tmp_path) as register:
        for state in ("reserved", "running", "complete", "dropped", "excluded"):
            known = register.reserve("s", [AB, BA], pseudonym=f"{state}1")
            if state != "reserved":
                register.start("s", known.pseudonym)
                register.finish("s", known.pseudonym, state)  # type: ignore[arg-type]
        for each in register.participants():
            held["s", each.pseudonym] = each.slot if each.state in HOLDING else 0
        assert slots(tmp_path) == held
    assert sorted(held.values()) == [0, 0, 1, 2, 3]
    # It speaks for the folders below it, and for no other.
    assert slots(tmp_path / "below") == held
    assert slots(tmp_path.parent) == {}
    (tmp_path / FILE_NAME).write_bytes(b"SQLite format 3\x00" + bytes(200))
    with pytest.raises(StudyError, match="cannot be read"):
        slots(tmp_path)
