"""The tables of a protocol about the participant's seat.

What is recorded of what is seen there is one of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from study.rules import Part, right, right_settings
from study.validation import NAME_PATTERN

Name = Annotated[str, Field(pattern=NAME_PATTERN)]
Failure = Literal["go_on", "end"]
Paragraph = Annotated[str, Field(min_length=1, max_length=1200)]


class ConsentPart(Part):
    """What is agreed to before anything is recorded."""

    title: str = Field(default="Before we start", min_length=1, max_length=80, description="title")
    paragraphs: tuple[Paragraph, ...] = Field(
        min_length=1, max_length=8, description="the text agreed to"
    )

    def text(self) -> str:
        """Return the text as it is hashed: title and paragraphs, an empty line between."""
        return "\n\n".join([self.title, *self.paragraphs])


class ComprehensionQuestion(Part):
    """One question about the instructions."""

    id: Name = Field(description="id in the data")
    text: str = Field(min_length=1, max_length=200, description="the question")
    options: tuple[Annotated[str, Field(min_length=1, max_length=80)], ...] = Field(
        min_length=2, max_length=5, description="the answers offered"
    )
    correct: int = Field(ge=1, le=5, description="number of the right one, from 1")
    explanation: str = Field(
        min_length=1, max_length=400, description="what is explained again after a wrong answer"
    )

    def _correct_is_offered(self) -> Iterator[str]:
        if self.correct > len(self.options):
            yield f"correct: {self.correct} given; there are {len(self.options)} options"

    rules = (_correct_is_offered,)


class ComprehensionPart(Part):
    """Questions before phase one; what was answered wrong is explained again."""

    questions: tuple[ComprehensionQuestion, ...] = Field(
        min_length=1, max_length=6, description="the questions"
    )
    explanations: int = Field(
        default=2, ge=0, le=2, description="how often it is explained and asked again"
    )
    on_failure: Failure = Field(
        default="go_on", description="what happens after that; recorded as a deviation"
    )


class BreakPart(Part):
    """Rests with a timer: between blocks, and within long ones."""

    seconds: int = Field(ge=1, le=3600, description="suggested length, s")
    minimum_seconds: int = Field(default=0, ge=0, le=3600, description="shortest length, s")
    every_trials: int = Field(
        default=0, ge=0, le=1000, description="trials between breaks in a block; 0: none within"
    )


class SwitchingPart(Part):
    """How an automatic switch is announced, and what follows it."""

    cue_seconds: float = Field(
        default=0.0, ge=0, le=60, description="how long before it is announced, s; 0: the ring only"
    )
    landing_seconds: float = Field(
        default=1.2, ge=0, le=10, description="how long the landing is marked, s"
    )
    grace_seconds: float = Field(
        default=0.0, ge=0, le=10, description="demonstrations so soon after it are flagged, s"
    )


class DebriefPart(Part):
    """What is told at the end."""

    title: str = Field(
        default="What this was about", min_length=1, max_length=80, description="title"
    )
    paragraphs: tuple[Paragraph, ...] = Field(min_length=1, max_length=8, description="the text")


NUMBER_ROW = 12
"""Keys in the row above the letters: larger fleets are chosen from by typing numbers."""
KEY_NAMES = (
    *("up", "down", "left", "right", "tab", "space", "return", "backspace", "escape", "-", "="),
    *"0123456789",
    *"abcdefghijklmnopqrstuvwxyz",
)
"""Keys that can be bound: all that the window tells apart, but F12, which stops robots."""
DIRECTIONS = ("left", "up", "down", "right")
"""What a protocol binds keys to; all else that a task names is a key."""
_CHECKED_LATER = ("robots", "accept")


class KeyPart(Part):
    """Which key does what."""

    up: str = Field(default="up", description="the action that the task binds to up")
    down: str = Field(default="down", description="the action bound to down")
    left: str = Field(default="left", description="the action bound to left")
    right: str = Field(default="right", description="the action bound to right")
    next_robot: str = Field(default="tab", description="choose the next robot")
    accept: str = Field(default="space", description="accept a suggestion")
    confirm: str = Field(default="return", description="go on, confirm")
    back: str = Field(default="backspace", description="go back")
    pause: str = Field(default="escape", description="pause")
    robots: tuple[str, ...] = Field(
        default=("1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-", "="),
        max_length=48,
        description="keys that choose robots 1, 2, ...",
    )

    def _distinct(self) -> Iterator[str]:
        bound = right_settings(self)
        keys = [key for name, key in bound.items() if name not in _CHECKED_LATER]
        keys += right(bound.get("robots", ()))
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            yield f"bound twice: {', '.join(twice)}; each key does one thing"

    rules = (_distinct,)


class RecordingPart(Part):
    """What a recording holds beside inputs and events."""

    pictures: Literal["none", "jpeg"] = Field(
        default="none",
        description="whether the pictures that the task takes of its robots are recorded, and how "
        "they are compressed; a replay then shows them without the task",
    )
