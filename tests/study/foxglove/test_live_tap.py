"""The tap of a session never waits for the live view, and counts what that misses."""

from __future__ import annotations

import importlib.metadata
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from patience import PATIENCE_S
from study.errors import StudyError
from study.events.shell import Note
from study.foxglove.live_tap import LiveTap, require_live
from study.recording.framing import MESSAGE_HEADER, FrameSplitter

pytestmark = pytest.mark.skipif(os.name != "posix", reason="live views need POSIX pipes")
COPY = "import shutil, sys; shutil.copyfileobj(sys.stdin.buffer, sys.stdout.buffer)"


@contextmanager
def viewer(program: str) -> Iterator[subprocess.Popen[bytes]]:
    """Start a process in the live view's place."""
    process = subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                stream.close()


def offer(tap: LiveTap, first: int, last: int) -> None:
    for number in range(first, last + 1):
        tap.offer(Note(t_ns=number, text="x" * 1000), number, number)


def test_a_reader_gets_every_record_in_order() -> None:
    """Whole frames with channel, number and time."""
    with viewer(COPY) as process:
        tap = LiveTap(process)
        offer(tap, 1, 50)
        assert tap.drain(PATIENCE_S)
        assert (tap.passed, tap.dropped) == (50, 0)
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.close()
        frames = list(FrameSplitter().feed(process.stdout.read()))
    numbers = [MESSAGE_HEADER.unpack_from(payload)[1:3] for _, payload in frames]
    assert numbers == [(number, number) for number in range(1, 51)]


def test_a_stopped_view_costs_bounded_memory_and_the_oldest_records() -> None:
    """Nothing waits; once it goes on it gets whole frames again, the newest among them."""
    with viewer(COPY) as process:
        tap = LiveTap(process, queue_bytes=20_000)
        process.send_signal(signal.SIGSTOP)
        offer(tap, 1, 2000)
        assert tap.dropped > 1000
        assert tap._queued <= 20_000
        assert tap.passed + tap.dropped + len(tap._queue) == 2000
        process.send_signal(signal.SIGCONT)
        assert process.stdin is not None
        assert process.stdout is not None
        os.set_blocking(tap._pipe, True)
        tap._push()
        process.stdin.close()
        frames = list(FrameSplitter().feed(process.stdout.read()))
    numbers = [MESSAGE_HEADER.unpack_from(payload)[1] for _, payload in frames]
    assert numbers[-1] == 2000
    assert numbers == sorted(numbers)
    assert len(numbers) == 2000 - tap.dropped


def test_a_view_that_dies_is_noticed_and_nothing_fails() -> None:
    """What comes after its end is counted."""
    with viewer(COPY) as process:
        tap = LiveTap(process)
        process.kill()
        process.wait()
        offer(tap, 1, 10)
        assert tap.ended
        assert tap.dropped + tap.passed == 10
        tap.close()


def test_closing_does_not_wait_for_a_view_that_stands_still() -> None:
    """It is ended, although stopped."""
    with viewer(COPY) as process:
        tap = LiveTap(process)
        process.send_signal(signal.SIGSTOP)
        offer(tap, 1, 500)
        tap.close()
        assert process.poll() == -signal.SIGKILL
        assert tap.dropped > 0


def test_without_the_extra_one_message_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Before anything is started."""

    def missing(name: str) -> str:
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", missing)
    with pytest.raises(StudyError, match=r"foxglove-sdk") as caught:
        require_live()
    assert "pip install 'scaled-autonomy[live]'" in caught.value.hint
