"""What the analysis makes of a recording with records missing in the middle."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from analysis.commands import main as command
from analysis.recordings import Session, load_recordings, timestep_blocks
from analysis.results import compute_results
from analysis.sections.quality import flags
from analysis.sections.summary import tiles
from analysis.tables.study_tables import StudyTables
from cut_sessions import whole_session, write_part
from study.commands.recover import salvaged_path
from study.recording.parts import base_name
from study.recording.reader import read_recording
from study.recording.salvage import salvage
from study.verification import verify
from synthetic_study import Plan, write_session


@pytest.fixture(scope="module")
def damaged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A study of two, the first of whom has a damaged chunk in the middle."""
    folder = tmp_path_factory.mktemp("damaged")
    first = write_session(folder, Plan("P01", 0, planned=2, timesteps=60))
    write_session(folder, Plan("P02", 1, planned=2, timesteps=60))
    chunks = read_recording(first).chunks
    data = bytearray(first.read_bytes())
    # The first chunks hold the opened session, without which nothing can be analysed.
    place = chunks.start[-2] + 80
    data[place : place + 20] = b"\xff" * 20
    first.write_bytes(data)
    return folder


def session(folder: Path) -> Session:
    return load_recordings([folder]).sessions[0]


def test_fleet_runs_with_losses_are_incomplete(damaged: Path) -> None:
    """A fleet run that lost timesteps is incomplete; one whose beginning is lost is left out."""
    opened = session(damaged)
    assert opened.recording.losses
    assert opened.damaged_trials or opened.unknown_trials
    rows: dict[int, int] = {}
    for block in timestep_blocks(opened):
        for trial, count in zip(*np.unique(block["trial_id"], return_counts=True), strict=True):
            rows[int(trial)] = rows.get(int(trial), 0) + int(count)
    assert set(rows) <= set(opened.trials)
    for trial, end in opened.trial_ends.items():
        if end.complete:
            assert rows[trial] == end.timesteps
            assert trial not in opened.damaged_trials
    assert max(opened.trials) > max([*opened.damaged_trials, *opened.unknown_trials])


def test_the_report_lists_the_losses(damaged: Path) -> None:
    """The data-quality section names the damage, the gap and the fleet runs concerned."""
    study = load_recordings([damaged])
    found = flags(compute_results(study, StudyTables(study)))
    texts = [flag.text for flag in found if flag.session == "P01"]
    assert any("is damaged" in text for text in texts)
    assert any("are missing (" in text for text in texts)
    assert any(flag.kind == "Lost records" for flag in found)
    assert not any(flag.kind in ("File", "Lost records") for flag in found if flag.session == "P02")


@pytest.fixture(scope="module")
def in_parts(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """A whole session in two parts."""
    folder = tmp_path_factory.mktemp("parts")
    whole = whole_session(tmp_path_factory.mktemp("whole"))
    records = [raw for raw in read_recording(whole).raw() if raw.sequence]
    first = write_part(folder, records[: len(records) // 2])
    return first, write_part(folder, records[len(records) // 2 :], base_name(first), 2)


@pytest.mark.parametrize(("salvaged", "torn"), [(0, False), (1, False), (1, True)])
def test_a_salvaged_copy_of_a_part_is_no_problem(
    in_parts: tuple[Path, Path], tmp_path: Path, salvaged: int, *, torn: bool
) -> None:
    """Beside its original one of the two is analysed, the whole one; in its place it is."""
    paths = [Path(shutil.copy(path, tmp_path)) for path in in_parts]
    original = paths[salvaged]
    if torn:
        original.write_bytes(original.read_bytes()[:-40])
    copy = salvage(original, salvaged_path(original)).path
    for _ in range(2):
        found = load_recordings([tmp_path])
        assert found.unreadable == 0
        (session,) = found.sessions
        assert session.complete
        assert len(session.parts) == 2
        assert (copy in [part.path for part in session.parts]) == (torn or not original.exists())
        assert verify(paths[1 - salvaged]).matches
        if original.exists():
            (aside,) = found.set_aside
            assert aside.file == (original if torn else copy).name
            assert "Left out: " in str(aside)
            original.unlink()


@pytest.mark.parametrize("missing", [0, 5])
def test_a_part_whose_writer_was_killed_is_a_problem_only_where_records_are_missing(
    tmp_path: Path, missing: int
) -> None:
    """The part after it holds what was not on disk; a line says so, and nothing is counted."""
    whole = whole_session(tmp_path / "whole", pause_s=0.02)
    recording = read_recording(whole)
    records = [raw for raw in recording.raw() if raw.sequence]
    folder = tmp_path / "recordings"
    folder.mkdir()
    torn = folder / f"{whole.name}.part"
    torn.write_bytes(whole.read_bytes()[: int(recording.chunks.start[-2])])
    first = read_recording(torn).losses[0].first
    again = [raw for raw in records if raw.sequence >= (first + missing if missing else first - 9)]
    second = write_part(folder, again, base_name(whole), 2)
    assert verify(second).matches
    done = CliRunner().invoke(
        command.app, ["tables", str(folder), "-o", str(tmp_path / "tables")], env={"COLUMNS": "400"}
    )
    study = load_recordings([folder])
    results = compute_results(study, StudyTables(study))
    (faulty,) = (tile for tile in tiles(results) if tile.name == "files with problems")
    kinds = {flag.kind for flag in flags(results)}
    (row,) = StudyTables(study).frame("sessions").itertuples()
    remark = f"Part 1 was not closed; part 2 goes on from record {first}: nothing is missing."
    if missing:
        assert "Damaged: " in done.output
        assert "nothing is missing" not in done.output
        assert (faulty.value, "File" in kinds, row.file_complete) == ("1", True, False)
        lost = f"Records {first} to {first + missing - 1} are in none of the parts"
        assert lost in str(row.problems)
    else:
        assert "Damaged" not in done.output
        assert f"{torn.name}: {remark}" in done.output
        assert (faulty.value, "File" in kinds, row.file_complete) == ("0", False, True)
        assert row.problems == ""
