"""A register made from recordings, kept in step with them, and withdrawal."""

from __future__ import annotations

import json
import shutil
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

import pytest
from typer.testing import CliRunner

from analysis.recordings import load_recordings
from protocols import variant
from recorded_people import COMPLETE, known_in, record
from study.commands import main as command
from study.commands.enrolling import Enrolled, Finished, assign, who_broke_off
from study.commands.preflight import preflight_before
from study.commands.simulating import simulate_session, simulated_assignments
from study.enrolment.importing import ERASED, NOT_UNDERSTOOD, bring_in_step
from study.enrolment.not_taking_part import COUNTS
from study.enrolment.process_identity import ProcessIdentity
from study.enrolment.register import Register
from study.enrolment.withdrawing import withdraw
from study.errors import StudyError
from study.events.events import SessionEnded
from study.loading import load_protocol
from study.preflight_result import FILE, Preflight, keep_preflight, read_preflight
from study.recording.enrolled import tombstones
from study.recording.register_folders import FILE_NAME


def test_a_register_is_made_from_recordings(tmp_path: Path) -> None:
    """States, orders and pilots come from the files; what is of no person is passed over."""
    record(tmp_path, "P01", ended=COMPLETE)
    record(tmp_path, "P02", ("assisted", "manual"), SessionEnded(9, complete=False, reason="tired"))
    record(tmp_path, "P03", ended=SessionEnded(9, complete=False, reason=NOT_UNDERSTOOD))
    record(tmp_path, "P04", ("assisted", "manual"))
    record(tmp_path, "P05", ended=COMPLETE, pilot=True)
    (tmp_path / "torn.mcap").write_bytes(b"torn")
    loaded = load_protocol("smoke")
    (simulated,) = simulated_assignments(loaded, 1, seed=1)
    simulate_session("smoke", simulated, 1, tmp_path)
    found = known_in(tmp_path)
    assert {name: each.shown_state for name, each in found.items()} == {
        "P01": "complete", "P02": "dropped", "P03": "excluded", "P04": "interrupted",
        "P05": "complete",
    }  # fmt: skip
    assert found["P05"].pilot
    assert (found["P01"].slot, found["P04"].slot) == (1, 2)
    assert found["P04"].order == ("assisted", "manual")
    # The same from nothing, and nothing anew from what is known.
    (tmp_path / FILE_NAME).unlink()
    assert known_in(tmp_path) == found
    assert known_in(tmp_path) == found
    assert who_broke_off(loaded, tmp_path) == "P04"
    with pytest.raises(StudyError, match='"P01" already has a recording'):
        assign(loaded, "P01", tmp_path)
    assert assign(loaded, "", tmp_path).planned_index == 2


def test_an_outcome_that_was_not_written_back_is_read(tmp_path: Path) -> None:
    """Killed after the last record: the recording says that the session is complete."""
    path = record(tmp_path, "P01", ended=COMPLETE)
    away = shutil.move(path, tmp_path / "away")
    dead = ProcessIdentity("here", 1, "x")
    with Register(tmp_path, me=dead, alive=lambda _: False) as register:
        register.reserve("smoke", [("manual", "assisted")], pseudonym="P01")
        register.start("smoke", "P01")
        bring_in_step(register)
        assert register.participants()[0].shown_state == "interrupted"
        shutil.move(away, path)
        bring_in_step(register)
        assert register.participants()[0].state == "complete"


def lease(folder: Path) -> Enrolled:
    """Reserve for a participant."""
    loaded = load_protocol("smoke")
    assign(loaded, "P01", folder)
    return Enrolled(loaded, "P01", folder)


@pytest.mark.parametrize(
    ("finished", "state"),
    [
        (Finished((), "complete"), "complete"),
        (Finished((), "ended_early", "stopped by the participant"), "dropped"),
        (Finished((), "ended_early", NOT_UNDERSTOOD), "excluded"),
        (Finished((), "erased"), "withdrawn"),
    ],
)
def test_outcomes_are_written_back(tmp_path: Path, finished: Finished, state: str) -> None:
    """Each end of a session has its state; an early one its reason."""
    enrolled = lease(tmp_path)
    with enrolled:
        enrolled.begin()
        enrolled.write_back(finished)
    known = known_in(tmp_path)["P01"]
    assert known.state == state
    assert known.reason == finished.reason


def test_an_error_in_the_study_is_an_interruption(tmp_path: Path) -> None:
    """Before the recording began nothing is kept; after it the slot is, for --resume."""
    enrolled = lease(tmp_path)
    with pytest.raises(OSError, match="x"), enrolled:
        raise OSError("x")
    assert known_in(tmp_path) == {}
    enrolled = lease(tmp_path)
    enrolled.begin()
    with pytest.raises(OSError, match="no window"), enrolled:
        raise OSError("no window")
    known = known_in(tmp_path)["P01"]
    assert (known.shown_state, known.reason, known.slot) == ("interrupted", "no window", 1)
    assert enrolled.resume().slot == 1


def test_a_register_that_fails_at_the_end_costs_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The session's end is told, not lost: the outcome is read from the recording later."""
    enrolled = lease(tmp_path)
    with enrolled:
        enrolled.begin()
        (tmp_path / FILE_NAME).write_bytes(b"broken" * 1000)
        enrolled.write_back(Finished((), "complete"))
    assert "could not be written into the register" in capsys.readouterr().err


def second_visit(folder: Path) -> tuple[Enrolled, Path]:
    """Record one session of P01, and begin another; return its lease and its recording."""
    record(folder, "P01", ended=COMPLETE)
    loaded = load_protocol("smoke")
    assign(loaded, "P01", folder, again=True)
    enrolled = Enrolled(loaded, "P01", folder)
    enrolled.begin()
    asked = SessionEnded(9, complete=False, reason=ERASED)
    return enrolled, record(folder, "P01", ended=asked)


def test_erasing_in_a_second_visit_erases_the_first_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All of the participant's data go, as the screen says, and it is counted once."""
    folder = tmp_path / "recordings"
    enrolled, now = second_visit(folder)
    record(folder, "P02", ended=COMPLETE)
    with enrolled:
        enrolled.write_back(Finished((now,), "erased"))
    assert "had all data erased: 2 files, smoke_P01_" in capsys.readouterr().err
    assert [path.name.split("_")[1] for path in folder.glob("*.mcap")] == ["P02"]
    assert known_in(folder)["P01"].state == "withdrawn"
    assert json.loads((folder / COUNTS).read_text())["smoke"]["erased"] == 1
    assert (folder / COUNTS).stat().st_mode & 0o077 == 0


def test_a_file_erased_is_counted_once_and_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where the folder is given from the present one, and the recorder knows all of it."""
    monkeypatch.chdir(tmp_path)
    folder = Path("recordings")
    assign(load_protocol("smoke"), "P01", folder)
    enrolled = Enrolled(load_protocol("smoke"), "P01", folder)
    enrolled.begin()
    asked = SessionEnded(9, complete=False, reason=ERASED)
    now = record(folder, "P01", ended=asked).absolute()
    with enrolled:
        enrolled.write_back(Finished((now,), "erased"))
    assert f"had all data erased: 1 file, {now.name}. A tombstone" in capsys.readouterr().err


def test_erasing_is_finished_where_the_study_was_killed_before(tmp_path: Path) -> None:
    """The recording says that all is to be erased: that is done when it is next looked at."""
    folder = tmp_path / "recordings"
    second_visit(folder)
    me = enrolled_by(folder)
    with Register(folder, me=ProcessIdentity("here", 1, "x"), alive=lambda _: True) as register:
        bring_in_step(register)
        # The session's process lives, and does so itself.
        assert len(list(folder.glob("*.mcap"))) == 2
    with Register(folder, me=me, alive=lambda _: False) as register:
        bring_in_step(register)
    assert not list(folder.glob("*.mcap"))
    assert list(tombstones(folder)["smoke"]) == ["P01"]


def enrolled_by(folder: Path) -> ProcessIdentity:
    """Return the process that conducts P01's session."""
    with Register(folder) as register:
        known = register.find("smoke", "P01")
    assert known is not None
    assert known.lease is not None
    return known.lease


def test_what_cannot_be_erased_is_said(tmp_path: Path) -> None:
    """Where the register cannot be used this recording goes all the same, and the rest is named."""
    folder = tmp_path / "recordings"
    enrolled, now = second_visit(folder)
    (folder / FILE_NAME).write_bytes(b"broken" * 1000)
    with (
        enrolled,
        pytest.raises(StudyError, match=r"not all data of P01(.|\n)*withdraw P01"),
    ):
        enrolled.write_back(Finished((now,), "erased"))
    assert not now.exists()
    assert len(list(folder.glob("*.mcap"))) == 1


def withdrawn_folder(folder: Path) -> list[str]:
    """Record two participants, withdraw one; return what files there are."""
    record(folder, "P01", ended=COMPLETE)
    shutil.copy(record(folder, "P02", ended=COMPLETE), folder / "salvaged copy.mcap")
    done = CliRunner().invoke(
        command.app, ["participants", "withdraw", "P02", str(folder), "--yes"]
    )
    assert done.exit_code == 0, done.output
    assert "all data were erased: 2 files, salvaged copy.mcap, smoke_P02_" in done.output
    return sorted(path.name for path in folder.iterdir())


def test_withdrawal_erases_and_leaves_a_tombstone(tmp_path: Path) -> None:
    """Recordings and copies are gone, and nothing but pseudonym and time is kept."""
    left = withdrawn_folder(tmp_path)
    assert [name for name in left if "P02" in name or "copy" in name] == []
    assert left[:2] == ["not_taking_part.json", FILE_NAME]
    known = known_in(tmp_path)["P02"]
    assert (known.state, known.order, known.slot) == ("withdrawn", (), 0)
    assert list(tombstones(tmp_path)["smoke"]) == ["P02"]
    loaded = load_protocol("smoke")
    for again in (False, True):
        with pytest.raises(StudyError, match="withdrew"):
            assign(loaded, "P02", tmp_path, again=again)
    shown = CliRunner().invoke(command.app, ["participants", "history", "P02", str(tmp_path)])
    assert "P02: withdrew at " in shown.output
    # The tombstone outlives the register.
    (tmp_path / FILE_NAME).unlink()
    with pytest.raises(StudyError, match="withdrew"):
        assign(loaded, "P02", tmp_path)
    assert known_in(tmp_path)["P02"].state == "withdrawn"


def rehearsed(folder: Path, participant: str) -> Preflight:
    """Keep a preflight for a participant, and what one that was killed left behind."""
    made = Preflight(
        utc="2026-01-02T03:04:05+00:00", host="lab", protocol="smoke.toml",
        protocol_sha256="0" * 64, participant=participant, seconds=1.0, checks=(),
    )  # fmt: skip
    folder.mkdir(exist_ok=True)
    keep_preflight(folder, made)
    (folder / f".{FILE}.part").write_text(participant)
    return made


@pytest.mark.parametrize("spelled", ["P02", "p02"])
def test_a_preflight_forgets_who_withdrew(tmp_path: Path, spelled: str) -> None:
    """The pseudonym goes from it, whatever its capitals; all else counts as before."""
    made = rehearsed(tmp_path, spelled)
    withdrawn_folder(tmp_path)
    assert read_preflight(tmp_path) == made.model_copy(update={"participant": ""})
    assert not list(tmp_path.glob(".*"))
    assert (tmp_path / FILE).stat().st_mode & 0o077 == 0


def test_a_preflight_of_somebody_else_is_kept(tmp_path: Path) -> None:
    """Whose rehearsal it was is nobody else's to erase; what is no preflight goes whole."""
    made = rehearsed(tmp_path, "P01")
    withdrawn_folder(tmp_path)
    assert read_preflight(tmp_path) == made
    (tmp_path / FILE).write_text("P02, but no preflight")
    with Register(tmp_path) as register:
        withdraw(register, "smoke", "P02")
    assert not (tmp_path / FILE).exists()


def test_a_preflight_that_cannot_be_changed_is_named(tmp_path: Path) -> None:
    """The data are erased by then; saying it again finishes it."""
    (tmp_path / FILE).mkdir()
    path = record(tmp_path, "P01", ended=COMPLETE)
    known_in(tmp_path)
    with Register(tmp_path) as register:
        with pytest.raises(StudyError, match=rf"{FILE} may name P01"):
            withdraw(register, "smoke", "P01")
        assert not path.exists()
        (tmp_path / FILE).rmdir()
        withdraw(register, "smoke", "P01")


@pytest.mark.parametrize("outcome", ["declined", "erased"])
def test_a_preflight_forgets_who_declined_or_had_all_erased(
    tmp_path: Path, outcome: Literal["declined", "erased"]
) -> None:
    """Both leave no pseudonym there."""
    rehearsed(tmp_path, "P01")
    with lease(tmp_path) as enrolled:
        if outcome == "erased":
            enrolled.begin()
        enrolled.write_back(Finished((), outcome))
    kept = read_preflight(tmp_path)
    assert kept is not None
    assert kept.participant == ""


def test_a_preflight_forgets_whose_slot_is_released(tmp_path: Path) -> None:
    """Of who had no session nothing is kept, as the command says."""
    rehearsed(tmp_path, "P01")
    lease(tmp_path)
    done = CliRunner().invoke(command.app, ["participants", "release", "P01", str(tmp_path)])
    assert "nothing is kept" in done.output
    assert "P01" not in (tmp_path / FILE).read_text()


def test_a_recording_does_not_name_whom_a_preflight_was_for(tmp_path: Path) -> None:
    """It could not be erased from there when that participant withdraws."""
    made = rehearsed(tmp_path, "P01")
    now = datetime.now(UTC).isoformat(timespec="seconds")
    keep_preflight(tmp_path, made.model_copy(update={"utc": now}))
    for participant, said in (("P02", "another"), ("", "a named")):
        remark = preflight_before(tmp_path, made.protocol_sha256, "", participant).remark
        assert remark.endswith(f"; rehearsed for {said} participant")
    assert "rehearsed" not in preflight_before(tmp_path, made.protocol_sha256, "", "P01").remark


def test_sessions_to_go_on_with_are_told_by_how_they_ended(tmp_path: Path) -> None:
    """What was ended on purpose is not said to have broken off."""
    for name in ("P01", "P02"):
        record(tmp_path, name, ended=SessionEnded(9, complete=False, reason=f"{name} is tired"))
    with pytest.raises(
        StudyError, match=r"interrupted: none; ended early: P01 \(P01 is tired\), P02"
    ):
        who_broke_off(load_protocol("smoke"), tmp_path)


def test_nobody_elses_data_are_erased_for_a_name_that_begins_alike(tmp_path: Path) -> None:
    """P01_b is another participant than P01; a file that cannot be read is told by its name."""
    own, other = record(tmp_path, "P01", ended=COMPLETE), record(tmp_path, "P01_b", ended=COMPLETE)
    known_in(tmp_path)
    unread = [path.with_name(f"{path.stem}_salvaged.mcap") for path in (own, other)]
    for path in unread:
        path.write_bytes(b"torn")
    with Register(tmp_path) as register:
        assert withdraw(register, "smoke", "P01") == sorted([own, unread[0]])
    assert other.exists()
    assert unread[1].exists()


def test_an_export_is_erased_too(tmp_path: Path) -> None:
    """What was made from one participant's recording goes with it, wherever it lies."""
    folder, elsewhere = tmp_path / "recordings", tmp_path / "elsewhere" / "scene.mcap"
    elsewhere.parent.mkdir()
    path = record(folder, "P01", ended=COMPLETE)
    assert known_in(folder)
    words = ["export-foxglove", str(path), "-o", str(elsewhere)]
    done = CliRunner().invoke(command.app, words)
    assert elsewhere.exists(), done.output
    with Register(folder) as register:
        assert withdraw(register, "smoke", "P01") == [elsewhere, path]
    assert not elsewhere.exists()


def test_a_copy_put_back_is_not_analysed(tmp_path: Path) -> None:
    """A backup of who withdrew is set aside, and erased when it is said once more."""
    withdrawn_folder(tmp_path)
    back = record(tmp_path, "P02", ended=COMPLETE)
    study = load_recordings([tmp_path])
    assert [session.opened.participant for session in study.sessions] == ["P01"]
    assert [(item.file, item.reason) for item in study.set_aside] == [
        (back.name, "the participant withdrew")
    ]
    with Register(tmp_path) as register:
        bring_in_step(register)
        assert withdraw(register, "smoke", "P02") == [back]


def test_pilots_and_excluded_are_set_aside(tmp_path: Path) -> None:
    """With the reason; marks in the register count for more than what the file says."""
    for name in ("P01", "P02"):
        record(tmp_path, name, ended=COMPLETE)
    record(tmp_path, "P03", ended=COMPLETE, pilot=True)

    def aside() -> dict[str, str]:
        return {each.participant: each.reason for each in load_recordings([tmp_path]).set_aside}

    assert aside() == {"P03": "a pilot session"}
    run = CliRunner()
    for words in (["exclude", "P02", "--reason", "fell ill"], ["unmark-pilot", "P03"]):
        done = run.invoke(command.app, ["participants", *words[:2], str(tmp_path), *words[2:]])
        assert done.exit_code == 0, done.output
    assert aside() == {"P02": "excluded by the experimenter: fell ill"}
    shown = run.invoke(command.app, ["participants", str(tmp_path), "--json"])
    rows = {row["pseudonym"]: row for row in json.loads(shown.stdout)}
    assert {name: row["state"] for name, row in rows.items()} == {
        "P01": "complete", "P02": "excluded", "P03": "complete",
    }  # fmt: skip
    assert rows["P02"]["slot"] is None


def test_an_other_study_of_the_same_pseudonym_is_left_alone(tmp_path: Path) -> None:
    """Withdrawing from one study erases nothing of another."""
    record(tmp_path, "P01", ended=COMPLETE)
    loaded = load_protocol(str(variant(tmp_path, ('name = "smoke"', 'name = "other"'))))
    assign(loaded, "P01", tmp_path)
    done = CliRunner().invoke(
        command.app, ["participants", "withdraw", "P01", str(tmp_path), "--yes"]
    )
    assert done.exit_code != 0
    assert "takes part in" in str(done.exception)
    with Register(tmp_path) as register:
        bring_in_step(register)
        assert len(withdraw(register, "smoke", "P01")) == 1
        assert [each.state for each in register.participants()] == ["reserved", "withdrawn"]
