"""Where tables of a protocol do not go together: each rule looks at the whole protocol."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from study.rules import known_names, right, right_settings
from study.scorer_settings import LEAST_GATED_TRIALS, MANUAL
from study.seat_settings import NUMBER_ROW
from study.validation import nearest

if TYPE_CHECKING:
    from study.protocol import Protocol


def _conditions_once(protocol: Protocol) -> Iterator[str]:
    names = [condition.name for condition in right(protocol.conditions, "name")]
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield f'conditions: the name "{name}" is given twice'


def _asked_once(protocol: Protocol) -> Iterator[str]:
    asked = [use.name for use in right(protocol.questionnaires, "name")]
    for name in sorted({name for name in asked if asked.count(name) > 1}):
        yield f'questionnaires: "{name}" is listed twice; list it once with all its occasions'


def _order(protocol: Protocol) -> Iterator[str]:
    conditions = protocol.conditions
    if protocol.phase_three.order == "ab_ba" and len(conditions) != 2:
        yield (
            f'phase_three.order: "ab_ba" needs two conditions, {len(conditions)} given; '
            'use "latin_square"'
        )


def _scorers_there(protocol: Protocol) -> Iterator[str]:
    scorers = known_names(protocol.scorers)
    for number, condition in enumerate(protocol.conditions, start=1):
        scorer = "scorer" in right_settings(condition) and condition.scorer
        if scorer and scorer not in scorers:
            yield (
                f'conditions.{right_settings(condition).get("name", number)}.scorer: "{scorer}" '
                f"is not under [scorers]; {nearest(scorer, scorers)}"
                f"there: {', '.join(scorers) or 'none'}"
            )


def _enough_to_gate(protocol: Protocol) -> Iterator[str]:
    extra, trials = protocol.correction_round, protocol.phase_two.trials
    if trials + (extra.trials if extra else 0) < LEAST_GATED_TRIALS:
        for name, scorer in protocol.scorers.items():
            if right_settings(scorer).get("gate") is not None:
                yield (
                    f"scorers.{name}.gate: needs at least {LEAST_GATED_TRIALS} trials in phase "
                    f"two, to hold one out; {trials} given"
                )


def _fallbacks_there(protocol: Protocol) -> Iterator[str]:
    known = known_names(protocol.scorers)
    for name, scorer in protocol.scorers.items():
        gate = right_settings(scorer).get("gate")
        others = [other for other in known if other != name]
        for fallback in (
            () if gate is None else (each.fallback for each in right([gate], "fallback"))
        ):
            if fallback not in (MANUAL, *others):
                yield (
                    f'scorers.{name}.gate.fallback: "{fallback}" given; '
                    f"{nearest(fallback, [MANUAL, *others])}"
                    f'"{MANUAL}" or another scorer: {", ".join(others) or "there is none"}'
                )


def _corrected_scorer(protocol: Protocol) -> Iterator[str]:
    part, scorers = protocol.correction_round, known_names(protocol.scorers)
    if part is not None and part.scorer not in scorers:
        yield (
            f'correction_round.scorer: "{part.scorer}" is not under [scorers]; '
            f"{nearest(part.scorer, scorers)}there: {', '.join(scorers) or 'none'}"
        )


def _accept(protocol: Protocol) -> Iterator[str]:
    """Only where something is suggested does the key that accepts have a meaning."""
    allocations = [each.allocation for each in right(protocol.conditions, "allocation")]
    bound = right_settings(protocol.keys)
    accept = protocol.keys.accept
    others = [*bound.pop("robots", ()), *(key for name, key in bound.items() if name != "accept")]
    if "suggested" in allocations and accept in others:
        yield f'keys.accept: "{accept}" is bound twice; each key does one thing'


def _robot_keys(protocol: Protocol) -> Iterator[str]:
    keys, extra = protocol.keys, protocol.correction_round
    fleets = [each.robots for each in right(protocol.conditions, "robots")]
    fleets += [each.robots for each in right([protocol.phase_two], "robots")]
    fleets += [] if extra is None else [each.robots for each in right([extra], "robots")]
    # Of those that are right: one that is wrong makes the largest no smaller.
    largest = max(fleets, default=0)
    if len(keys.robots) < min(largest, NUMBER_ROW):
        yield (
            f"keys.robots: {len(keys.robots)} keys given for a fleet of {largest}; "
            "give one key a robot"
        )
    elif largest > len(keys.robots):
        # Numbers are typed then: see study.session.number_entry.
        bound = right_settings(keys)
        named = {name: bound[name] for name in ("up", "down", "left", "right") if name in bound}
        digits = [name for name, key in named.items() if key.isdecimal()]
        if digits:
            yield (
                f"keys.{digits[0]}: a digit given, but a fleet of {largest} is chosen from by "
                "typing numbers; bind another key"
            )


RULES = (
    _conditions_once,
    _asked_once,
    _order,
    _scorers_there,
    _enough_to_gate,
    _fallbacks_there,
    _corrected_scorer,
    _accept,
    _robot_keys,
)
"""All of them."""
