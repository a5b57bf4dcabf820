"""What the analysis makes of a recording with records missing in the middle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from analysis.recordings import Session, load_recordings, timestep_blocks
from analysis.results import compute_results
from analysis.sections.quality import flags
from analysis.tables.study_tables import StudyTables
from study.recording.reader import read_recording
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
