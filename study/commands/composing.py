"""What `run` and `simulate` have in common: opening a session and its recording."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib.metadata
import json
import platform
import re
import secrets
import time
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from pathlib import Path

from study.errors import StudyError
from study.events.inputs import SessionOpened
from study.events.shell import ClockPair
from study.loading import LoadedProtocol
from study.recording.client import Recorder
from study.recording.failover import FailoverRecorder
from study.recording.identity import PILOT
from study.recording.plan_lock import ATTACHMENT, read_lock
from study.session.rules import CURRENT
from study.shell.picture_records import PictureRecords

PICTURES_WAIT_NS = 2_000_000_000
"""A disk that is so far behind is asked for no pictures: all else must not wait for them."""
_VERSIONED = ("scaled-autonomy", "numpy", "scipy", "torch", "mcap", "pygame-ce", "pydantic")


@dataclasses.dataclass(frozen=True, slots=True)
class Assignment:
    """Who takes part, and how.

    Attributes:
        participant: pseudonymous id.
        seed: the session's seed.
        order: conditions in the order run.
        planned_index: place in the plan, from 0; -1 if unknown.
        operator_kind: "person" or "simulated".
        operator_json: parameters of a simulated operator.
        pilot: whether the session is none of the study's own.
        remark: for the experimenter's notes: that another order was planned; empty for none.
    """

    participant: str
    seed: int
    order: tuple[str, ...]
    planned_index: int
    operator_kind: str
    operator_json: str = "{}"
    pilot: bool = False
    remark: str = ""


def session_opened(
    loaded: LoadedProtocol,
    assignment: Assignment,
    *,
    consent_sha256: str = "",
    consented_utc: str = "",
) -> SessionOpened:
    """Return the first input of a session.

    Args:
        loaded: the protocol.
        assignment: who and how.
        consent_sha256: hash of the text agreed to; empty if none was asked for.
        consented_utc: when, ISO 8601.
    """
    return SessionOpened(
        t_ns=0,
        session_id=secrets.token_hex(8),
        participant=assignment.participant,
        seed=assignment.seed,
        order=assignment.order,
        protocol_toml=loaded.text,
        protocol_sha256=loaded.sha256,
        task_json=loaded.description.to_json(),
        operator_kind=assignment.operator_kind,
        operator_json=assignment.operator_json,
        versions_json=json.dumps(versions(), sort_keys=True),
        started_utc=datetime.now(UTC).isoformat(timespec="seconds"),
        planned_index=assignment.planned_index,
        questionnaires_json=loaded.questionnaires_json(),
        rules=CURRENT,
        consent_sha256=consent_sha256,
        consented_utc=consented_utc,
    )


def versions() -> dict[str, str]:
    """Return the versions of what runs, by name."""
    found = {"python": platform.python_version(), "platform": platform.platform(terse=True)}
    for name in _VERSIONED:
        try:
            found[name] = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            found[name] = "not installed"
    return found


def start_recorder(
    folder: Path, loaded: LoadedProtocol, opened: SessionOpened, *, batch_bytes: int = 0
) -> Recorder:
    """Start the writer process on a new file of a session that could be run again."""
    return Recorder.start(folder, *_described(loaded, opened), batch_bytes=batch_bytes)


def start_failover_recorder(
    folder: Path,
    loaded: LoadedProtocol,
    opened: SessionOpened,
    *,
    name: str = "",
    part: int = 1,
    first_sequence: int = 1,
    pilot: bool = False,
) -> FailoverRecorder:
    """Start the recording of a session that cannot be run again: it outlives its writer.

    Args:
        folder: where the recordings are.
        loaded: the protocol.
        opened: the session's first input.
        name: what the parts before it are called, if the session is resumed.
        part: number of the first file.
        first_sequence: number of the first record.
        pilot: whether the session is none of the study's own; the metadata say so.
    """
    # A later part is written by what runs now.
    now = dataclasses.replace(opened, versions_json=json.dumps(versions(), sort_keys=True))
    given, attachments, metadata = _described(loaded, now)
    if pilot:
        metadata[PILOT] = "true"
    return FailoverRecorder.start(
        folder, name or given, attachments, metadata, part=part, first_sequence=first_sequence
    )


def picture_records(loaded: LoadedProtocol, has_room: Callable[[], bool]) -> PictureRecords | None:
    """Return what makes records of pictures; None where the protocol wants none."""
    return None if loaded.protocol.recording.pictures == "none" else PictureRecords(has_room)


def keeps_up(recorder: FailoverRecorder, now_ns: int) -> bool:
    """Say whether the disk is less than `PICTURES_WAIT_NS` behind.

    Args:
        recorder: of the session.
        now_ns: log time now, nanoseconds since 1970, UTC.
    """
    oldest = recorder.unsaved_log_time_ns
    return oldest is None or now_ns - oldest < PICTURES_WAIT_NS


def _described(
    loaded: LoadedProtocol, opened: SessionOpened
) -> tuple[str, dict[str, bytes], dict[str, str]]:
    """Return name, attachments and metadata of a session's recording."""
    stamp = re.sub(r"[^0-9T]", "", opened.started_utc[:19])
    name = f"{loaded.protocol.study.name}_{opened.participant}_{stamp}_{opened.session_id[:4]}"
    metadata = {
        "session_id": opened.session_id,
        "participant": opened.participant,
        "operator_kind": opened.operator_kind,
        "protocol_sha256": opened.protocol_sha256,
        **{f"version:{key}": value for key, value in json.loads(opened.versions_json).items()},
    }
    attachments = {"protocol.toml": loaded.text.encode()}
    locked = read_lock(loaded.path)
    if locked is not None:
        attachments[ATTACHMENT] = locked[0]
    return name, attachments, metadata


def lock_warning(loaded: LoadedProtocol) -> str:
    """Say what the protocol's plan lock no longer fits; empty if it fits or there is none.

    Raises:
        StudyError: the lock's file is none.
    """
    locked = read_lock(loaded.path)
    if locked is None or locked[1].protocol_sha256 == loaded.sha256:
        return ""
    return (
        f"The protocol has changed since it was locked, {locked[1].locked_utc}: a report of this "
        "session will not be confirmatory. `study lock --again` locks what is there now."
    )


def clock_pair(t_ns: int) -> ClockPair:
    """Return monotonic and wall time, read together."""
    return ClockPair(t_ns=t_ns, utc_ns=time.time_ns())


def parse_order(given: str, conditions: Sequence[str]) -> tuple[str, ...]:
    """Return conditions given in order, separated by commas; none if nothing is given.

    Raises:
        StudyError: they are not each of the conditions once.
    """
    chosen = tuple(part.strip() for part in given.split(",") if part.strip())
    if chosen and sorted(chosen) != sorted(conditions):
        raise StudyError(
            f'"{given}" is no order of these conditions',
            f"Name each condition once: {','.join(sorted(conditions))}.",
        )
    return chosen


def seed_from(text: str) -> int:
    """Return a 63-bit seed derived from words."""
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little") >> 1
