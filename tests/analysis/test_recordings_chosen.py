"""Which recordings are analysed, and what is refused."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from analysis.commands.writing import open_recordings
from analysis.measures import analysed_data
from analysis.protocol_facts import protocol_facts
from analysis.recordings import StudyRecordings, choose_sessions, load_recordings
from analysis.tables.study_tables import StudyTables
from study.errors import StudyError
from study.recording.client import Recorder
from synthetic_study import Plan, tear, write_session


def small(participant: str, index: int, **changes: object) -> Plan:
    plan = {"trials": 1, "timesteps": 4, "phase_four": False, **changes}
    return Plan(participant, index, **plan)  # type: ignore[arg-type]


def test_unusable_files_are_set_aside_with_the_reason(study: StudyRecordings) -> None:
    """A file that is no recording is named, not passed over and not fatal."""
    assert [item.file for item in study.set_aside] == ["notes.mcap"]
    # The file is named once, beside the reason.
    assert study.set_aside[0].reason == (
        "it is no recording of this program: it does not begin as an MCAP file."
    )


def test_an_empty_file_is_called_empty(tmp_path: Path) -> None:
    """As a copy that ran out of disk leaves it; not a file of another program."""
    (tmp_path / "empty.mcap").write_bytes(b"")
    with pytest.raises(StudyError) as caught:
        load_recordings([tmp_path])
    assert caught.value.message.splitlines()[1:] == ["  empty.mcap: it is empty: it has 0 bytes"]


def test_torn_session_is_kept_as_far_as_it_goes(study: StudyRecordings) -> None:
    """The torn file's session is there, incomplete, with its problem in words."""
    torn = study.sessions[-1]
    assert torn.opened.participant == "P08"
    assert not torn.complete
    assert torn.recording.problems
    assert len(torn.trials) > 0


def test_a_damaged_file_is_named_once(tmp_path: Path) -> None:
    """Beside what is wrong with it; of several parts it is said which."""
    whole = write_session(tmp_path, small("A", 0))
    torn = whole.with_name(f"{whole.name}.part")
    torn.write_bytes(whole.read_bytes()[:-40])
    whole.unlink()
    output = Console(file=StringIO(), width=1000)
    open_recordings([tmp_path], output, pool=False)
    told = output.file.getvalue()  # type: ignore[attr-defined]
    damaged = [line for line in told.splitlines() if line.startswith("Damaged: ")]
    assert f"Damaged: {torn.name}: Its summary and index are missing." in damaged
    assert [line.count(torn.name) for line in damaged] == [1] * len(damaged)


def test_different_protocols_are_pooled_only_on_request(tmp_path: Path) -> None:
    """Two protocols are refused with both hashes named, and pooled when asked."""
    write_session(tmp_path, small("A", 0))
    write_session(tmp_path, small("B", 1, title="Another study"))
    with pytest.raises(StudyError, match="2 different protocols") as caught:
        load_recordings([tmp_path])
    assert "--pool-protocols" in caught.value.hint
    assert "session_00.mcap" in caught.value.message
    assert len(load_recordings([tmp_path], pool=True).sessions) == 2


def test_where_each_protocol_is_and_how_to_choose_are_told(tmp_path: Path) -> None:
    """The demo lies in a folder of the default one: it is seen, and the rest can be named."""
    inner = tmp_path / "demo"
    inner.mkdir()
    for number in range(4):
        made = write_session(tmp_path, small(f"P{number}", number))
        made.rename(tmp_path / f"synthetic_P{number}.mcap")
    write_session(inner, small("S01", 9, title="Another study"))
    with pytest.raises(StudyError, match="2 different protocols") as caught:
        load_recordings([tmp_path])
    study = load_recordings([inner]).first.protocol["study"]["name"]
    lines = sorted(line.split(": ", 1)[1] for line in caught.value.message.splitlines()[1:])
    assert lines == [
        f'1 session of "{study}" in {inner}: session_09.mcap',
        f'4 sessions of "{study}" in {tmp_path}: synthetic_P0.mcap, synthetic_P1.mcap and 2 more',
    ]
    (pattern,) = [word for word in caught.value.hint.split() if "*" in word]
    assert study == "synthetic"
    assert pattern == f"{tmp_path}/synthetic_*.mcap;"
    found = load_recordings(sorted(tmp_path.glob("synthetic_*.mcap")))
    assert len(found.sessions) == 4


def test_the_complete_session_of_a_participant_is_chosen(tmp_path: Path) -> None:
    """Of two sessions of one participant the complete one is analysed, the other is named."""
    write_session(tmp_path, small("A", 0, stop_after=5))
    write_session(tmp_path, small("A", 1))
    chosen = load_recordings([tmp_path])
    assert [session.file for session in chosen.sessions] == ["session_01.mcap"]
    assert [item.file for item in chosen.set_aside] == ["session_00.mcap"]


def test_order_of_arguments_does_not_matter(study_folder: Path) -> None:
    """Files given one by one, backwards, are the same study as their folder."""
    forwards = load_recordings([study_folder])
    backwards = load_recordings(sorted(study_folder.glob("*.mcap"), reverse=True))
    assert [s.file for s in forwards.sessions] == [s.file for s in backwards.sessions]


def test_nothing_to_read_is_one_clear_error(tmp_path: Path) -> None:
    """An empty folder, a missing one, and a folder of junk each get a message."""
    with pytest.raises(StudyError, match="no recording"):
        load_recordings([tmp_path])
    with pytest.raises(StudyError, match="no such file"):
        load_recordings([tmp_path / "absent"])
    (tmp_path / "junk.mcap").write_bytes(b"junk")
    with pytest.raises(StudyError, match="none of the recordings"):
        load_recordings([tmp_path])


def test_declared_exclusions_are_applied(study_folder: Path, tmp_path: Path) -> None:
    """A participant below a rule's threshold is left out, with counts in the reason."""
    for name in ("session_00.mcap", "session_01.mcap"):
        shutil.copy(study_folder / name, tmp_path)
    write_session(tmp_path, small("P09", 8, trials=3, timesteps=12, stop_after=7, planned=8))
    study = load_recordings([tmp_path])
    data = analysed_data(study, StudyTables(study), protocol_facts(study))
    assert [item.participant for item in data.excluded] == ["P09"]
    assert "1 complete trials, at least 2 required" in data.excluded[0].reason
    assert set(data.trials["participant"]) == {"P01", "P02"}


def test_analysis_needs_neither_window_nor_networks() -> None:
    """Importing the whole analysis loads neither pygame nor torch, task nor session."""
    code = (
        "import sys, analysis.report, analysis.commands.main\n"
        "names = ('pygame', 'torch', 'study.tasks', 'study.session', 'study.protocol')\n"
        "sys.exit(', '.join(n for n in names if n in sys.modules) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_unfinished_files_of_a_folder_are_read_unless_they_are_written(tmp_path: Path) -> None:
    """A crashed participant is not forgotten; a session under way is named, and left alone."""
    crashed = write_session(tmp_path, small("A", 0, trials=4, timesteps=60))
    tear(crashed)
    crashed.rename(crashed.with_name(f"{crashed.name}.part"))
    running = Recorder.start(tmp_path, "session_09", {}, {"session_id": "s9"})
    try:
        found = load_recordings([tmp_path])
    finally:
        running.close()
    (session,) = found.sessions
    assert session.opened.participant == "A"
    assert not session.complete
    assert [(item.file, item.reason) for item in found.set_aside] == [
        ("session_09.mcap.part", "it is still being written")
    ]


def test_people_and_simulated_participants_are_pooled_only_on_request(
    study: StudyRecordings,
) -> None:
    """A test over both would say nothing of either."""
    simulated, other = study.sessions[:2]
    person = dataclasses.replace(
        other, opened=dataclasses.replace(other.opened, operator_kind="person")
    )
    with pytest.raises(StudyError, match="persons and simulated participants"):
        choose_sessions([simulated, person])
    assert len(choose_sessions([simulated, person], pool=True).sessions) == 2


def test_a_copy_is_called_a_copy(tmp_path: Path) -> None:
    """Of the same session, in another folder; a second session of the participant is none."""
    path = write_session(tmp_path, small("A", 0))
    (tmp_path / "backup").mkdir()
    shutil.copy(path, tmp_path / "backup")
    (left_out,) = load_recordings([tmp_path]).set_aside
    assert left_out.reason == f"a copy of the session that is analysed, {path.name}"
    assert not left_out.unreadable
