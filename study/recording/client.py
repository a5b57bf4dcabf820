"""The study's side of a recording: hands records to the writer process without waiting."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Self

from study.errors import StudyError
from study.events.fields import Record
from study.recording.backlog import Backlog, Framed
from study.recording.framing import MESSAGE_HEADER, SEQUENCE, FrameKind, FrameSplitter, frame
from study.recording.naming import recording_path
from study.recording.opening import channel_numbers, opening_payload
from study.recording.pipe_sender import PipeSender
from study.recording.report import WriterReport
from study.recording.spawning import spawn_writer
from study.recording.wire import encode

BACKLOG_LIMIT = 64 * 2**20
"""Bytes of records that may wait for the disk before `Recorder.write` refuses more."""

START_TIMEOUT = 30.0
"""Seconds within which the writer process must have made the file."""


END_TIMEOUT = 0.5
"""Seconds that a killed writer is waited for. One that the disk holds up ends later by itself."""


class BacklogError(StudyError):
    """So much waits for the disk that no record is taken for now; none was lost."""


class Recorder:
    """A recording under way. Any thread may call; records are ordered as they are taken.

    `write` numbers a record, encodes it and passes it to the operating system's pipe; what
    the pipe has no room for is sent by a thread. Once a record is in the pipe, the writer
    process brings it into the file even if this process is killed the moment after. Records
    are kept until they are known to be on disk, see `unacknowledged`.

    Attributes:
        path: the final path.
        backlog: what is not yet known to be on disk, and how far the disk has got.
        report: what the writer has said of itself.
    """

    def __init__(
        self,
        process: subprocess.Popen[bytes],
        path: Path,
        *,
        backlog_limit: int = BACKLOG_LIMIT,
        batch_bytes: int = 0,
        first_sequence: int = 1,
        keeps_on: bool = False,
    ) -> None:
        assert process.stdin is not None  # noqa: S101 - both are pipes, see `start`
        assert process.stdout is not None  # noqa: S101
        self.path = path
        self._process = process
        self._answers = process.stdout.fileno()
        self._backlog_limit = backlog_limit
        self._channels = channel_numbers()
        self._changed = threading.Condition()
        self.backlog = Backlog(first_sequence)
        self._keeps_on = keeps_on
        self.report = WriterReport()
        self._closing = False
        self._failure: StudyError | None = None
        self._sender = PipeSender(process.stdin.fileno(), self._changed, batch_bytes)
        self._listener = threading.Thread(target=self._listen, daemon=True, name="recorder-answers")
        self._listener.start()

    @classmethod
    def start(
        cls,
        folder: Path,
        name: str,
        attachments: Mapping[str, bytes],
        metadata: Mapping[str, str],
        *,
        backlog_limit: int = BACKLOG_LIMIT,
        batch_bytes: int = 0,
        first_sequence: int = 1,
        resent: Sequence[Framed] = (),
        keeps_on: bool = False,
        start_timeout: float = START_TIMEOUT,
    ) -> Self:
        """Start the writer process and wait until the file's beginning is on disk.

        Start it before windows and other processes, so that no child keeps its pipe open.

        Args:
            folder: where the recording goes; made (for its owner only) if need be.
            name: the recording's name without ``.mcap``.
            attachments: files kept inside the recording: ``{"protocol.toml": ...}``.
            metadata: what is to be known of the recording: ``session_id``, versions, ...
            backlog_limit: bytes that may wait for the disk.
            batch_bytes: bytes that may gather before they are sent: fewer, larger writes
                for simulated sessions. 0 sends each record at once, so that a crash of
                the study costs at most the record in flight.
            first_sequence: number of the file's first record; more than 1 in a later part.
            resent: what `abandon` gave, sent first; its first record is `first_sequence`.
            keeps_on: whether records are still taken, and kept, after the writer has failed.
            start_timeout: seconds within which the file must have been made.

        Raises:
            StudyError: folder or file cannot be made, or the name is taken.
        """
        path = recording_path(folder, name)
        opening = opening_payload(path, attachments, metadata, time.time_ns())
        recorder = cls(
            spawn_writer(),
            path,
            backlog_limit=backlog_limit,
            batch_bytes=batch_bytes,
            first_sequence=first_sequence,
            keeps_on=keeps_on,
        )
        with recorder._changed:
            recorder._sender.send(frame(FrameKind.OPEN, opening), at_once=True)
            for framed in resent:
                recorder._take(framed)
            recorder._changed.wait_for(
                lambda: recorder.report.ready or recorder._failure is not None, start_timeout
            )
            failure = recorder._failure
        if failure is not None:
            recorder._end_process()
            raise StudyError(f"{path} cannot be recorded: {failure.message}", failure.hint)
        if not recorder.report.ready:
            recorder.abandon()
            raise StudyError(
                f"the writer of {path} did not start within {start_timeout:g} s",
                "Try again; if it recurs, check that the disk answers.",
            )
        return recorder

    @property
    def sent_sequence(self) -> int:
        """Sequence number of the last record taken; 0 before the first."""
        return self.backlog.sent

    @property
    def durable_sequence(self) -> int:
        """Sequence number of the last record known to be on disk."""
        return self.backlog.durable

    @property
    def backlog_bytes(self) -> int:
        """Bytes taken that are not yet known to be on disk."""
        return self.backlog.size

    @property
    def healthy(self) -> bool:
        """Whether the writer works and less than half of the backlog's limit waits.

        A study pauses while this is false: a record refused later would be a gap.
        """
        return self._failure is None and self.backlog.size < self._backlog_limit // 2

    @property
    def writer_pid(self) -> int:
        """Process id of the writer."""
        return self._process.pid

    @property
    def failure(self) -> StudyError | None:
        """What went wrong with the writer, if anything did."""
        return self._failure

    def write(self, record: Record, log_time_ns: int) -> int:
        """Take one record; see `write_together`.

        Returns:
            The record's sequence number: 1, 2, ... over all topics.
        """
        return self.write_together([(record, log_time_ns)])

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Take records that are to be in the file all or not at all.

        Neither the writer nor the disk is waited for.

        Args:
            records: at least one record, each with its log time: nanoseconds since 1970, UTC.

        Returns:
            The last record's sequence number.

        Raises:
            TypeError: a field has the wrong type; nothing was taken.
            ValueError: a field is out of range or has the wrong shape; nothing was taken.
            BacklogError: `backlog_limit` is exceeded; nothing was taken.
            StudyError: the writer has failed.
        """
        encoded = []
        for record, log_time_ns in records:
            if not 0 <= log_time_ns < 2**64:
                raise ValueError(f"log time {log_time_ns} is not from 0 to {2**64 - 1}")
            encoded.append((self._channels[record.topic], log_time_ns, encode(record)))
        with self._changed:
            if self._failure is not None and not self._keeps_on:
                raise self._failure
            if self._closing and self._failure is None:
                raise StudyError(f"{self.path} is closed", "Start a new recording.")
            size = sum(len(data) for _, _, data in encoded)
            if self.backlog.size + size > self._backlog_limit:
                raise BacklogError(
                    f"{self.backlog.size} bytes of {self.path} wait for the disk",
                    "Pause until the disk has caught up; check that it answers.",
                )
            pieces = []
            for number, (channel, log_time_ns, data) in enumerate(encoded, self.backlog.sent + 1):
                pieces += [MESSAGE_HEADER.pack(channel, number, log_time_ns, len(data)), data]
            framed = frame(FrameKind.MESSAGES, *pieces)
            self._take(Framed(framed, len(encoded), encoded[-1][1]))
            return self.backlog.sent

    def _take(self, framed: Framed) -> None:
        self.backlog.add(framed, time.perf_counter_ns())
        if self._failure is None:
            self._sender.send(framed.frame, at_once=False)

    def ensure_durable(self, timeout_s: float) -> bool:
        """Wait until all records taken so far are on disk.

        Returns:
            False if the writer failed or needed longer than `timeout_s`.
        """
        with self._changed:
            target = self.backlog.sent
            if self.backlog.durable < target and self._failure is None and not self._closing:
                self._sender.send(frame(FrameKind.SYNC), at_once=True)
            self._changed.wait_for(
                lambda: self.backlog.durable >= target or self._failure is not None, timeout_s
            )
            return self.backlog.durable >= target

    def unacknowledged(self) -> list[int]:
        """Return the sequence numbers of records not yet known to be on disk."""
        with self._changed:
            return list(range(self.backlog.durable + 1, self.backlog.sent + 1))

    def close(self, timeout: float = 30.0) -> Path:
        """Complete the file and return its final path; a second call returns it again.

        Raises:
            StudyError: the writer failed, or is not done after `timeout` seconds.
        """
        deadline = time.monotonic() + timeout
        with self._changed:
            self._closing = True
            self._sender.close()
        if self._sender.join(timeout) and self._process.stdin is not None:
            self._process.stdin.close()
        self._listener.join(max(0.0, deadline - time.monotonic()))
        if self.report.finished is None and self._failure is None:
            raise StudyError(
                f"{self.path} is not complete after {timeout:g} s",
                "The writer goes on by itself; the file loses its .part when it is done.",
            )
        self._end_process()
        if self.report.finished is None:
            assert self._failure is not None  # noqa: S101 - one of the two is set here
            raise self._failure
        return self.report.finished

    def abandon(self) -> list[Framed]:
        """End the writer at once and give the file up as it is.

        When this returns the writer cannot write any more. Its file keeps ``.part``.

        Returns:
            The records not known to be on disk, as `start` takes them for another part.
        """
        self._process.kill()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._process.wait(END_TIMEOUT)
        # Answers that were already on their way still count.
        self._listener.join(END_TIMEOUT)
        with self._changed:
            if self._failure is None:
                self._fail("the writer process was ended", "")
            self._closing = True
            self._sender.clear()
            self._sender.close()
        if not self._listener.is_alive():
            self._end_process()
        return self.backlog.frames()

    def _listen(self) -> None:
        """Take the writer's answers until it ends."""
        splitter = FrameSplitter()
        while data := os.read(self._answers, 1 << 16):
            with self._changed:
                for kind, payload in splitter.feed(data):
                    self._take_answer(kind, payload)
                self._changed.notify_all()
        status = self._process.wait()
        with self._changed:
            if self.report.finished is None and self._failure is None:
                self._fail(
                    f"the writer process ended unexpectedly (status {status})",
                    f"To see whether it can start: {sys.executable} -m study.recording.writer",
                )
            self._changed.notify_all()

    def _take_answer(self, kind: FrameKind, payload: bytes) -> None:
        self.report.take(kind, payload)
        if kind is FrameKind.DURABLE:
            self.backlog.acknowledge(SEQUENCE.unpack(payload)[0], time.perf_counter_ns())
        elif kind is FrameKind.FINISHED:
            self.backlog.acknowledge(self.backlog.sent, time.perf_counter_ns())
        elif kind is FrameKind.FAILED:
            self._fail(*self.report.cause)

    def _fail(self, message: str, hint: str) -> None:
        self.report.cause = (message, hint)
        if not self.report.ready:
            self._failure = StudyError(message, hint)
            return
        self._failure = StudyError(
            f"{self.path} is not complete: {message}. Record {self.backlog.durable} of "
            f"{self.backlog.sent} is the last known to be on disk",
            f"{hint} What was written is in {self.path.name}.part.".strip(),
        )

    def _end_process(self) -> None:
        """Release the pipes of a writer that has ended or is about to."""
        with self._changed:
            self._closing = True
            self._sender.clear()
            self._sender.close()
        self._sender.join()
        self._process.wait()
        self._listener.join()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
