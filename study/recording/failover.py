"""A recording that outlives its writer: when one fails, a numbered part goes on with another."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Self

from study.errors import RecordingFailedError, StudyError
from study.events.fields import Record
from study.recording.backlog import Framed
from study.recording.client import BACKLOG_LIMIT, START_TIMEOUT, Recorder
from study.recording.durable_file import PART_SUFFIX
from study.recording.identity import PART
from study.recording.outcome import Outcome
from study.recording.parts import part_name

STALL_NS = 900_000_000
"""Records that wait for the disk so long, with none getting there, mean that the writer stalls: it
answers at least every half second. A loop notices within a second."""

PASS_NS = 500_000_000
GRACE_NS = 600_000_000
"""More than the first between two checks: this process stood still, perhaps the whole machine. The
writer then has the second to be heard."""

TOO_FAST = "records come faster than the disk takes them"
"""A fault that another writer would not mend: time does."""

ATTEMPTS = 3
"""Parts begun in a row, none of which gets what waited to the disk, before it is given up."""

SILENCE_S = 5.0
"""Seconds without any progress after which a writer that is waited for is given up. The session
stands still meanwhile; on a machine that is only busy, its part goes on afterwards."""

PART_START_TIMEOUT = 20.0
"""Seconds for a later part to be made: better than a session lost because its machine was busy."""

_SLICE_S = 0.05


class FailoverRecorder:
    """A session's recording in one file, or in several when writers fail.

    Used like a `Recorder`, by one thread. While a writer is dead, records are numbered and kept,
    so that `write` goes on working until `begin_part` has sent them to another writer; records
    keep their numbers and log times. A caller with a session to tell asks `check` at every pass
    of its loop, and calls `begin_part` when it reports a fault.
    """

    def __init__(
        self,
        folder: Path,
        name: str,
        attachments: Mapping[str, bytes],
        metadata: Mapping[str, str],
        *,
        backlog_limit: int,
        batch_bytes: int,
        part: int,
        first_sequence: int,
    ) -> None:
        self._folder = folder.absolute()
        self._name = name
        self._attachments = dict(attachments)
        self._metadata = dict(metadata)
        self._limits = (backlog_limit, batch_bytes)
        self._part = part
        self._paths: list[Path] = []
        self._safe_log_time_ns = 0
        self._untold = ""
        self._remarks: list[str] = []
        self._checked_ns = time.perf_counter_ns()
        self._patient_until_ns = 0
        self._failure: RecordingFailedError | None = None
        self._closed = False
        self._recorder = self._open(first_sequence, (), START_TIMEOUT)

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
        part: int = 1,
        first_sequence: int = 1,
    ) -> Self:
        """Start the first writer; see `Recorder.start` for the arguments not named here.

        Args:
            folder: where all parts go.
            name: of the recording without ``.mcap``; later parts are called NAME_part2, ...
            attachments: files kept inside every part.
            metadata: of every part; ``part`` is added.
            backlog_limit: bytes that may wait for the disk.
            batch_bytes: bytes that may gather before they are sent.
            part: number of the first file: more than 1 if the session is resumed.
            first_sequence: number of the first record.

        Raises:
            StudyError: folder or file cannot be made, or the name is taken.
        """
        return cls(
            folder,
            name,
            attachments,
            metadata,
            backlog_limit=backlog_limit,
            batch_bytes=batch_bytes,
            part=part,
            first_sequence=first_sequence,
        )

    @property
    def part(self) -> int:
        """Number of the part that is being written, from 1."""
        return self._part

    @property
    def path(self) -> Path:
        """Final path of the part that is being written."""
        return self._recorder.path

    @property
    def sent_sequence(self) -> int:
        """Sequence number of the last record taken."""
        return self._recorder.sent_sequence

    @property
    def durable_sequence(self) -> int:
        """Sequence number of the last record known to be on disk."""
        return self._recorder.durable_sequence

    @property
    def healthy(self) -> bool:
        """Whether the writer works and less than half of the backlog's limit waits."""
        return self._recorder.healthy

    @property
    def unsaved_log_time_ns(self) -> int | None:
        """Log time of the oldest record not known to be on disk; None if all are."""
        return self._recorder.backlog.oldest_log_time_ns()

    @property
    def writer_pid(self) -> int:
        """Process id of the present writer."""
        return self._recorder.writer_pid

    def write(self, record: Record, log_time_ns: int) -> int:
        """Take one record, whether or not the writer works; see `Recorder.write`."""
        return self._recorder.write(record, log_time_ns)

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Take records all or none of which are to be in a part; see `Recorder.write_together`."""
        return self._recorder.write_together(records)

    def take_remarks(self) -> list[str]:
        """Return, once, what went wrong outside and was mended, in words."""
        taken, self._remarks = self._remarks, []
        return [*taken, *self._recorder.report.take_remarks()]

    def check(self, now_perf_ns: int) -> str | None:
        """Look after the writer; to be called several times a second.

        Args:
            now_perf_ns: ``time.perf_counter_ns()``.

        Returns:
            What is wrong, in words, if something is that `begin_part` was not called for yet.
        """
        if now_perf_ns - self._checked_ns > PASS_NS:
            # We stood still, and so did the taking of answers: that is no stall of the writer.
            self._patient_until_ns = now_perf_ns + GRACE_NS
        self._checked_ns = now_perf_ns
        if self._untold:
            return self._untold
        if self._recorder.failure is not None:
            return self._recorder.report.cause[0]
        if not self._recorder.healthy:
            return TOO_FAST
        waiting = self._recorder.backlog.waiting_since_ns()
        if waiting is None or now_perf_ns <= max(waiting + STALL_NS, self._patient_until_ns):
            return None
        return f"the writer process wrote nothing for {STALL_NS / 1e9:g} s"

    def begin_part(self, reason: str) -> int:
        """Begin a part with a fresh writer and bring all that waited to the disk.

        If the writer lives it is waited for first: when it or the disk was only slow, the part
        goes on. Nothing is done if this was done already, within `ensure_durable`.

        Args:
            reason: what `check` said.

        Returns:
            The number of the part that is being written now.

        Raises:
            RecordingFailedError: no part can be begun that reaches the disk; it says up to which
                moment the recording is safe.
        """
        if self._untold:
            self._untold = ""
        elif not self._comes_round():
            self._fail_over(reason)
        return self._part

    def ensure_durable(self, timeout_s: float) -> bool:
        """Wait until all records taken so far are on disk, with another writer if need be.

        `check` reports afterwards if there was need.

        Returns:
            False if that took longer than `timeout_s`.

        Raises:
            RecordingFailedError: see `begin_part`.
        """
        deadline = time.monotonic() + timeout_s
        while not self._recorder.ensure_durable(_SLICE_S):
            fault = self.check(time.perf_counter_ns()) if not self._untold else self._fault_again()
            if fault:
                if not self._comes_round():
                    self._fail_over(fault)
                self._untold = fault
            elif time.monotonic() > deadline:
                return False
        return True

    def close(self, timeout: float = 30.0) -> list[Path]:
        """Complete the last part; a second call returns the same.

        Returns:
            All parts in order. One whose writer failed is ``NAME.mcap.part``; what it lacks is in
            the part after it.

        Raises:
            RecordingFailedError: the last part is not complete; it says what is safe.
        """
        if self._failure is not None:
            raise self._failure
        if self._closed:
            return self._paths
        if not self.ensure_durable(timeout):
            self._recorder.abandon()
            raise self._lost(f"the disk did not answer within {timeout:g} s", "Check the disk.")
        try:
            path = self._recorder.close(timeout)
        except StudyError as error:
            cause, hint = self._recorder.report.cause
            raise self._lost(cause or error.message, hint or error.hint) from error
        self._remarks += self._recorder.report.take_remarks()
        self._paths.append(path)
        self._closed = True
        return self._paths

    def _open(
        self, first_sequence: int, resent: Sequence[Framed], start_timeout: float
    ) -> Recorder:
        backlog_limit, batch_bytes = self._limits
        return Recorder.start(
            self._folder,
            part_name(self._name, self._part),
            self._attachments,
            {**self._metadata, PART: str(self._part)},
            backlog_limit=backlog_limit,
            batch_bytes=batch_bytes,
            first_sequence=first_sequence,
            resent=resent,
            keeps_on=True,
            start_timeout=start_timeout,
        )

    def _fault_again(self) -> str | None:
        """As `check`, for the part begun since a fault that nobody was told of."""
        told, self._untold = self._untold, ""
        fault, self._untold = self.check(time.perf_counter_ns()), told
        return fault

    def _fail_over(self, reason: str) -> None:
        if self._failure is not None:
            raise self._failure
        for _ in range(ATTEMPTS):
            # What seemed a stall may have turned out to be something else meanwhile.
            reason = self._recorder.report.cause[0] or reason
            kept = self._give_up_part(reason)
            try:
                self._part += 1
                self._recorder = self._open(
                    self._recorder.durable_sequence + 1, kept, PART_START_TIMEOUT
                )
            except StudyError as error:
                self._part -= 1
                raise self._lost(reason, error.hint, f" No other part: {error.message}.") from error
            if self._comes_round():
                return
        cause, hint = self._recorder.report.cause
        reason = cause or reason
        self._give_up_part(reason)
        raise self._lost(reason, hint)

    def _give_up_part(self, reason: str) -> list[Framed]:
        """End the present writer for good; return what waits."""
        recorder = self._recorder
        kept = recorder.abandon()
        self._remarks += recorder.report.take_remarks()
        self._safe_log_time_ns = recorder.backlog.durable_log_time_ns or self._safe_log_time_ns
        self._paths.append(recorder.path.with_name(recorder.path.name + PART_SUFFIX))
        if recorder.report.file_lost:
            raise self._lost(
                reason, recorder.report.cause[1], f" {self._paths.pop().name} is gone."
            )
        return kept

    def _comes_round(self) -> bool:
        """Wait for what waits to reach the disk, as long as the writer gets on."""
        reached, since = self._recorder.durable_sequence, time.monotonic()
        while not self._recorder.ensure_durable(_SLICE_S):
            if self._recorder.failure is not None:
                return False
            if self._recorder.durable_sequence > reached:
                reached, since = self._recorder.durable_sequence, time.monotonic()
            elif time.monotonic() - since > SILENCE_S:
                return False
        self._checked_ns = time.perf_counter_ns()
        return True

    def _lost(self, reason: str, hint: str, more: str = "") -> RecordingFailedError:
        """Return, and remember, the error that says what is safe."""
        recorder = self._recorder
        lost = recorder.report.file_lost
        last = [] if lost else [recorder.path.with_name(recorder.path.name + PART_SUFFIX)]
        outcome = Outcome(
            sent=recorder.sent_sequence,
            durable=recorder.durable_sequence,
            durable_log_time_ns=recorder.backlog.durable_log_time_ns or self._safe_log_time_ns,
            file_lost=lost,
            paths=tuple(dict.fromkeys([*self._paths, *last])),
        )
        self._failure = RecordingFailedError(
            f"the recording {self._name} ended: {reason}.{more} {outcome.what_is_safe()}",
            f"{hint} {outcome.what_there_is(self._folder)}".strip(),
        )
        return self._failure
