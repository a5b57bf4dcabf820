"""What a preflight says of disk, clocks, letters, keys and punctuality."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pygame
import pytest

import sample_screens as samples
from study.errors import StudyError
from study.preflight_result import FILE, Check, Preflight, as_json, read_preflight
from study.shell.preflight import display, keys, machine
from study.shell.window import Window


@pytest.fixture
def window() -> Iterator[Window]:
    """A window that nobody sees."""
    os.environ["SDL_VIDEODRIVER"] = "dummy"
    opened = Window((1280, 720))
    yield opened
    opened.close()


def _made(*states: str) -> Preflight:
    checks = tuple(
        Check.model_validate(
            {"name": f"c{i}", "state": state, "found": "found", "wanted": "wanted"}
        )
        for i, state in enumerate(states)
    )
    return Preflight(
        utc="2026-01-02T03:04:05+00:00", host="lab", protocol="a.toml", protocol_sha256="0" * 64,
        seconds=1.0, checks=checks,
    )  # fmt: skip


def test_the_worst_state_counts() -> None:
    """One red check makes the whole red, one amber check amber."""
    assert _made("green", "green").state == "green"
    assert _made("green", "amber").state == "amber"
    assert _made("amber", "red", "green").state == "red"
    assert _made("green", "red").sentence.endswith("1 of 2 green; c1 red: found")
    assert '"state": "red"' in as_json(_made("red"))


def test_a_result_is_read_back_and_anything_else_refused(tmp_path: Path) -> None:
    """No file is no preflight; a damaged or huge one is named."""
    assert read_preflight(tmp_path) is None
    made = _made("green", "red")
    (tmp_path / FILE).write_text(made.model_dump_json())
    assert read_preflight(tmp_path) == made
    for text in ("{}", "no json", " " * 200_000, made.model_dump_json().replace("2026-", "x")):
        (tmp_path / FILE).write_text(text)
        with pytest.raises(StudyError, match="no preflight's result"):
            read_preflight(tmp_path)


def test_space_is_asked_for_three_times(tmp_path: Path) -> None:
    """A session that would nearly fill the disk is red; the folder need not exist yet."""
    assert machine.disk_space(tmp_path / "a" / "b", 1000).state == "green"
    assert machine.disk_space(tmp_path, 1 << 60).state == "red"


def test_writing_is_timed_and_leaves_nothing(tmp_path: Path) -> None:
    """The folder is as it was; one that cannot be written to is red."""
    assert "19 of 20" in machine.write_latency(tmp_path).found
    assert list(tmp_path.iterdir()) == []
    assert machine.write_latency(Path("/proc")).state == "red"


def test_a_clock_that_jumps_is_red(monkeypatch: pytest.MonkeyPatch) -> None:
    """Wall time that goes on by another amount than monotonic time is noticed."""
    monkeypatch.setattr(machine, "CLOCK_S", 0.05)
    assert machine.Clocks().check().state != "red"
    real = time.time
    clocks = machine.Clocks()
    monkeypatch.setattr(time, "time", lambda: real() + 3.0)
    assert clocks.check().state == "red"


@pytest.mark.usefixtures("window")
def test_letters_that_the_fonts_lack_are_named() -> None:
    """What one of the fonts has is there; a letter that none has is shown."""
    assert display.letters(["Robot 7 is yours: größer", "Робот 7 ваш", "שלום"]).state == "green"
    found = display.letters(["ok \u0e01"])
    assert (found.state, "\u0e01" in found.found) == ("red", True)


def test_punctuality_is_measured_with_the_fleet(
    window: Window, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The study's own loop runs; what it says is a rate and a share."""
    monkeypatch.setattr(display, "TICK_S", 0.5)
    found = display.punctuality(window, samples.fleet(12, operated=0), 8.0)
    assert "with 12 robots" in found.found
    assert "late" in found.found


def test_a_small_or_wrong_display_is_red(window: Window) -> None:
    """A rate that differs from the stated one is red, one that cannot be measured amber."""
    rate = window.refresh_hz
    assert display.display(window, rate).state == "green"
    assert display.display(window, 0.0).state == "amber"
    assert display.display(window, rate * 0.8).state == "red"
    window.size = (1024, 600)
    assert display.display(window, rate).state == "red"


def _press(*events: tuple[int, int]) -> None:
    for kind, key in events:
        pygame.event.post(pygame.event.Event(kind, key=key, scancode=0))


@pytest.mark.parametrize(
    ("events", "state", "said"),
    [
        ([(pygame.KEYDOWN, pygame.K_UP), (pygame.KEYDOWN, pygame.K_LEFT)], "green", "together"),
        (
            [(pygame.KEYDOWN, pygame.K_UP), (pygame.KEYUP, pygame.K_UP),
             (pygame.KEYDOWN, pygame.K_LEFT)],
            "red", "never together",
        ),
        ([(pygame.KEYDOWN, pygame.K_UP)], "red", "only up"),
        ([], "red", "no key"),
    ],
)  # fmt: skip
def test_two_keys_must_be_held_at_once(
    window: Window, events: list[tuple[int, int]], state: str, said: str
) -> None:
    """Keys that come one after the other, alone, or not at all are told apart."""
    timer = threading.Timer(0.05, _press, events)
    timer.start()
    found = keys.keyboard(window, ("up", "left"), patience_s=0.6)
    timer.join()
    assert (found.state, said in found.found) == (state, True)
