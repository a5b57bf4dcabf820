"""How long a replay takes to go anywhere in half an hour, against replaying from the beginning.

python -m benchmarks.replay_seek [--quick]

A simulated participant goes through the paper's study, its trials of twelve robots lengthened so
that the session lasts half an hour; the recording has a chunk for each half second, as a session
with a person has. Then the replay goes to random times, each time the session is brought there
and the analyst's picture is painted. With --quick the session is short.
"""

from __future__ import annotations

import gc
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

import numpy as np
import pygame

from benchmarks.made_up_sessions import machine
from benchmarks.reading import peak_mib
from study.commands.simulating import simulate_study
from study.events.inputs import Input
from study.messages import messages_for
from study.recording.client import Recorder
from study.recording.parts import SessionRecording, read_whole_session
from study.recording.wire import decode, record_types_by_topic
from study.shell.replay.head import Head
from study.shell.replay.marks import Marks, read_marks
from study.shell.replay.picture import Picture, size_for
from study.shell.replay.strip import Shown
from study.shell.replay.tape import Tape

ROOT = Path(__file__).resolve().parents[1]
HALF_HOUR = ("trial_timesteps = 240", "trial_timesteps = 480")
CHUNK_NS = 500_000_000
SEEKS = 400
FROM_THE_BEGINNING = 5
WANTED_MS = 100.0


def recorded(folder: Path, *, quick: bool) -> SessionRecording:
    """Simulate a session and record it with the chunks of a person's."""
    name = "smoke" if quick else "scaled_autonomy"
    text = (ROOT / "protocols" / f"{name}.toml").read_text()
    protocol = folder / f"{name}.toml"
    protocol.write_text(text.replace(*HALF_HOUR))
    for part in (ROOT / "protocols").glob("questionnaires/*.toml"):
        (folder / "questionnaires").mkdir(exist_ok=True)
        (folder / "questionnaires" / part.name).write_text(part.read_text())
    (made,) = simulate_study(str(protocol), 1, 1, folder / "simulated", jobs=1)
    simulated = read_whole_session(made.path)
    recorder = Recorder.start(folder, "half_hour", simulated.attachments, simulated.metadata)
    due_ns = 0
    known = record_types_by_topic()
    for raw in simulated.raw():
        if raw.sequence and raw.topic in known:
            record = decode(raw.topic, raw.data)
            recorder.write(record, raw.log_time_ns)
            if record.t_ns >= due_ns:
                due_ns = record.t_ns + CHUNK_NS
                if not recorder.ensure_durable(30):
                    raise SystemExit("The disk did not answer within 30 s.")
    return read_whole_session(recorder.close())


def told(name: str, seconds: list[float]) -> float:
    """Print the spread of some times; return the longest, ms."""
    taken = np.array(seconds) * 1e3
    print(
        f"  {name:34s} median {np.median(taken):8.1f} ms   "
        f"99 % {np.percentile(taken, 99):8.1f} ms   max {taken.max():8.1f} ms"
    )
    return float(taken.max())


def timed(work: Callable[[], object]) -> float:
    """Return how long a piece of work takes, s."""
    begun = time.perf_counter()
    work()
    return time.perf_counter() - begun


def from_the_beginning(recording: SessionRecording, t_ns: int) -> Head:
    """Replay to a time without forks."""
    head = Head()
    for raw in recording.raw("input"):
        given: Input = decode(raw.topic, raw.data)  # type: ignore[assignment]
        if given.t_ns > t_ns:
            break
        head.feed(raw, given)
    return head


def measure(recording: SessionRecording, marks: Marks) -> None:
    """Measure and print."""
    opening = timed(lambda: Tape(read_whole_session(recording.path)))
    tape = Tape(recording)
    reading = timed(lambda: tape.read(1e9))
    print(f"  opened in {opening:.2f} s; read through in {reading:.1f} s; {tape.forks} forks kept")
    pygame.font.init()
    picture = Picture(size_for("analyst", marks), marks, "analyst", messages_for("en"))
    surface = pygame.Surface(picture.size)
    times = np.random.default_rng(1).integers(0, marks.last_ns, SEEKS).tolist()
    sought, painted, worked, anew = [], [], [], []
    # As the window does.
    gc.collect()
    gc.freeze()
    for t_ns in times:
        begun, worked_before = time.perf_counter(), time.process_time()
        head = tape.go_to(t_ns)
        sought.append(time.perf_counter() - begun)
        picture.draw(surface, Shown(head, t_ns, playing=False, speed=1.0))
        painted.append(time.perf_counter() - begun)
        worked.append(time.process_time() - worked_before)
    for t_ns in times[:FROM_THE_BEGINNING]:
        anew.append(timed(lambda t_ns=t_ns: from_the_beginning(recording, t_ns)))
        assert from_the_beginning(recording, t_ns).screen == tape.go_to(t_ns).screen
    longest = {
        "seek": told(f"{SEEKS} seeks", sought),
        "seek with its picture": told("with the analyst's picture painted", painted),
    }
    told("the same in processor time", worked)
    told(f"{FROM_THE_BEGINNING} times from the beginning", anew)
    ratio = np.median(anew) / np.median(sought)
    print(f"  from the beginning takes {ratio:.0f} times as long (medians)")
    print(f"  peak memory, that of simulating included: {peak_mib()} MiB")
    for what, milliseconds in longest.items():
        verdict = "within" if milliseconds <= WANTED_MS else "NOT within"
        print(f"  the longest {what} is {verdict} {WANTED_MS:g} ms")


def main() -> None:
    """Record, measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        recording = recorded(Path(folder), quick="--quick" in sys.argv)
        marks = read_marks(recording)
        mib = recording.path.stat().st_size / 2**20
        print(f"A session of {marks.last_ns / 60e9:.1f} minutes, {mib:.1f} MiB ({machine()})")
        measure(recording, marks)


if __name__ == "__main__":
    main()
