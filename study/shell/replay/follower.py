"""Feeds a recording's inputs to a session, and compares what follows with what was recorded."""

from __future__ import annotations

import dataclasses

import numpy as np

from study.events.events import Event
from study.events.inputs import Input
from study.recording.reader import RawRecord
from study.recording.wire import decode, encode
from study.session.context import Step
from study.session.session import Session


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Fed:
    """An input that was fed, with what followed."""

    given: Input
    step: Step


class Follower:
    """Takes a recording's inputs and events in their order.

    Attributes:
        session: what the inputs are fed to.
        inputs: how many were fed.
        compared: how many events were compared.
        difference: the first disagreement, in words; empty if none. Nothing is fed after it.
    """

    def __init__(self) -> None:
        self.session = Session()
        self.inputs = 0
        self.compared = 0
        self.difference = ""
        self._expected: list[tuple[str, bytes]] = []

    def take(self, raw: RawRecord) -> Fed | None:
        """Feed an input, or compare an event.

        Returns:
            What was fed; None for an event, and from the first disagreement on.

        Raises:
            RecordingError: the input opens what is no session.
        """
        if self.difference:
            return None
        if raw.topic.startswith("event/"):
            self._compare(raw)
            return None
        if self._expected:
            self.difference = f"record {raw.sequence}: {self._expected[0][0]} is missing before it"
            return None
        given: Input = decode(raw.topic, raw.data)  # type: ignore[assignment]
        step = self.session.handle(given)
        self.inputs += 1
        self._expected = [(event.topic, encode(event)) for event in step.events]
        return Fed(given, step)

    def end(self, *, complete: bool) -> None:
        """Compare the end: a recording that is complete lacks no event."""
        if not self.difference and self._expected and complete:
            self.difference = f"{self._expected[0][0]} is missing at the end"

    def _compare(self, raw: RawRecord) -> None:
        if not self._expected:
            self.difference = f"record {raw.sequence}: {raw.topic} follows from no input"
            return
        topic, data = self._expected.pop(0)
        self.compared += 1
        if (topic, data) != (raw.topic, raw.data):
            self.difference = _difference(raw.sequence, raw.topic, raw.data, topic, data)


def _difference(sequence: int, topic: str, data: bytes, expected: str, replayed: bytes) -> str:
    if topic != expected:
        return f"record {sequence}: {topic} recorded, {expected} replayed"
    ours: Event = decode(topic, replayed)  # type: ignore[assignment]
    theirs: Event = decode(topic, data)  # type: ignore[assignment]
    fields = [
        field.name
        for field in dataclasses.fields(ours)
        if not np.array_equal(
            np.asarray(getattr(ours, field.name)), np.asarray(getattr(theirs, field.name))
        )
    ]
    return f"record {sequence}: {topic} differs in {', '.join(fields) or 'its encoding'}"
