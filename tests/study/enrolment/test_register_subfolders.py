"""A register speaks for all folders under its own, as deep as analysis looks."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Collection
from pathlib import Path

import pytest
from typer.testing import CliRunner

from analysis.left_out import LeftOut
from analysis.of_register import OfRegister
from analysis.recordings import find_files, load_recordings
from command_line import study
from recorded_people import COMPLETE, known_in, record
from study.commands import main
from study.commands.enrolling import Enrolled, Finished, assign
from study.commands.resuming import find_boundary
from study.enrolment.importing import ERASED, bring_in_step, note_export
from study.enrolment.register import Register
from study.enrolment.withdrawing import withdraw
from study.errors import StudyError
from study.events.events import SessionEnded
from study.foxglove.export import export
from study.loading import load_protocol
from study.recording.enrolled import planned_orders, tombstones
from study.recording.parts import read_session
from study.recording.register_folders import FILE_NAME, under


def participants(*words: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the command."""
    return study("participants", *words, environment={"COLUMNS": "300", "NO_COLOR": "1"})


def reason(folder: Path, participant: str) -> str:
    """Return why analysis leaves a participant's recording out."""
    (path,) = [path for path in find_files([folder]) if f"_{participant}_" in path.name]
    return LeftOut().reason(read_session(path), "smoke", participant, "person")


def moved(path: Path, folder: Path) -> Path:
    """Put a recording into a folder, as somebody who tidies up does."""
    folder.mkdir(parents=True, exist_ok=True)
    return path.rename(folder / path.name)


def test_withdrawal_reaches_every_folder_below(tmp_path: Path) -> None:
    """A recording moved away, a copy deeper down and an export are all erased; others stay."""
    old = moved(record(tmp_path, "P01", ended=COMPLETE), tmp_path / "archive" / "march")
    shutil.copy(old, tmp_path / "archive" / "copy.mcap")
    export(old, tmp_path / "archive" / "for foxglove.mcap", 1.0)
    record(tmp_path, "P01", ended=COMPLETE)
    other = moved(record(tmp_path, "P02", ended=COMPLETE), tmp_path / "archive")
    done = participants("withdraw", "P01", tmp_path, "--yes")
    assert done.returncode == 0, done.stderr
    assert "and all data were erased: 4 files" in done.stdout
    assert find_files([tmp_path]) == [other]
    assert not (tmp_path / "archive" / "for foxglove.mcap").exists()
    assert known_in(tmp_path)["P01"].state == "withdrawn"


def test_a_session_whose_participant_wants_all_erased_reaches_them_too(tmp_path: Path) -> None:
    """What an earlier session left in a folder below goes with this one."""
    moved(record(tmp_path, "P01", ended=COMPLETE), tmp_path / "archive")
    known_in(tmp_path)
    loaded = load_protocol("smoke")
    assign(loaded, "P01", tmp_path, again=True)
    enrolled = Enrolled(loaded, "P01", tmp_path)
    enrolled.begin()
    asked = SessionEnded(9, complete=False, reason=ERASED)
    now = record(tmp_path, "P01", ended=asked)
    with enrolled:
        enrolled.write_back(Finished((now,), "erased"))
    assert under(tmp_path).files == ()


def test_who_is_known_from_a_folder_below_is_known(tmp_path: Path) -> None:
    """Excluded, a pilot or started again: as for those whose recordings lie beside the register."""
    for name in ("P01", "P02", "P03"):
        moved(record(tmp_path, name, ended=COMPLETE), tmp_path / "archive")
    assert sorted(known_in(tmp_path)) == ["P01", "P02", "P03"]
    with pytest.raises(StudyError, match='"P03" already has a recording'):
        assign(load_protocol("smoke"), "P03", tmp_path)
    for words in (["exclude", "P01", "--reason", "slept"], ["mark-pilot", "P02"]):
        done = participants(*words[:2], tmp_path, *words[2:])
        assert done.returncode == 0, done.stderr
    assert reason(tmp_path, "P01") == "excluded by the experimenter: slept"
    # Also where only the folder below is analysed.
    assert reason(tmp_path / "archive", "P02") == "a pilot session"
    assert reason(tmp_path, "P03") == ""
    plan: OfRegister[tuple[str, ...]] = OfRegister(planned_orders, ())
    order = plan.of(tmp_path / "archive", "smoke", "P03", "person")
    assert order == ("manual", "assisted")


def test_a_tombstone_above_keeps_a_backup_out(tmp_path: Path) -> None:
    """A recording that comes back, into whatever folder below, is not analysed."""
    path = record(tmp_path, "P01", ended=COMPLETE)
    kept = path.read_bytes()
    record(tmp_path, "P02", ended=COMPLETE)
    known_in(tmp_path)
    with Register(tmp_path) as register:
        withdraw(register, "smoke", "P01")
    back = tmp_path / "from backup" / path.name
    back.parent.mkdir()
    back.write_bytes(kept)
    assert reason(back.parent, "P01") == "the participant withdrew"
    # A register between them does not bring the data back either.
    Register(back.parent).close()
    assert reason(back.parent, "P01") == "the participant withdrew"
    (left_out,) = load_recordings([tmp_path]).set_aside
    assert str(left_out) == f"Left out: {path.name}: the participant withdrew"


def test_a_folder_with_a_register_of_its_own_is_named(tmp_path: Path) -> None:
    """Its participants may be others of the same pseudonyms: they are not erased, but told."""
    record(tmp_path, "P01", ended=COMPLETE)
    other = moved(record(tmp_path, "P01", ended=COMPLETE), tmp_path / "other lab")
    known_in(tmp_path / "other lab")
    done = participants("withdraw", "P01", tmp_path, "--yes")
    assert done.returncode == 0, done.stderr
    assert "and these data were erased: 1 file" in done.stdout
    assert f"Not erased: {other.parent} has a register of its own" in done.stderr
    assert f"1 file, {other.name} of P01" in done.stderr
    assert other.exists()
    assert not list(tmp_path.glob("*.mcap"))
    assert tombstones(tmp_path / "other lab") == {}


def test_no_register_is_made_below_another(tmp_path: Path) -> None:
    """Looking into a folder below must not part it from the register above."""
    below = moved(record(tmp_path, "P01", ended=COMPLETE), tmp_path / "archive").parent
    known_in(tmp_path)
    done = participants(below)
    assert done.returncode == 2
    assert f"belong to the register of the folder {tmp_path}" in done.stderr
    assert not (below / FILE_NAME).exists()


def test_a_copied_folder_has_its_own_exports(tmp_path: Path) -> None:
    """Withdrawal in a copy erases the copied export and video, and not those of the original."""
    folder = tmp_path / "recordings"
    path = record(folder, "P01", ended=COMPLETE)
    known_in(folder)
    for name in ("fox.mcap", "film.mp4"):
        (folder / name).write_bytes(path.read_bytes() if name == "fox.mcap" else b"film")
        note_export(path, folder / name)
    outside = tmp_path / "sent.mp4"
    outside.write_bytes(b"film")
    note_export(path, outside)
    copied = shutil.copytree(folder, tmp_path / "copy")
    done = participants("withdraw", "P01", copied, "--yes")
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in copied.iterdir() if p.suffix in {".mcap", ".mp4"}) == []
    assert {p.name for p in folder.iterdir()} >= {path.name, "fox.mcap", "film.mp4"}
    # Of one written elsewhere it is said before anything goes.
    assert f"To be erased: {outside} (not in {copied})" in done.stdout
    assert not outside.exists()


def test_what_is_noted_may_be_given_from_where_one_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Paths from the working folder, and a recording in a folder below the register's."""
    folder = tmp_path / "recordings"
    below = moved(record(folder, "P01", ended=COMPLETE), folder / "archive")
    known_in(folder)
    monkeypatch.chdir(below.parent)
    Path("film.mp4").write_bytes(b"film")
    note_export(Path(below.name), Path("film.mp4"))
    monkeypatch.chdir(tmp_path)
    with Register(Path("recordings")) as register:
        bring_in_step(register)
        erased = withdraw(register, "smoke", "P01")
    assert sorted(path.name for path in erased) == ["film.mp4", below.name]


def test_an_export_among_recordings_is_told_as_one(tmp_path: Path) -> None:
    """It is no damaged file: analysis passes over it and counts no problem."""
    path = record(tmp_path, "P01", ended=COMPLETE)
    export(path, tmp_path / "fox.mcap", 1.0)
    shown = study("replay", tmp_path / "fox.mcap")
    assert shown.returncode == 2
    assert f"fox.mcap is a Foxglove export of {path.name}, and no recording" in shown.stderr
    found = load_recordings([tmp_path])
    assert [str(item) for item in found.set_aside] == [
        f"Left out: fox.mcap: a Foxglove export of {path.name}"
    ]
    assert found.unreadable == 0


def test_a_folder_that_nobody_may_look_into_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What cannot be seen cannot be erased: the answer says so."""
    record(tmp_path, "P01", ended=COMPLETE)
    (tmp_path / "closed").mkdir()
    known_in(tmp_path)
    look = under

    def unseen(folder: Path, names: Collection[str] = ()) -> object:
        found = look(folder, names)
        return type(found)(found.files, found.registers, (folder / "closed",))

    monkeypatch.setattr("study.enrolment.files.under", unseen)
    done = CliRunner().invoke(main.app, ["participants", "withdraw", "P01", str(tmp_path), "--yes"])
    assert done.exit_code == 0, done.output
    assert "closed cannot be looked into" in done.output.replace("\n", "")


def test_a_session_moved_below_is_not_resumed_but_found(tmp_path: Path) -> None:
    """The answer says where its recording lies, and where it has to be."""
    path = moved(record(tmp_path, "P01"), tmp_path / "archive")
    known_in(tmp_path)
    with pytest.raises(StudyError, match="no recording of participant") as caught:
        find_boundary(load_protocol("smoke"), "P01", tmp_path)
    assert caught.value.hint == f"There is {path}: put it, with its other parts, into {tmp_path}."


def test_a_video_that_was_moved_is_found_by_its_name(tmp_path: Path) -> None:
    """It says nothing of whose it is; one of the same name that is somebody else's stays."""
    for name, place in (("P01", tmp_path), ("P02", tmp_path / "second")):
        path = record(tmp_path, name, ended=COMPLETE)
        known_in(tmp_path)
        place.mkdir(exist_ok=True)
        (place / "film.webm").write_bytes(b"film")
        note_export(path, place / "film.webm")
    away = moved(tmp_path / "film.webm", tmp_path / "films" / "march")
    with Register(tmp_path) as register:
        erased = withdraw(register, "smoke", "P01")
    assert away in erased
    assert not away.exists()
    assert (tmp_path / "second" / "film.webm").exists()
