"""The console's screens, by Textual's pilot, against a session's real link."""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Awaitable, Callable

import pytest

from patience import PATIENCE_S

pytest.importorskip("textual", reason="the extra console is not installed")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="consoles need Unix sockets")

from textual.pilot import Pilot  # noqa: E402
from textual.widgets import OptionList, Static  # noqa: E402

from study.console.app import ConsoleApp  # noqa: E402
from study.console.dialogs import AskText  # noqa: E402
from study.console.watching import WatchScreen  # noqa: E402
from watched_session import WatchedSession, room  # noqa: E402

Act = Callable[[ConsoleApp, Pilot[None]], Awaitable[None]]


def use(app: ConsoleApp, act: Act, size: tuple[int, int] = (110, 34)) -> None:
    """Run the console without a terminal and act on it."""

    async def run() -> None:
        async with app.run_test(size=size) as pilot:
            await act(app, pilot)

    asyncio.run(run())


async def until(pilot: Pilot[None], reached: Callable[[], bool]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not reached():
        assert time.monotonic() < deadline
        await pilot.pause(0.05)


def seen(app: ConsoleApp, panel: str) -> str:
    return str(app.screen.query_one(f"#{panel}", Static).visual)


def watching(app: ConsoleApp) -> bool:
    return isinstance(app.screen, WatchScreen) and app.screen.status is not None


def test_without_a_session_it_says_so_and_opens_the_one_that_comes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The list looks again by itself; the only session is opened at once."""
    with room(monkeypatch) as place:

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: "No session runs" in seen(app, "none"))
            assert "study run" in seen(app, "none")
            with place.session():
                await until(pilot, lambda: watching(app))

        use(ConsoleApp(), act)


def test_several_sessions_are_a_list(monkeypatch: pytest.MonkeyPatch) -> None:
    """Enter opens one, L leads back; --participant chooses by itself."""
    with room(monkeypatch) as place, place.session("a1", "P01"), place.session("b2", "P02"):

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: app.query_one(OptionList).option_count == 2)
            await until(pilot, lambda: isinstance(app.focused, OptionList))
            await pilot.press("enter")
            await until(pilot, lambda: watching(app))
            await pilot.press("l")
            await until(pilot, lambda: not isinstance(app.screen, WatchScreen))
            assert app.query_one(OptionList).option_count == 2

        use(ConsoleApp(), act)

        async def chosen(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: watching(app))
            assert "P02" in seen(app, "headline")

        use(ConsoleApp("P02"), chosen)


def test_everything_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each panel says what the session told; nothing is clipped in 110 columns."""
    with room(monkeypatch) as place, place.session():

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: watching(app) and "RUNNING" in seen(app, "headline"))
            for panel, words in {
                "headline": ("P07", "two_conditions", "manual then assisted", "1:3"),
                "now": ("Stage 22 of 40", "Phase 3, block 1, condition manual", "Trial 2",
                        "12 robots", "Timestep 0 of 400"),
                "recording": ("All but the last 0.2 s is on disk", "5,204 of 5,210"),
                "timing": ("1 of 600 pictures late", "34.0 ms", "0 timesteps skipped"),
                "fits": ("scorer luce", "gate passed", "+0.486", "top-1 0.61, chance 0.25"),
                "deviations": ("practice repeated",),
                "notes": ("1:11", "asked which key selects a robot"),
            }.items():  # fmt: skip
                for word in words:
                    assert word in seen(app, panel), (panel, seen(app, panel))

        use(ConsoleApp(), act)


def test_pause_resume_note_and_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keys become commands; what they came to is seen; a dialog called off sends nothing."""
    with room(monkeypatch) as place, place.session() as session:

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: watching(app))
            await pilot.press("p")
            await until(pilot, lambda: "PAUSED BY THE EXPERIMENTER" in seen(app, "headline"))
            await until(pilot, lambda: seen(app, "said") == "The session is paused.")
            await pilot.press("r")
            await until(pilot, lambda: "RUNNING" in seen(app, "headline"))
            await pilot.press("n")
            await until(pilot, lambda: isinstance(app.screen, AskText))
            await pilot.press(*"[b]ok", "enter")
            await until(pilot, lambda: watching(app) and "[b]ok" in seen(app, "notes"))
            await pilot.press("e")
            await until(pilot, lambda: isinstance(app.screen, AskText))
            await pilot.press("enter")
            assert isinstance(app.screen, AskText), "no reason, no end"
            await until(pilot, lambda: "Write some words first" in seen(app, "keys"))
            await pilot.press("escape")
            await until(pilot, lambda: watching(app))
            await pilot.press("e")
            await until(pilot, lambda: isinstance(app.screen, AskText))
            await pilot.press(*"fire", "enter")
            await until(pilot, lambda: len(session.obeyed) == 4)

        use(ConsoleApp(), act)
        assert [(each.command, each.text) for each in session.obeyed] == [
            ("pause", ""), ("resume", ""), ("annotate", "[b]ok"), ("end", "fire"),
        ]  # fmt: skip


def test_a_pause_of_the_participants_is_theirs_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """To go on is offered in the experimenter's own pause alone."""
    with room(monkeypatch) as place, place.session() as session:

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: watching(app))
            session.participant_pauses()
            await until(pilot, lambda: "PAUSED" in seen(app, "headline"))
            assert app.screen.check_action("resume", ()) is False
            await pilot.press("p")
            await until(pilot, lambda: "BY THE EXPERIMENTER" in seen(app, "headline"))
            assert app.screen.check_action("resume", ()) is True

        use(ConsoleApp(), act)


def test_old_records_and_silence_are_alarming(monkeypatch: pytest.MonkeyPatch) -> None:
    """A record unsaved for over a second, then no word at all: both are said, in red."""
    with room(monkeypatch) as place, place.session() as session:

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: watching(app) and "is on disk" in seen(app, "recording"))
            assert "NOTHING REACHED" not in seen(app, "recording")
            session.unsaved_s = 1.3
            alarm = "NOTHING REACHED THE DISK FOR 1.3 s"
            await until(pilot, lambda: alarm in seen(app, "recording"))
            session.silent.set()
            await until(pilot, lambda: "NO WORD FROM THE SESSION" in seen(app, "headline"))
            session.silent.clear()
            await until(pilot, lambda: "RUNNING" in seen(app, "headline"))

        use(ConsoleApp(), act)


@pytest.mark.parametrize("how", ["ended", "gone"])
def test_the_end_is_told_from_a_crash(monkeypatch: pytest.MonkeyPatch, how: str) -> None:
    with room(monkeypatch) as place:

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            with place.session() as session:
                await until(pilot, lambda: watching(app))
                if how == "ended":
                    await pilot.press("e")
                    await until(pilot, lambda: isinstance(app.screen, AskText))
                    await pilot.press(*"fire", "enter")
                    await until(pilot, lambda: bool(session.obeyed))
            wanted = "The session is over" if how == "ended" else "is gone without having ended"
            await until(pilot, lambda: watching(app) and wanted in seen(app, "headline"))
            assert isinstance(app.screen, WatchScreen)
            # What was not on disk when it was last heard of is not said to be missing.
            closed = "The session has ended" in seen(app, "recording")
            assert closed == (how == "ended")
            # The one is said quietly, the other in red.
            assert app.screen.over == (how == "ended")
            await until(pilot, lambda: "p" not in app.screen.active_bindings)
            assert "l" in app.screen.active_bindings
            await pilot.press("p")
            await pilot.pause(0.2)
            assert wanted in seen(app, "headline")

        use(ConsoleApp(), act)


def obeyed(session: WatchedSession) -> list[str]:
    return [each.command for each in session.obeyed]


def test_a_small_terminal_is_enough(monkeypatch: pytest.MonkeyPatch) -> None:
    """80 by 24: state, recording and keys are there."""
    with room(monkeypatch) as place, place.session() as session:

        async def act(app: ConsoleApp, pilot: Pilot[None]) -> None:
            await until(pilot, lambda: watching(app))
            for panel in ("headline", "now", "recording", "timing", "deviations", "notes"):
                region = app.screen.query_one(f"#{panel}").region
                assert region.height > 0, panel
                assert region.y < 23, panel
            await pilot.press("p")
            await until(pilot, lambda: obeyed(session) == ["pause"])

        use(ConsoleApp(), act, (80, 24))
