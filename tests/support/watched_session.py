"""A session that consoles can watch, without a window: its link is fed by hand."""

from __future__ import annotations

import dataclasses
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from study.console import places
from study.console.link import ConsoleLink
from study.console.tracker import Tracker
from study.console.wire import Command, Disk, Facts
from study.events.events import (
    Deviation,
    FitApplied,
    FitRequested,
    Paused,
    Resumed,
    SessionEnded,
    SessionStarted,
    StageEntered,
    TrialStarted,
)
from study.events.experimenter_records import ExperimenterCommanded, ExperimenterNoted
from study.events.fields import Record
from study.events.fit_events import FitGateJudged
from study.events.shell import DisplayOpened, FrameIntervals

SECOND = 1_000_000_000
PASS_S = 0.01


def made_up_records() -> list[Record]:
    """Return what a session in phase three has recorded."""
    metrics = {
        "held_out_log_likelihood_per_choice": -0.9,
        "held_out_chance_log_likelihood": -1.386,
        "held_out_top1": 0.61,
        "held_out_chance_top1": 0.25,
    }
    values = np.array(list(metrics.values()))
    late = np.full(600, 1 / 60)
    late[7] = 0.034
    return [
        DisplayOpened(0, "x11", 1280, 960, 60.0, fullscreen=False),
        SessionStarted(0, "P07", ("manual", "assisted"), 40),
        FitRequested(50 * SECOND, 1, "policy:phase_one", "policy", "nearest_neighbor", 400, "ab"),
        FitApplied(51 * SECOND, 1, "policy:phase_one", "policy", "ab", (), np.empty(0),
                   np.empty(0)),
        FitRequested(60 * SECOND, 2, "scorer:luce", "scorer", "luce", 900, "cd"),
        FitApplied(62 * SECOND, 2, "scorer:luce", "scorer", "cd", tuple(metrics), values,
                   np.empty(0)),
        FitGateJudged(62 * SECOND, 2, "scorer:luce", 1, 2, True, "use", "", 0.486, 0.36, 0.05,
                      0.1, 0.05, 0.2, ""),
        Deviation(70 * SECOND, "practice_repeated", "practice was repeated", -1),
        ExperimenterNoted(71 * SECOND, "asked which key selects a robot", -1, 3),
        StageEntered(80 * SECOND, 21, "trial", "trial", 3, 1, "manual"),
        TrialStarted(81 * SECOND, 9, 3, 1, "manual", 2, 12, 400, "manual", "tiles", 0,
                     "policy:phase_one", "scorer:luce", True, np.zeros((12, 4), np.float32)),
        FrameIntervals(89 * SECOND, 9, late),
    ]  # fmt: skip


class WatchedSession:
    """Runs a link as the loop of a session does, in a thread, and obeys its commands.

    Args:
        path: of the socket.

    Attributes:
        link: the session's end.
        obeyed: the commands, in order.
        unsaved_s: what the recording is said to lack.
        longest_pass_s: the longest that the link kept the loop.
        silent: while set, the loop stands still.
    """

    def __init__(self, path: Path, *, participant: str = "P07") -> None:
        facts = Facts(
            session_id=path.stem,
            participant=participant,
            study="two_conditions",
            order=("manual", "assisted"),
            started_utc="2026-01-01T09:00:00+00:00",
            file="two_conditions_P07.mcap",
            pid=1,
        )
        self._tracker = Tracker(facts)
        self._began_ns = time.perf_counter_ns() - 90 * SECOND
        self._stop = threading.Event()
        self.unsaved_s = 0.2
        self.obeyed: list[Command] = []
        self.longest_pass_s = 0.0
        self.silent = threading.Event()
        for record in made_up_records():
            self._tracker.offer(record, 0, 0)
        self.link = ConsoleLink(path, self._tracker, self._disk)
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def participant_pauses(self) -> None:
        """Let the participant pause."""
        self._tracker.offer(Paused(89 * SECOND, "participant"), 0, 0)

    def _disk(self) -> Disk:
        return Disk(sent=5210, durable=5204, unsaved_s=self.unsaved_s, working=True, part=1)

    def now(self) -> int:
        """Return the session's time, ns."""
        return time.perf_counter_ns() - self._began_ns

    def _run(self) -> None:
        while not self._stop.wait(PASS_S):
            if self.silent.is_set():
                continue
            began = time.thread_time()
            for command in self.link.poll():
                self._obey(command)
            self.link.tell(self.now())
            self.longest_pass_s = max(self.longest_pass_s, time.thread_time() - began)

    def _obey(self, command: Command) -> None:
        now = self.now()
        self.obeyed.append(command)
        made: list[Record] = [ExperimenterCommanded(now, command.command, command.text)]
        if command.command == "pause":
            made.append(Paused(now, "experimenter"))
        elif command.command == "resume":
            made.append(Resumed(now, SECOND))
        elif command.command == "annotate":
            made.append(ExperimenterNoted(now, command.text, 9, 21))
        else:
            made.append(SessionEnded(now, False, f"ended by the experimenter: {command.text}"))
            self._stop.set()
        for record in made:
            self._tracker.offer(record, 0, 0)

    def close(self) -> None:
        """End the loop and hang up."""
        self._stop.set()
        self._thread.join()
        self.link.close()


@dataclasses.dataclass(frozen=True)
class Room:
    """A private folder in which sessions have their sockets."""

    folder: Path

    @contextmanager
    def session(
        self, session_id: str = "abc0", participant: str = "P07"
    ) -> Iterator[WatchedSession]:
        """Run a session that can be found."""
        session = WatchedSession(places.socket_path(session_id), participant=participant)
        try:
            yield session
        finally:
            session.close()


@contextmanager
def room(monkeypatch: pytest.MonkeyPatch) -> Iterator[Room]:
    """Make a short folder the only place in which sessions are looked for."""
    with tempfile.TemporaryDirectory(prefix="sa") as folder:
        place = Path(folder) / "c"
        monkeypatch.setattr(places, "candidates", lambda: [place])
        yield Room(place)
