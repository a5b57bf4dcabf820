"""Whether the plan was fixed before the first record, and what has changed since."""

from __future__ import annotations

import dataclasses
import difflib
import hashlib
from collections.abc import Mapping, Sequence
from datetime import datetime

from analysis.environment import analysis_files, environment
from analysis.recordings import Session, StudyRecordings
from study.errors import StudyError
from study.recording.plan_lock import ATTACHMENT, PlanLock, canonical_rules, parse_lock

MOST_LINES = 60
"""Lines of a protocol's difference that a report prints."""


@dataclasses.dataclass(frozen=True, slots=True)
class Difference:
    """One thing that is not as it was locked.

    Attributes:
        what: protocol, exclusions, analysis code, environment, ...
        text: what differs, in words.
        lines: the difference itself, line by line; may be empty.
    """

    what: str
    text: str
    lines: tuple[str, ...] = ()


@dataclasses.dataclass(frozen=True, slots=True)
class PlanStatus:
    """What can be said of the plan.

    Attributes:
        lock: the lock that the recordings carry; None if there is none, or not one for all.
        differences: what stands against calling a result confirmatory.
        planned: names of the analyses that were planned.
    """

    lock: PlanLock | None
    differences: tuple[Difference, ...]
    planned: tuple[str, ...]

    @property
    def confirmatory(self) -> bool:
        """Whether planned analyses confirm: all as locked, before the first record."""
        return self.lock is not None and not self.differences

    def label(self, analysis: str) -> str:
        """Return "Confirmatory" or "Exploratory" for an analysis."""
        return "Confirmatory" if self.confirmatory and analysis in self.planned else "Exploratory"


def plan_status(study: StudyRecordings) -> PlanStatus:
    """Hold the locks in the recordings against recordings, analysis and environment."""
    locks: dict[str, PlanLock | None] = {}
    problems: list[Difference] = []
    for session in study.sessions:
        who = session.opened.participant
        try:
            locks[who] = lock_of(session)
        except StudyError as error:
            locks[who] = None
            problems.append(Difference("Plan lock", f"{who}: {error.message}"))
    known = [lock for lock in locks.values() if lock is not None]
    if not known:
        if not problems:
            text = "The recordings carry no plan lock: nothing was fixed before the first record."
            problems.append(Difference("Plan lock", text))
        return PlanStatus(None, tuple(problems), ())
    without = sorted(who for who, lock in locks.items() if lock is None)
    if without and not problems:
        text = f"Recorded without a plan lock: {', '.join(without)}."
        problems.append(Difference("Plan lock", text))
    lock = min(known, key=lambda each: datetime.fromisoformat(each.locked_utc))
    if any(not lock.same_plan(other) for other in known):
        text = "The recordings carry different plan locks: the plan was changed between sessions."
        problems.append(Difference("Plan lock", text))
    problems += _late(study, locks)
    problems += _before(study, lock)
    problems += _protocol(study, lock)
    problems += _analysis(lock)
    return PlanStatus(lock, tuple(problems), lock.planned)


def lock_of(session: Session) -> PlanLock | None:
    """Return the lock that a recording carries; None if it carries none.

    Raises:
        StudyError: what it carries is no lock.
    """
    data = session.recording.attachments.get(ATTACHMENT)
    return None if data is None else parse_lock(data, ATTACHMENT)


def _late(study: StudyRecordings, locks: Mapping[str, PlanLock | None]) -> list[Difference]:
    """Say which sessions began before the lock that they carry was made."""
    late = [
        session.opened.participant
        for session in study.sessions
        if (lock := locks[session.opened.participant]) is not None
        and _began_before(session.opened.started_utc, lock.locked_utc)
    ]
    if not late:
        return []
    return [Difference("Plan lock", f"Begun before the lock was made: {', '.join(late)}.")]


def _before(study: StudyRecordings, lock: PlanLock) -> list[Difference]:
    """Say which sessions that are not analysed began before the plan was fixed."""
    early = [
        f"{item.file} of {item.participant}"
        for item in study.set_aside
        if item.started_utc and _began_before(item.started_utc, lock.locked_utc)
    ]
    if not early:
        return []
    text = f"Not analysed, but recorded before the lock was made: {', '.join(early)}."
    return [Difference("Plan lock", text)]


def _began_before(started: str, locked: str) -> bool:
    """Return whether a session began before a lock was made, or its time cannot be read."""
    try:
        return datetime.fromisoformat(started) < datetime.fromisoformat(locked)
    except (ValueError, TypeError):
        return True


def _protocol(study: StudyRecordings, lock: PlanLock) -> list[Difference]:
    found: list[Difference] = []
    seen: set[str] = set()
    for session in study.sessions:
        opened = session.opened
        if opened.protocol_sha256 == lock.protocol_sha256 or opened.protocol_sha256 in seen:
            continue
        seen.add(opened.protocol_sha256)
        lines = _lines(lock.protocol_toml, opened.protocol_toml)
        text = f"The protocol recorded by {opened.participant} is not the one locked."
        found.append(Difference("Protocol", text, lines))
        rules = canonical_rules(session.protocol)
        if rules != lock.exclusions:
            pair = (f"locked: {lock.exclusions}", f"recorded: {rules}")
            found.append(Difference("Exclusions", "The exclusion rules differ.", pair))
    asked = {s.opened.questionnaires_json: s.opened.participant for s in study.sessions}
    for content, who in sorted(asked.items(), key=lambda pair: pair[1]):
        if hashlib.sha256(content.encode()).hexdigest() != lock.questionnaires_sha256:
            text = f"The questionnaires recorded by {who} are not those locked."
            found.append(Difference("Questionnaires", text))
    return found


def _analysis(lock: PlanLock) -> list[Difference]:
    found: list[Difference] = []
    changed = _changes(lock.analysis_files, analysis_files())
    if changed:
        text = f"{len(changed)} files of the analysis differ from those locked."
        found.append(Difference("Analysis code", text, tuple(changed[:MOST_LINES])))
    versions = _changes(lock.environment, environment(), values=True)
    if versions:
        text = "Other versions compute this report than were locked."
        found.append(Difference("Environment", text, tuple(versions)))
    return found


def _changes(
    locked: Mapping[str, str], now: Mapping[str, str], *, values: bool = False
) -> list[str]:
    lines = []
    for name in sorted({*locked, *now}):
        before, after = locked.get(name), now.get(name)
        if before == after:
            continue
        if values:
            lines.append(f"{name}: locked {before or 'absent'}, now {after or 'absent'}")
        else:
            how = "added" if before is None else "removed" if after is None else "changed"
            lines.append(f"{name}: {how}")
    return lines


def _lines(locked: str, recorded: str) -> tuple[str, ...]:
    lines: Sequence[str] = list(
        difflib.unified_diff(
            locked.splitlines(), recorded.splitlines(), "locked", "recorded", lineterm="", n=1
        )
    )
    if len(lines) > MOST_LINES:
        rest = len(lines) - MOST_LINES
        lines = [*lines[:MOST_LINES], f"... and {rest} lines more"]
    return tuple(lines)
