"""What the register says of a participant, as plain values."""

from __future__ import annotations

import dataclasses
from datetime import UTC, datetime
from typing import Literal

from study.enrolment.process_identity import ProcessIdentity

State = Literal["reserved", "running", "complete", "dropped", "excluded", "withdrawn"]
"""Where a participant stands. ``running`` without a living process was interrupted."""

HOLDING: tuple[State, ...] = ("reserved", "running", "complete")
"""States that hold a slot: these orders are balanced."""


@dataclasses.dataclass(frozen=True, slots=True)
class Participant:
    """One participant of one study.

    Attributes:
        study: name of the study.
        pseudonym: the only name there is.
        state: where the participant stands.
        slot: place in the plan, from 1; those of pilots are counted apart; 0 if none is held.
        order: conditions in the order run.
        pilot: whether the session is none of the study's own.
        visits: sessions begun, and the one that a slot is reserved for.
        reason: why dropped or excluded, or what the last session came to.
        note: the experimenter's.
        changed_utc: when the state last changed, ISO 8601.
        lease: the process that runs the session; None if none does.
        interrupted: whether a session runs that no living process conducts.
    """

    study: str
    pseudonym: str
    state: State
    slot: int
    order: tuple[str, ...]
    pilot: bool = False
    visits: int = 1
    reason: str = ""
    note: str = ""
    changed_utc: str = ""
    lease: ProcessIdentity | None = None
    interrupted: bool = False

    @property
    def shown_state(self) -> str:
        """The state in words of the table."""
        return "interrupted" if self.interrupted else self.state

    @property
    def sessions(self) -> int:
        """Sessions begun: of one that is reserved nothing is recorded yet."""
        return self.visits - (self.state == "reserved")


@dataclasses.dataclass(frozen=True, slots=True)
class Happening:
    """One line of a participant's history.

    Attributes:
        utc: when, ISO 8601.
        what: one word: "reserved", "running", "complete", "noted", ...
        detail: the rest in words.
    """

    utc: str
    what: str
    detail: str


def now_utc() -> str:
    """Return the wall time, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")
