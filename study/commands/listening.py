"""A session's link to consoles: opened beside it, told what a resumed session was before."""

from __future__ import annotations

import os
from collections.abc import Callable

from rich.markup import escape

from study.commands.resuming import Boundary
from study.commands.terminal import errors
from study.console.link import ConsoleLink
from study.console.tracker import TOPICS, Tracker
from study.console.wire import Disk, Facts
from study.errors import StudyError
from study.events.experimenter_records import ExperimenterNoted
from study.events.inputs import SessionOpened
from study.loading import LoadedProtocol
from study.recording.failover import FailoverRecorder


def tracker_of(loaded: LoadedProtocol, opened: SessionOpened, file: str) -> Tracker:
    """Return what gathers a session's state for consoles.

    Args:
        loaded: its protocol.
        opened: its first input.
        file: name of its recording.
    """
    return Tracker(
        Facts(
            session_id=opened.session_id,
            participant=opened.participant,
            study=loaded.protocol.study.name,
            order=opened.order,
            started_utc=opened.started_utc,
            file=file,
            pid=os.getpid(),
        )
    )


def catch_up(tracker: Tracker, boundary: Boundary) -> None:
    """Tell of a resumed session what it was before: up to the boundary, but for the notes."""
    for sequence, record in boundary.recording.records(*TOPICS):
        if sequence <= boundary.after_sequence or isinstance(record, ExperimenterNoted):
            tracker.offer(record, 0, sequence)


def open_link(
    session_id: str, tracker: Tracker, recorder: FailoverRecorder, now_wall_ns: Callable[[], int]
) -> ConsoleLink | None:
    """Listen for consoles; where that cannot be had the session goes on without, and says so.

    Args:
        session_id: of the session.
        tracker: what is told.
        recorder: whose progress is told.
        now_wall_ns: time on the clock of the recording's log times, ns.
    """

    def disk() -> Disk:
        oldest = recorder.unsaved_log_time_ns
        return Disk(
            sent=recorder.sent_sequence,
            durable=recorder.durable_sequence,
            unsaved_s=0.0 if oldest is None else max(0.0, (now_wall_ns() - oldest) / 1e9),
            working=recorder.healthy,
            part=recorder.part,
        )

    try:
        return ConsoleLink.open(session_id, tracker, disk)
    except StudyError as error:
        errors.print(f"[yellow]`study console` cannot watch this session:[/] {escape(str(error))}")
        return None
