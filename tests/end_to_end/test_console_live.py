"""`study console` in a terminal beside `study run` in a window: real processes, real keys."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from analysis.export.reconcile import reconcile
from analysis.recordings import StudyRecordings, load_recordings
from analysis.tables import deviations, notes
from onlooker import Onlooker
from patience import PATIENCE_S, until
from protocols import ROOT, variant
from real_study import close_last_words, real_study
from study.enrolment.register import Register
from study.events.events import Deviation, Event, Paused, Resumed, SessionEnded, Timestep
from study.events.experimenter_records import ExperimenterCommanded, ExperimenterNoted
from study.recording.reader import read_recording
from study.screens import FleetScreen, PauseScreen
from study.verification import verify
from terminal import Terminal, in_terminal
from x11_driver import Hands

pytest.importorskip("textual", reason="the extra console is not installed")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="a private X server, Linux signals")

CONSOLE = (sys.executable, "-m", "study.commands.main", "console")
LONG_PRACTICE = ("[practice]\ntimesteps = 10", "[practice]\ntimesteps = 9000")


@pytest.fixture(autouse=True)
def _own_runtime_folder(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Sessions of this test alone are found; the path of a socket has to be short."""
    with tempfile.TemporaryDirectory(prefix="sa") as folder:
        monkeypatch.setenv("XDG_RUNTIME_DIR", folder)
        monkeypatch.setenv("TMPDIR", folder)
        monkeypatch.setenv("PYTHONPATH", str(ROOT))
        yield


def to_the_practice(hands: Hands, onlooker: Onlooker) -> None:
    """Leave the pages one by one, and start the practice."""
    hands.wait_for_window()
    while not isinstance(onlooker.look(), FleetScreen):
        hands.tap("return")
        time.sleep(0.2)


def count(onlooker: Onlooker, kind: type[Event]) -> int:
    onlooker.look()
    return sum(isinstance(event, kind) for event in onlooker.events)


def running(onlooker: Onlooker, hands: Hands) -> None:
    """Wait for some more timesteps; the participant goes on where the writer was kept waiting."""
    before = count(onlooker, Timestep)

    def reached() -> bool:
        screen = onlooker.look()
        if isinstance(screen, PauseScreen) and screen.can_go_on:
            hands.tap("return")
        return count(onlooker, Timestep) > before + 3

    until(reached)


def running_sessions() -> list[dict[str, Any]]:
    """Return what `study console --json` says."""
    done = subprocess.run([*CONSOLE, "--json"], capture_output=True, check=True, text=True)
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


def wait_running(console: Terminal, hands: Hands, *words: str) -> None:
    """Wait until a console shows a session that runs.

    On a machine whose other work keeps the writer from its own, the session may have paused for
    it; the participant then goes on.
    """

    def reached() -> bool:
        if all(word.encode() in console.drawn for word in ("RUNNING", *words)):
            return True
        if any(each["why"] == "recording interrupted" for each in running_sessions()):
            hands.tap("return")
        return False

    console.wait_until(reached)
    console.forget()


@contextmanager
def watched_study(
    protocol: str, folder: Path, *words: str
) -> Iterator[tuple[Hands, subprocess.Popen[bytes], Terminal]]:
    """Run a session in a window and a console beside it, which shows it, and these words."""
    with (
        real_study(protocol, folder) as (hands, study),
        in_terminal(*CONSOLE) as console,
    ):
        hands.wait_for_window()
        wait_running(console, hands, *words)
        yield hands, study, console


def held(onlooker: Onlooker) -> bool:
    screen = onlooker.look()
    return isinstance(screen, PauseScreen) and not screen.can_go_on


def test_an_experimenter_watches_pauses_and_annotates(tmp_path: Path) -> None:
    """The participant cannot end the pause; a console killed in a trial costs nothing."""
    protocol = str(variant(tmp_path, LONG_PRACTICE))
    folder = tmp_path / "recordings"
    with watched_study(protocol, folder, "P01", "is on disk") as (hands, study, console):
        onlooker = Onlooker(folder)
        to_the_practice(hands, onlooker)
        console.wait_for("Timestep")
        running(onlooker, hands)
        pause_and_go_on(console, hands, onlooker)
        console.type("n")
        console.wait_for("A note")
        console.type("coughs =1+1 <b>\r")
        until(lambda: count(onlooker, ExperimenterNoted) == 1)
        running(onlooker, hands)
        console.process.kill()
        running(onlooker, hands)
        # Another one, killed while it holds the session: the session waits for a third.
        with in_terminal(*CONSOLE) as second:
            wait_running(second, hands)
            second.type("p")
            until(lambda: held(onlooker))
        with in_terminal(*CONSOLE) as third:
            third.wait_for("PAUSED BY THE EXPERIMENTER", "coughs")
            third.type("r")
            running(onlooker, hands)
        for key in ("escape", "q", "y"):
            hands.tap(key)
        assert close_last_words(hands, study) == 3
    check(folder)


def pause_and_go_on(console: Terminal, hands: Hands, onlooker: Onlooker) -> None:
    console.type("p")
    console.wait_for("PAUSED BY THE EXPERIMENTER")
    until(lambda: held(onlooker))
    before = count(onlooker, Timestep)
    for key in ("return", "escape", "up"):
        hands.tap(key)
    time.sleep(0.5)
    assert held(onlooker)
    assert count(onlooker, Timestep) <= before + 1
    console.type("r")
    wait_running(console, hands)
    running(onlooker, hands)


def check(folder: Path) -> None:
    (path,) = folder.glob("*.mcap")
    recording = read_recording(path)
    assert recording.complete, recording.problems
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    kinds = ("input/experimenter_commanded", "event/paused", "event/resumed", "event/deviation",
             "event/experimenter_noted")  # fmt: skip
    records = [record for _, record in recording.records(*kinds)]
    asked = [r.command for r in records if isinstance(r, ExperimenterCommanded)]
    assert asked == ["pause", "resume", "annotate", "pause", "resume"]
    reasons = [r.reason for r in records if isinstance(r, Paused)]
    stalls = reasons.count("recording interrupted")
    assert [reason for reason in reasons if reason != "recording interrupted"] == [
        "experimenter", "experimenter", "operator",
    ]  # fmt: skip
    assert sum(isinstance(r, Resumed) for r in records) == 2 + stalls
    codes = [r.code for r in records if isinstance(r, Deviation)]
    assert [code for code in codes if code != "recording_interrupted"] == [
        "experimenter_paused",
        "experimenter_paused",
        "ended_early",
    ]
    (noted,) = [r for r in records if isinstance(r, ExperimenterNoted)]
    assert noted.text == "coughs =1+1 <b>"
    assert noted.trial_id == 0


def test_an_experimenter_ends_a_session(tmp_path: Path) -> None:
    """With the reason, which stands in recording and register; the console says that it is over."""
    folder = tmp_path / "recordings"
    with watched_study("smoke", folder, "P01") as (hands, study, console):
        console.type("e")
        console.wait_for("End the session of P01 now?")
        console.type("fire drill\r")
        console.wait_for("The session is over", "fire drill")
        assert close_last_words(hands, study) == 3
    (path,) = folder.glob("*.mcap")
    (ended,) = [r for _, r in read_recording(path).records(SessionEnded.topic)]
    assert isinstance(ended, SessionEnded)
    assert ended.reason == "ended by the experimenter: fire drill"
    with Register(folder) as register:
        known = register.find("smoke", "P01")
    assert known is not None
    assert (known.state, known.reason) == ("dropped", ended.reason)
    with real_study("smoke", folder, "--resume") as (hands, study):
        hands.wait_for_window()
        until(lambda: running_sessions() != [])
        study.terminate()
        study.wait(PATIENCE_S)
    # That it was ended, and why, is not lost because it went on.
    resumed = load_recordings([folder])
    every = deviations.build(resumed).frame
    # A busy disk may have interrupted the recording besides.
    rows = every[every["code"].isin(["ended_early", "resumed"])].reset_index()
    assert list(rows["code"]) == ["ended_early", "resumed", "ended_early"]
    assert list(rows["kept"]) == [False, True, True]
    assert "fire drill" in rows["text"][0]
    (count,) = [
        each for each in reconcile(resumed, numbers(len(every))) if each.table == "deviations"
    ]
    assert count.agrees


def numbers(of_deviations: int) -> dict[str, int]:
    """Return numbers of rows, of which only those of deviations are looked at."""
    return {"sessions": 0, "trials": 0, "timing": 0, "deviations": of_deviations}


def test_a_killed_session_is_told_from_one_that_ended(tmp_path: Path) -> None:
    """The console says what became of it; resumed, the session is told with all before it."""
    folder = tmp_path / "recordings"
    with watched_study("smoke", folder, "P01") as (hands, study, console):
        console.type("n")
        console.wait_for("A note")
        console.type("before the blow\r")
        console.wait_until(lambda: any(each["notes"] for each in running_sessions()))
        study.kill()
        console.wait_for("is gone without having ended")
        console.type("l")
        console.wait_for("No session runs")
        assert running_sessions() == []
    with real_study("smoke", folder, "--resume") as (hands, study):
        hands.wait_for_window()
        until(lambda: running_sessions() != [])
        (resumed,) = running_sessions()
        study.terminate()
        study.wait(PATIENCE_S)
    assert [note["text"] for note in resumed["notes"]] == ["before the blow"]
    assert resumed["place"]["name"] == "welcome"
    assert resumed["place"]["stages"] > 20
    assert resumed["disk"]["part"] == 2
    (session,) = load_recordings([folder]).sessions
    (note,) = notes.build(StudyRecordings((session,), ())).frame.to_dict("records")
    assert (note["text"], note["kept"]) == ("before the blow", False)
    assert list((Path(os.environ["XDG_RUNTIME_DIR"]) / "scaled-autonomy").iterdir()) == []


def test_a_session_without_a_place_for_its_socket_runs_all_the_same(tmp_path: Path) -> None:
    """It says that no console can watch it, and is recorded."""
    code = (
        "from study.console import places\n"
        "from pathlib import Path\n"
        "places.candidates = lambda: [Path('/proc/no')]\n"
        "from study.commands.main import main\n"
        "main()\n"
    )
    study = subprocess.Popen(
        [sys.executable, "-c", code, "run", "smoke", "-p", "P01", "-o", str(tmp_path)],
        cwd=ROOT,
        env={**os.environ, "SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy"},
        stderr=subprocess.PIPE,
        text=True,
    )
    until(lambda: bool(list(tmp_path.glob("*.mcap*"))) or study.poll() is not None)
    time.sleep(1.0)
    study.terminate()
    _, errors = study.communicate(timeout=PATIENCE_S)
    assert "cannot watch this session" in errors
    assert "Traceback" not in errors
    (path,) = tmp_path.glob("*.mcap")
    assert read_recording(path).complete
