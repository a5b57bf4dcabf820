"""Where tables of a protocol that are right by themselves do not go together."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from study.scorer_settings import CorrectionRoundPart, ScorerPart, scorer_problems
from study.seat_settings import NUMBER_ROW, KeyPart
from study.validation import Rules, nearest

if TYPE_CHECKING:
    from study.protocol import Condition, PhaseThreePart, PhaseTwoPart, QuestionnaireUse


def unknown_scorers_in(raw: Mapping[str, Any]) -> Iterator[str]:
    """Say which conditions name a scorer that there is none of, whatever else is wrong with them.

    Args:
        raw: the file, as plain values.
    """
    scorers, conditions = raw.get("scorers"), raw.get("conditions")
    if isinstance(scorers, dict) and isinstance(conditions, list):
        named = [each for each in conditions if isinstance(each, dict)]
        yield from _unknown_scorers(
            [(str(each.get("name", "")), str(each.get("scorer", ""))) for each in named],
            list(scorers),
        )


def _unknown_scorers(named: Iterable[tuple[str, str]], scorers: Sequence[str]) -> Iterator[str]:
    for condition, scorer in named:
        if scorer and scorer not in scorers:
            yield (
                f'conditions.{condition}.scorer: "{scorer}" is not under '
                f"[scorers]; {nearest(scorer, list(scorers))}"
                f"there: {', '.join(scorers) or 'none'}"
            )


def _conditions_once(conditions: Sequence[Condition]) -> Iterator[str]:
    names = [condition.name for condition in conditions]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f'conditions: the name "{name}" is given twice'


def _asked_once(questionnaires: Sequence[QuestionnaireUse]) -> Iterator[str]:
    asked = [use.name for use in questionnaires]
    for name in sorted({name for name in asked if asked.count(name) > 1}):
        yield f'questionnaires: "{name}" is listed twice; list it once with all its occasions'


def _order(phase_three: PhaseThreePart, conditions: Sequence[Condition]) -> Iterator[str]:
    if phase_three.order == "ab_ba" and len(conditions) != 2:
        yield (
            f'phase_three.order: "ab_ba" needs two conditions, {len(conditions)} given; '
            'use "latin_square"'
        )


def _scorers_there(
    conditions: Sequence[Condition], scorers: Mapping[str, ScorerPart]
) -> Iterator[str]:
    yield from _unknown_scorers([(each.name, each.scorer) for each in conditions], list(scorers))


def _scorers(
    scorers: Mapping[str, ScorerPart], part: CorrectionRoundPart | None, two: PhaseTwoPart
) -> Iterator[str]:
    yield from scorer_problems(scorers, part, two.trials)


def _accept(keys: KeyPart, conditions: Sequence[Condition]) -> Iterator[str]:
    """Only where something is suggested does the key that accepts have a meaning."""
    suggests = any(each.allocation == "suggested" for each in conditions)
    bound = keys.model_dump(exclude={"accept"})
    others = [*bound.pop("robots"), *bound.values()]
    if suggests and keys.accept in others:
        yield f'keys.accept: "{keys.accept}" is bound twice; each key does one thing'


def _robot_keys(
    keys: KeyPart,
    conditions: Sequence[Condition],
    two: PhaseTwoPart,
    correction: CorrectionRoundPart | None,
) -> Iterator[str]:
    fleets = [each.robots for each in conditions]
    largest = max([two.robots, *([correction.robots] if correction else []), *fleets])
    if len(keys.robots) < min(largest, NUMBER_ROW):
        yield (
            f"keys.robots: {len(keys.robots)} keys given for a fleet of {largest}; "
            "give one key a robot"
        )
    elif largest > len(keys.robots):
        # Numbers are typed then: see study.session.number_entry.
        named = {name: getattr(keys, name) for name in ("up", "down", "left", "right")}
        digits = [name for name, key in named.items() if key.isdecimal()]
        if digits:
            yield (
                f"keys.{digits[0]}: a digit given, but a fleet of {largest} is chosen from by "
                "typing numbers; bind another key"
            )


RULES: Rules = (
    (("conditions",), _conditions_once),
    (("questionnaires",), _asked_once),
    (("phase_three", "conditions"), _order),
    (("conditions", "scorers"), _scorers_there),
    (("scorers", "correction_round", "phase_two"), _scorers),
    (("keys", "conditions"), _accept),
    (("keys", "conditions", "phase_two", "correction_round"), _robot_keys),
)
