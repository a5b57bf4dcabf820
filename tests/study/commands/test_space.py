"""A session on a disk that is nearly full begins, and not without a word."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import NamedTuple

import pytest
from typer.testing import CliRunner

from protocols import jetbots
from study.commands import enrolling, main, rehearsing, space
from study.errors import StudyError
from study.loading import load_protocol
from study.shell.preflight import machine

MEBIBYTE = 1 << 20


class Usage(NamedTuple):
    """What `shutil.disk_usage` tells."""

    total: int
    used: int
    free: int


def nearly_full(monkeypatch: pytest.MonkeyPatch, free: int) -> None:
    """Have a disk with so many bytes left."""
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(free, 0, free))


def test_a_disk_that_is_nearly_full_is_told_before_anybody_has_a_slot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line, with what there is and what a preflight would want; nothing is refused."""
    nearly_full(monkeypatch, 2 * MEBIBYTE)

    def reached(*_: object, **__: object) -> None:
        raise StudyError("nobody was refused")

    monkeypatch.setattr(enrolling, "assign", reached)
    monkeypatch.setenv("PYGAME_HIDE_SUPPORT_PROMPT", "1")
    folder = tmp_path / "recordings"
    done = CliRunner().invoke(main.app, ["run", "smoke", "-o", str(folder)])
    assert str(done.exception) == "nobody was refused"
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"The disk is nearly full: 2 MiB free in {folder}; wanted: 3 times")
    # In the very words of the preflight.
    assert machine.disk_space(folder, MEBIBYTE).advice in line
    assert not folder.exists()


@pytest.mark.parametrize("free", [100 * MEBIBYTE, space.PLENTY_BYTES], ids=["enough", "plenty"])
def test_a_disk_with_room_is_not_spoken_of(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    free: int,
) -> None:
    """Where there is plenty no session is rehearsed either: the participant waits for nothing."""
    nearly_full(monkeypatch, free)
    if free >= space.PLENTY_BYTES:
        monkeypatch.setattr(rehearsing, "rehearse", None)
    space.tell_space(load_protocol("smoke"), tmp_path, {})
    assert "nearly full" not in capsys.readouterr().err


def test_real_robots_are_not_driven_to_measure_what_a_session_writes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is said that the disk is nearly full, and where the need can be measured."""
    nearly_full(monkeypatch, 2 * MEBIBYTE)
    released: list[bool] = []

    class Button:
        def close(self) -> None:
            released.append(True)

    monkeypatch.setattr(space, "open_emergency", lambda *_: Button())
    monkeypatch.setattr(rehearsing, "rehearse", None)
    space.tell_space(load_protocol(str(jetbots(tmp_path, None))), tmp_path, {})
    assert "2 MiB free" in (said := capsys.readouterr().err)
    assert "study preflight" in said
    assert released
