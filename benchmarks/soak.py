"""Participants at real speed in real windows beside a CPU hog: memory, records and pictures.

    python -m benchmarks.soak
    python -m benchmarks.soak --minutes 2 --together --series /tmp/memory

Each session is `study run` on the pilot protocol, stretched to the time asked for, in a window on
its own virtual X server (Xvfb). Real keys (XTEST) press their way through; where the session is,
whoever presses them learns as an experimenter would, from the link of `study console`. Another
process takes all the CPU time that it gets.

Of each session it says: how the memory of study, writer and fitting process grows after ten
minutes (half of a shorter run; see `memory_series.Growth`), whether the recording lacks any record
that the study accepted, by a log kept apart, and how punctual pictures and timesteps were. Exit
status 1: a record is missing, a session did not reach its end, or, in a run of twenty minutes or
more, the floor of a process's memory rises by 1 MiB an hour.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import subprocess
import sys
import tempfile
import threading
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path

from benchmarks.pressed_sessions import ROOT, Played, fleet_runs, print_timing, run_one
from study.commands import composing
from study.events.fields import Record
from study.recording.failover import FailoverRecorder
from study.recording.parts import read_session
from study.recording.wire import encode
from study.verification import verify

JUDGED_MINUTES = 20.0
MOST_MIB_AN_HOUR = 1.0
BESIDE_TRIALS_S = 320.0
"""Of a session: all but the trials of phase three."""
TRIALS = 3
"""Of the pilot's phase three, a condition."""


class LoggedRecorder(FailoverRecorder):
    """A recorder that notes in a log what it has accepted: number, topic and checksum."""

    log = -1

    def write(self, record: Record, log_time_ns: int) -> int:
        """Record, then note."""
        number = super().write(record, log_time_ns)
        self._note([(record, log_time_ns)], number)
        return number

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Record all, then note them."""
        last = super().write_together(records)
        self._note(records, last)
        return last

    def _note(self, records: Sequence[tuple[Record, int]], last: int) -> None:
        first = last - len(records) + 1
        lines = [
            f"{number} {record.topic} {zlib.crc32(encode(record))}\n"
            for number, (record, _) in enumerate(records, first)
        ]
        os.write(LoggedRecorder.log, "".join(lines).encode())


def seat(log: str, words: list[str]) -> None:
    """Be the study's program, with a log of what is accepted."""
    from study.commands.main import main as study  # noqa: PLC0415

    LoggedRecorder.log = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    composing.FailoverRecorder = LoggedRecorder  # type: ignore[misc]
    sys.argv = ["study", *words]
    study()


def seat_of(who: Played) -> list[str]:
    """Return what Python is given to be `seat` of a session."""
    return ["-m", "benchmarks.soak", "--seat", str(who.folder / "log")]


def stretched(folder: Path, minutes: float, condition: str) -> Path:
    """Write the pilot protocol so that a session takes about so long; return its path.

    Of its conditions one is left, so that phase three is one block, and long: all that is ever
    painted in it has been seen when the tenth minute is over. What takes memory when it is first
    seen is no growth. Manual choice has the view that enlarges the operated robot.

    Args:
        folder: where the protocol goes.
        minutes: how long a session is to take.
        condition: the one that is left: "manual" or "assisted".
    """
    text = (ROOT / "protocols" / "pilot.toml").read_text(encoding="utf-8")
    seconds = max(12.0, (60 * minutes - BESIDE_TRIALS_S) / TRIALS)
    before, after = text.split("[phase_three]")
    settings, manual, rest = after.split("[[conditions]]")
    assisted, rest = rest.split("[phase_four]")
    manual, views = re.subn(r'view = "tiles"', 'view = "enlarged"', manual)
    longer = f"trial_timesteps = {round(8 * seconds)}"
    settings, trials = re.subn(r"trial_timesteps = 240\b", longer, settings)
    settings, orders = re.subn(r'order = "ab_ba"', 'order = "fixed"', settings)
    assert (trials, views, orders) == (1, 1, 1), "the pilot protocol is another one"
    left = {"manual": manual, "assisted": assisted}[condition]
    # What is assumed of the pilot, and who of it is excluded, does not hold for this one.
    rest, _, after = rest.partition("[[exclusions]]")
    rest += "[analysis]" + after.partition("[analysis]")[2].partition("[assumptions]")[0]
    path = folder / f"soak_{condition}.toml"
    path.write_text(
        f"{before}[phase_three]{settings}[[conditions]]{left}[phase_four]{rest}", encoding="utf-8"
    )
    return path


@contextlib.contextmanager
def hog(*, wanted: bool) -> Iterator[None]:
    """Let a process take all the CPU time that it gets."""
    if not wanted:
        yield
        return
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        process.kill()
        process.wait()


def lost(found: Played) -> tuple[int, int, list[int]]:
    """Return how many records were accepted, how many timesteps among them, and what lacks."""
    accepted: dict[int, tuple[str, int]] = {}
    for line in (found.folder / "log").read_text().splitlines():
        number, topic, checksum = line.split()
        accepted[int(number)] = (topic, int(checksum))
    first = sorted(found.folder.glob("*.mcap*"))[0]
    recording = read_session(first)
    there = {raw.sequence: (raw.topic, zlib.crc32(raw.data)) for raw in recording.raw()}
    missing = [number for number, what in accepted.items() if there.get(number) != what]
    steps = sum(topic == "event/timestep" for topic, _ in accepted.values())
    return len(accepted), steps, missing


def report(found: Played, *, judge_memory: bool) -> bool:
    """Print what a session came to; return whether all was well."""
    print(f"\n{found.participant}:")
    if found.cause is not None or found.ended is None or not found.ended.complete:
        print(f"  did not reach its end: {found.cause or found.ended}")
        print((found.folder / "said").read_text()[-2000:])
        return False
    accepted, steps, missing = lost(found)
    print(f"  {accepted:,} records accepted, {steps:,} of them timesteps; {len(missing)} lost")
    path = sorted(found.folder.glob("*.mcap"))[0]
    verdict = verify(path)
    print(f"  replay: {'identical' if verdict.matches else verdict.difference}")
    well = not missing and verdict.matches
    for name in found.memory.names:
        grown = found.memory.growth(name)
        print(f"  memory of {name}: {grown.sentence}")
        if judge_memory:
            well = well and grown.floor is not None and grown.floor < MOST_MIB_AN_HOUR
    print_timing([timing for group in fleet_runs(path).values() for timing in group])
    oldest = f"oldest unsaved record {found.unsaved_s:.2f} s"
    print(f"  {found.states:,} states told by the link; {oldest}")
    return well


def main(words: Sequence[str] | None = None) -> int:
    """Run all sessions and print what they came to."""
    given_words = list(sys.argv[1:] if words is None else words)
    if given_words[:1] == ["--seat"]:
        seat(given_words[1], given_words[2:])
        return 0
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=20.0, help="of each session, about")
    parser.add_argument("--participants", type=int, default=3)
    parser.add_argument("--together", action="store_true", help="all at once, not in turn")
    parser.add_argument("--no-hog", action="store_true", help="without the CPU hog")
    parser.add_argument("--series", type=Path, help="folder for tables of memory by the second")
    given = parser.parse_args(given_words)
    with tempfile.TemporaryDirectory(prefix="soak") as place:
        # Other sessions of this computer are none of ours.
        os.environ |= {"XDG_RUNTIME_DIR": place, "TMPDIR": place}
        tempfile.tempdir = place
        protocols = [
            stretched(Path(place), given.minutes, condition) for condition in ("manual", "assisted")
        ]
        people = [
            Played(f"P{number:02}", Path(place) / f"P{number:02}")
            for number in range(1, given.participants + 1)
        ]
        threads = [
            threading.Thread(
                target=run_one, args=(protocols[number % 2], who, number, seat_of(who))
            )
            for number, who in enumerate(people)
        ]
        with hog(wanted=not given.no_hog):
            for thread in threads:
                thread.start()
                if not given.together:
                    thread.join()
            for thread in threads:
                thread.join()
        beside = "alone" if given.no_hog else "beside a CPU hog"
        how = "at once" if given.together else "in turn"
        print(f"{len(people)} sessions of about {given.minutes:g} minutes {how}, {beside}, "
              f"on {os.cpu_count()} cores")  # fmt: skip
        if given.series is not None:
            given.series.mkdir(parents=True, exist_ok=True)
            for who in people:
                who.memory.write(given.series / f"{who.participant}.csv")
        judge = given.minutes >= JUDGED_MINUTES
        reports = [report(who, judge_memory=judge) for who in people]
        well = all(reports)
    if not judge:
        print(f"\nMemory is judged in runs of {JUDGED_MINUTES:g} minutes or more.")
    return 0 if well else 1


if __name__ == "__main__":
    sys.exit(main())
