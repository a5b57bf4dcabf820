"""A file that cannot be written is one message, and nothing half of it stays in the way."""

from __future__ import annotations

from pathlib import Path
from typing import NoReturn

import pytest

from study.commands.picturing import Look, draw_gallery
from study.commands.simulate import simulate_with_progress
from study.errors import StudyError
from study.loading import load_protocol
from study.messages import SOURCE, messages_for
from study.recording.durable_file import DurableFile
from study.recording.salvage import salvage
from synthetic_study import Plan, write_session

FULL = OSError(28, "No space left on device")


def fail(*_: object, **__: object) -> int:
    """Be a full disk."""
    raise FULL


def test_a_gallery_on_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of 0 bytes are no pictures."""
    monkeypatch.setattr(Path, "write_bytes", fail)
    look = Look((640, 480), 1.0, messages_for(SOURCE))
    with pytest.raises(StudyError, match="cannot be written: No space left"):
        draw_gallery(load_protocol("smoke"), tmp_path, [look])
    assert not list(tmp_path.rglob("*.png"))


def test_a_salvaged_file_on_a_full_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The next try finds nothing in its way."""
    path = write_session(tmp_path, Plan("P01", 0, trials=1, timesteps=5, phase_four=False))
    with monkeypatch.context() as patched:
        patched.setattr(DurableFile, "write", fail)
        with pytest.raises(StudyError, match="No space left"):
            salvage(path, tmp_path / "new.mcap")
    assert not list(tmp_path.glob("new*"))
    assert salvage(path, tmp_path / "new.mcap").nothing_lost


def test_failed_fits_of_simulations_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In how many sessions, and why; no recording is opened once more for it."""

    def failing(*_: object) -> NoReturn:
        raise ValueError("my bug")

    def opened(*_: object) -> NoReturn:
        pytest.fail("a recording was opened")

    monkeypatch.setattr("study.scorers.luce.fit", failing)
    monkeypatch.setattr("study.recording.reader.Recording.__init__", opened)
    made = simulate_with_progress("smoke", 2, 1, tmp_path, jobs=1)
    assert len(made) == 2
    assert "in 2 of 2 sessions: fit_failed: scorer:luce: " in capsys.readouterr().err
