"""Sessions at real speed in real windows, through which real keys press their way.

Each is `study run` in a window on its own virtual X server (Xvfb). Keys are pressed by XTEST; where
the session is, whoever presses them learns as an experimenter would, from the link of
`study console`.
"""

from __future__ import annotations

import contextlib
import dataclasses
import random
import socket
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "support")]

from benchmarks.memory_series import MemorySeries  # noqa: E402
from real_study import real_study  # noqa: E402
from study.console.finding import find_sessions  # noqa: E402
from study.console.wire import Ended, Status, parse_said  # noqa: E402
from study.events.events import TrialStarted  # noqa: E402
from study.events.shell import TrialTiming  # noqa: E402
from study.recording.parts import read_session  # noqa: E402
from x11_driver import Hands  # noqa: E402

LONGEST_START_S = 120.0
PHASE_FOUR = 4


@dataclasses.dataclass
class Played:
    """A session of which the keys were pressed.

    Attributes:
        participant: whose.
        folder: of its recording and log.
        memory: of its processes, second by second.
        states: how many the link told.
        unsaved_s: the oldest that a record not on disk was said to be.
        ended: how it ended; None if it did not.
        cause: what went wrong while pressing keys; None if nothing did.
    """

    participant: str
    folder: Path
    memory: MemorySeries = dataclasses.field(default_factory=MemorySeries)
    states: int = 0
    unsaved_s: float = 0.0
    ended: Ended | None = None
    cause: BaseException | None = None


class Player:
    """Presses the keys of one session."""

    def __init__(self, hands: Hands, found: Played, seed: int) -> None:
        self._hands = hands
        self._found = found
        self._random = random.Random(seed)  # noqa: S311 - nothing secret
        self._status: Status | None = None

    def play(self, path: Path) -> None:
        """Go through to the end."""
        with socket.socket(socket.AF_UNIX) as link:
            link.connect(str(path))
            link.setblocking(False)  # noqa: FBT003
            come = b""
            while self._found.ended is None:
                with contextlib.suppress(BlockingIOError):
                    data = link.recv(1 << 18)
                    if not data:
                        return
                    come += data
                *lines, come = come.split(b"\n")
                for line in lines:
                    self._hear(parse_said(line))
                if self._status is not None:
                    self._act(self._status)

    def _hear(self, said: object) -> None:
        if isinstance(said, Ended):
            self._found.ended = said
        elif isinstance(said, Status):
            self._found.states += 1
            self._found.unsaved_s = max(self._found.unsaved_s, said.disk.unsaved_s)
            self._status = said
            self._found.memory.place = f"phase {said.place.phase}"

    def _act(self, status: Status) -> None:
        hands, chance, place = self._hands, self._random, status.place
        if status.state == "paused":
            hands.focus_whatever_is_there()
            hands.tap("return")
            time.sleep(0.3)
        elif status.trial is not None and place.phase < PHASE_FOUR:
            if place.phase in (2, 3) and chance.random() < 0.3:
                hands.tap(chance.choice(["1", "2", "3", "4", "tab"]))
            keys = ["up", "up", "up", "left", "right", "down"]
            hands.tap(chance.choice(keys), hold_s=chance.choice([0.02, 0.15, 0.3]))
        elif place.kind == "survey":
            for key in (chance.choice("1234567"), chance.choice("1234567"), "return"):
                hands.tap(key)
            time.sleep(0.3)
        elif place.name == "thanks":
            hands.key("return", down=True)
            time.sleep(0.5)
        elif place.kind in ("pages", "trial", "reveal") and place.phase < PHASE_FOUR:
            hands.focus_whatever_is_there()
            hands.tap("return")
            time.sleep(0.3)
        else:
            time.sleep(0.1)


def run_one(
    protocol: Path,
    found: Played,
    seed: int,
    program: Sequence[str] = ("-m", "study.commands.main"),
    display_size: tuple[int, int] = (1280, 960),
) -> None:
    """Run one session from welcome to thanks.

    Args:
        protocol: its file.
        found: which session; what it came to is noted here.
        seed: of the keys.
        program: what Python is given to be the study's program.
        display_size: of the virtual screen, pixels.
    """
    found.folder.mkdir(parents=True)
    stop = threading.Event()
    with (found.folder / "said").open("wb") as said, real_study(
        str(protocol), found.folder, display_size=display_size, program=program,
        participant=found.participant, said=said,
    ) as (hands, study):  # fmt: skip
        watch = threading.Thread(target=found.memory.follow, args=(study.pid, stop))
        watch.start()
        try:
            hands.wait_for_window()
            Player(hands, found, seed).play(socket_of(found.participant))
            study.wait(60)
        except BaseException as error:
            found.cause = error
        finally:
            stop.set()
            watch.join()


def socket_of(participant: str) -> Path:
    """Wait until a participant's session can be found; return its socket."""
    until = time.monotonic() + LONGEST_START_S
    while time.monotonic() < until:
        for each in find_sessions():
            if each.status and each.status.facts.participant == participant:
                return each.path
        time.sleep(0.2)
    raise TimeoutError(f"no session of {participant}")


def fleet_runs(path: Path) -> dict[int, list[TrialTiming]]:
    """Return how punctual the fleet runs of a recording were, by how many robots were shown."""
    recording = read_session(path)
    begun = [record for _, record in recording.records(TrialStarted.topic)]
    robots = {r.trial_id: r.robots for r in begun if isinstance(r, TrialStarted)}
    found: dict[int, list[TrialTiming]] = {}
    for _, record in recording.records(TrialTiming.topic):
        if isinstance(record, TrialTiming) and record.frames:
            found.setdefault(robots[record.trial_id], []).append(record)
    return found


def print_timing(timings: Sequence[TrialTiming]) -> None:
    """Print how punctual pictures and timesteps of fleet runs were."""
    frames = sum(t.frames for t in timings)
    late = sum(t.late_frames for t in timings)
    worst = max(t.frame_max for t in timings)
    p99 = max(t.frame_p99 for t in timings)
    print(f"  {len(timings)} fleet runs, {frames:,} pictures: {late:,} late ({late / frames:.2%}), "
          f"worst p99 {1e3 * p99:.1f} ms, longest {1e3 * worst:.1f} ms")  # fmt: skip
    steps = [t for t in timings if t.timesteps]
    if steps:
        count = sum(t.timesteps for t in steps)
        longest = max(t.timestep_max for t in steps)
        gap = max(t.poll_gap_max for t in steps)
        print(f"  {count:,} intervals between timesteps, longest {1e3 * longest:.1f} ms; "
              f"longest between two looks at the keys {1e3 * gap:.1f} ms")  # fmt: skip
