"""The writer process: drains the study's pipe into an MCAP file, and outlives the study.

Started by `study.recording.client` as ``python -m study.recording.writer``. It reads frames
on standard input and answers on standard output. When its input ends, for whatever reason,
it completes the file: a study that is killed leaves a complete recording behind.

The main thread drains the pipe and writes; a second thread closes a chunk and waits for the
disk every half second, so that a slow disk never holds up the pipe. The pipe is looked at by the
clock, not waited at: waking a process costs the one that writes, which is the study in the midst
of a timestep.

A hook for tests: with ``SCALED_AUTONOMY_FAIL_SYNC_AFTER=N`` in the environment every wait for
the disk after the N-th fails with an input/output error, as on a broken disk.
"""

from __future__ import annotations

import base64
import contextlib
import errno
import itertools
import json
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from study.allocation import give_holes_back, give_large_blocks_back
from study.recording.durable_file import DurableFile, LostFileError
from study.recording.framing import SEQUENCE, FrameKind, FrameSplitter, frame, split_messages

FLUSH_INTERVAL = 0.5
"""Seconds between two chunks: what at most is lost when the machine itself stops."""

TIDY_EVERY = 20
"""Chunks after which memory that is not used any more is given back."""

LOOK_INTERVAL = 0.005
"""Seconds between two looks at a pipe that was empty."""

FAIL_SYNC_AFTER = "SCALED_AUTONOMY_FAIL_SYNC_AFTER"

_READ_SIZE = 1 << 20
_STDIN, _STDOUT = 0, 1


class RecordingWriter:
    """One MCAP file while it is being written.

    Args:
        opening: the payload of the OPEN frame: ``path``, ``profile``, ``library``,
            ``metadata_name``, ``metadata``, ``attachments`` (name, media_type, data),
            ``channels`` (topic, schema, descriptor) and ``start`` (channel, log_time, data);
            bytes are in base64. Channels are numbered from 1 in the order given.

    Raises:
        OSError: the file cannot be made.
    """

    def __init__(self, opening: dict[str, Any]) -> None:
        hook = os.environ.get(FAIL_SYNC_AFTER, "")
        self._file = DurableFile(Path(opening["path"]), int(hook) if hook.isdecimal() else None)
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self._stopping = False
        self._last_sequence = 0
        self._durable_sequence = 0
        try:
            self._mcap = self._start(opening)
        except BaseException:
            # The study is told that there is no recording; then there must be no file either.
            self._file.discard()
            raise
        self._syncing = threading.Thread(target=self._sync_regularly, daemon=True)
        self._syncing.start()

    def add(self, frames: list[tuple[FrameKind, bytes]]) -> None:
        """Write the records of MESSAGES frames; a SYNC frame wakes the syncing thread."""
        with self._lock:
            for kind, payload in frames:
                if kind is FrameKind.MESSAGES:
                    for channel, sequence, log_time, data in split_messages(payload):
                        self._mcap.add_message(channel, log_time, data, log_time, sequence)
                        self._last_sequence = sequence
        if any(kind is FrameKind.SYNC for kind, _ in frames):
            self._wake.set()

    def finish(self) -> Path:
        """Write the index and the summary, and give the file its final name."""
        self._stopping = True
        self._wake.set()
        self._syncing.join()
        # Before the index: if there is no room for it, the records are safe all the same.
        self._bring_to_disk()
        self._mcap.finish()
        return self._file.publish()

    def _start(self, opening: dict[str, Any]) -> Any:  # noqa: ANN401 - mcap's Writer is untyped
        # Slow to import, so only once signals are ignored and the file exists.
        from mcap.writer import Writer  # noqa: PLC0415

        from study.recording.chunk_indexes import keep_small  # noqa: PLC0415

        mcap: Any = Writer(self._file, enable_data_crcs=True)  # type: ignore[arg-type]
        keep_small(mcap)
        mcap.start(opening["profile"], opening["library"])
        mcap.add_metadata(opening["metadata_name"], opening["metadata"])
        start = opening["start"]
        for item in opening["attachments"]:
            mcap.add_attachment(
                create_time=start["log_time"],
                log_time=start["log_time"],
                name=item["name"],
                media_type=item["media_type"],
                data=base64.b64decode(item["data"]),
            )
        for channel in opening["channels"]:
            descriptor = base64.b64decode(channel["descriptor"])
            schema = mcap.register_schema(channel["schema"], "protobuf", descriptor)
            mcap.register_channel(channel["topic"], "protobuf", schema)
        # Schemas and channels reach the file with its first message only.
        log_time = start["log_time"]
        mcap.add_message(start["channel"], log_time, base64.b64decode(start["data"]), log_time, 0)
        mcap.flush()
        self._file.sync()
        return mcap

    def _sync_regularly(self) -> None:
        try:
            for number in itertools.count(1):
                if self._stopping:
                    return
                self._wake.wait(FLUSH_INTERVAL)
                self._wake.clear()
                self._bring_to_disk()
                if number % TIDY_EVERY == 0:
                    give_holes_back()
        except BaseException as error:  # the process has to end with its file
            _give_up(error)

    def _bring_to_disk(self) -> None:
        with self._lock:
            self._mcap.flush()
            if self._file.keep_named():
                folder = self._file.part_path.parent
                remark = f"The recording was not in {folder} any more; all of it was put back."
                _answer(FrameKind.REMARK, remark.encode())
            sequence = self._last_sequence
        if sequence != self._durable_sequence:
            self._file.sync()
            self._durable_sequence = sequence
            _answer(FrameKind.DURABLE, SEQUENCE.pack(sequence))


def main() -> int:
    """Serve one study until its pipe ends; return the exit status."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        if hasattr(signal, name):
            signal.signal(getattr(signal, name), signal.SIG_IGN)
    if os.name == "posix":
        # A study that stands still and reads no answers must not hold up the writing.
        os.set_blocking(_STDOUT, False)
    try:
        _serve()
    except Exception as error:  # reported to the study, which shows it
        _give_up(error)
    return 0


def _serve() -> None:
    give_large_blocks_back()
    splitter = FrameSplitter()
    writer: RecordingWriter | None = None
    for data in _arrivals():
        frames = list(splitter.feed(data))
        if writer is None and frames:
            writer = RecordingWriter(json.loads(frames.pop(0)[1]))
            _answer(FrameKind.READY)
        if writer is not None and frames:
            writer.add(frames)
    if writer is not None:
        _answer(FrameKind.FINISHED, str(writer.finish()).encode())


def _arrivals() -> Iterator[bytes]:
    """Yield what comes through the pipe, until it ends."""
    if os.name == "posix":
        os.set_blocking(_STDIN, False)
    while True:
        try:
            data = os.read(_STDIN, _READ_SIZE)
        except BlockingIOError:
            time.sleep(LOOK_INTERVAL)
            continue
        if not data:
            return
        yield data


def _answer(kind: FrameKind, payload: bytes = b"") -> None:
    # A study that is gone or stands still gets no answer; a later one says all that it would.
    with contextlib.suppress(OSError):
        os.write(_STDOUT, frame(kind, payload))


def _give_up(error: BaseException) -> None:
    """Report an error and end at once; what is on disk stays, as NAME.mcap.part."""
    message, hint = _in_words(error)
    lost = isinstance(error, LostFileError)
    report = json.dumps({"message": message[:2000], "hint": hint, "lost": lost})
    _answer(FrameKind.FAILED, report.encode())
    os._exit(1)


def _in_words(error: BaseException) -> tuple[str, str]:
    """Return what went wrong and what to do."""
    if not isinstance(error, OSError):
        return f"{type(error).__name__}: {error}", ""
    name = f" ({error.filename})" if error.filename else ""
    if isinstance(error, LostFileError):
        return (
            f"{error.filename} was deleted while it was written and cannot be put back: "
            f"{error.strerror}",
            "Leave the folder of recordings alone while a session runs.",
        )
    if isinstance(error, FileExistsError):
        return (
            f"{error.filename} exists already",
            "Recordings are never overwritten: choose another name, or move that file away.",
        )
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"the disk is full{name}", "Free space on that disk, or record to another one."
    if error.errno == errno.EIO:
        return f"the disk reported an error{name}", "Record to another disk, and have this checked."
    hint = "Check that the folder exists, is writable and has space left."
    return f"{error.strerror}{name}", hint


if __name__ == "__main__":
    sys.exit(main())
