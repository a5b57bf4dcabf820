"""What `study preflight` says in the terminal, before its window opens and after."""

from __future__ import annotations

import os
import re
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console

from study.commands import preflight, rehearsing
from study.commands.running import Seat
from study.commands.simulating import simulated_assignments
from study.loading import load_protocol
from study.preflight_result import Check, Preflight, keep_preflight
from study.shell.preflight import display


class WindowOpensError(Exception):
    """The window would open now."""


def found(advice: str) -> Preflight:
    """Return a preflight of one check."""
    check = Check(
        name="display",
        state="amber",
        found="1280x960 under x11, states 60 Hz; its real rate cannot be measured",
        wanted="at least 1280x720; pictures as often as the display states",
        advice=advice,
    )
    return Preflight(
        utc="2026-01-02T03:04:05+00:00", host="h", protocol="p", protocol_sha256="0",
        seconds=1.0, checks=(check,),
    )  # fmt: skip


@pytest.mark.parametrize("width", [60, 80, 120])
def test_nothing_is_cut_off_in_the_table(width: int) -> None:
    """The path that helps is there to its end, over lines if it must be."""
    path = "docs/how-to/check-a-seat.md"
    shown = StringIO()
    Console(file=shown, width=width).print(preflight._table(found(f"See: {path}.")))
    assert "\N{HORIZONTAL ELLIPSIS}" not in shown.getvalue()
    rows = [
        re.split("[\N{BOX DRAWINGS LIGHT VERTICAL}]", line)
        for line in shown.getvalue().splitlines()
    ]
    assert path in "".join(row[4].strip() for row in rows if len(row) > 4)


@pytest.mark.parametrize("asked", [True, False])
def test_keys_are_announced_before_the_window_opens(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    asked: bool,
) -> None:
    """In the terminal, with how long one has; nothing of it where no keys are asked for."""

    def opens(*_: object, **__: object) -> float:
        raise WindowOpensError

    loaded = load_protocol("smoke")
    (assignment,) = simulated_assignments(loaded, 1, seed=1)
    none = SimpleNamespace(checks=(), bytes=0)
    monkeypatch.setattr(rehearsing, "rehearse", lambda *_: none)
    monkeypatch.setattr(display, "refresh_rate", opens)
    with pytest.raises(WindowOpensError):
        list(preflight._checks(loaded, assignment, tmp_path, Seat(), with_keys=asked))
    said = "When it asks for up and left, hold both down at once: it waits 10 s."
    assert (said in capsys.readouterr().err) == asked


def test_a_full_disk_leaves_nothing_hidden(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The file that could not be written is gone; what was there before is as it was."""
    keep_preflight(tmp_path, found("x"))
    before = (tmp_path / "preflight.json").read_bytes()

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        keep_preflight(tmp_path, found("y"))
    assert [path.name for path in tmp_path.iterdir()] == ["preflight.json"]
    assert (tmp_path / "preflight.json").read_bytes() == before
