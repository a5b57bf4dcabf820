"""A real window that is resized and minimised: the session pauses, and the recording says why."""

from __future__ import annotations

import time
from pathlib import Path

from onlooker import Aim, Onlooker
from patience import until
from protocols import variant
from real_study import close_last_words, real_study
from study.events.events import Paused, Resumed, Timestep
from study.events.inputs import WindowChanged
from study.recording.reader import Recording, read_recording
from study.screens import FleetScreen, PauseScreen
from study.verification import verify

WIDE = (1440, 900)


def timesteps_between(recording: Recording) -> list[int]:
    """Return how many timesteps there were before, between and after pauses and their ends."""
    counts = [0]
    for _, event in recording.records("event/paused", "event/resumed", "event/timestep"):
        if isinstance(event, Timestep):
            counts[-1] += 1
        else:
            counts.append(0)
    return counts


def test_resizing_and_minimising_pause_a_trial(tmp_path: Path) -> None:
    """Robots stand still until the participant goes on, by a click in the new size or by a key."""
    protocol = variant(tmp_path, ("[practice]\ntimesteps = 10", "[practice]\ntimesteps = 9000"))
    folder = tmp_path / "recordings"
    arguments = (str(protocol), folder, "--size", "1280x720")
    with real_study(*arguments, display_size=WIDE) as (hands, study):
        onlooker = Onlooker(folder)
        hands.wait_for_window()
        # Pages are left one by one, and the practice is started.
        while not isinstance(onlooker.look(), FleetScreen):
            hands.tap("return")
            time.sleep(0.2)
        drive(onlooker)
        hands.resize(*WIDE)
        paused = until_paused(onlooker)
        time.sleep(0.5)
        hands.click(*Aim(WIDE).at(paused, "continue"))
        drive(onlooker)
        window = hands.minimise()
        until_paused(onlooker)
        hands.restore(window)
        time.sleep(0.5)
        assert isinstance(onlooker.look(), PauseScreen)
        hands.tap("return")
        drive(onlooker)
        for key in ("escape", "q", "y"):
            hands.tap(key)
        assert close_last_words(hands, study) == 3
    (path,) = folder.glob("*.mcap")
    check(path)


def until_paused(onlooker: Onlooker) -> PauseScreen:
    """Wait until the session stands still; return what is shown."""
    until(lambda: isinstance(onlooker.look(), PauseScreen))
    screen = onlooker.look()
    assert isinstance(screen, PauseScreen)
    return screen


def drive(onlooker: Onlooker) -> None:
    """Let the robots run for some timesteps, whatever was seen before."""
    before = sum(isinstance(event, Timestep) for event in onlooker.events)

    def driven() -> bool:
        onlooker.look()
        return sum(isinstance(event, Timestep) for event in onlooker.events) > before + 3

    until(driven)


def check(path: Path) -> None:
    """Check the changes of the window, the pauses with their reasons, and the replay."""
    recording = read_recording(path)
    changes = [
        (record.change, record.width, record.height)
        for _, record in recording.records("input/window_changed")
        if isinstance(record, WindowChanged)
    ]
    assert changes == [("resized", *WIDE), ("minimised", *WIDE), ("restored", *WIDE)]
    pauses = [event for _, event in recording.records("event/paused") if isinstance(event, Paused)]
    assert [pause.reason for pause in pauses] == ["window resized", "window minimised", "operator"]
    resumed = [e for _, e in recording.records("event/resumed") if isinstance(e, Resumed)]
    assert all(event.paused_ns > 0.4e9 for event in resumed)
    counts = timesteps_between(recording)
    assert len(counts) == 6
    before, resizing, between, minimising, after, leaving = counts
    assert min(before, between, after) > 3
    # One step may be under way when a pause begins.
    assert max(resizing, minimising, leaving) <= 1
    verdict = verify(path)
    assert verdict.matches, verdict.difference
