"""Events of what the participant agreed to, understood and answered; see `study.events.events`."""

from __future__ import annotations

from study.events.fields import Record, boolean, double, fixed64, record, sfixed32, string, strings


@record("event", "consent_given")
class ConsentGiven(Record):
    """The participant agreed, before anything was recorded."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    text_sha256: str = string(2, "SHA-256 of the text agreed to, hexadecimal")
    given_utc: str = string(3, "wall time of agreeing, ISO 8601, UTC")


@record("event", "practice_checked")
class PracticeChecked(Record):
    """A practice with a criterion is over."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    attempt: int = sfixed32(3, "number of the attempt, from 1")
    goals: int = sfixed32(4, "goals that the operated robot reached")
    needed: int = sfixed32(5, "goals that the protocol asks for")
    passed: bool = boolean(6, "whether that is enough")


@record("event", "comprehension_checked")
class ComprehensionChecked(Record):
    """A comprehension check was answered in full."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    attempt: int = sfixed32(2, "number of the attempt, from 1")
    correct: int = sfixed32(3, "right answers")
    asked: int = sfixed32(4, "questions")
    passed: bool = boolean(5, "whether all were right")
    wrong: tuple[str, ...] = strings(6, "ids of the questions answered wrong")


@record("event", "answer_changed")
class AnswerChanged(Record):
    """An answer was given, or another in its place, before confirmation."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    questionnaire: str = string(2, "name of the questionnaire")
    item: str = string(3, "id of the item")
    value: int = sfixed32(4, "the answer; for text its length")
    occasion: str = string(5, "when it was asked")
    latency_ns: int = fixed64(6, "from the screen's entry", unit="ns")


@record("event", "text_answered")
class TextAnswered(Record):
    """A free answer was confirmed."""

    t_ns: int = fixed64(1, "time of confirmation", unit="ns")
    questionnaire: str = string(2, "name of the questionnaire")
    item: str = string(3, "id of the item")
    text: str = string(4, "the answer; may be empty")
    phase: int = sfixed32(5, "codes.Phase")
    block: int = sfixed32(6, "number of the block within its phase, from 1")
    condition: str = string(7, "name of the condition")
    occasion: str = string(8, "when it was asked")
    latency_ns: int = fixed64(9, "from the screen's entry to the last change", unit="ns")


@record("event", "instrument_scored")
class InstrumentScored(Record):
    """The score of one scale of an instrument, by the rule in its file."""

    t_ns: int = fixed64(1, "time of confirmation", unit="ns")
    questionnaire: str = string(2, "name of the questionnaire")
    version: int = sfixed32(3, "version of its wording and scoring")
    scale: str = string(4, "name of the scale")
    score: float = double(5, "the score")
    phase: int = sfixed32(6, "codes.Phase")
    block: int = sfixed32(7, "number of the block within its phase, from 1")
    condition: str = string(8, "name of the condition")
    occasion: str = string(9, "when it was asked")
