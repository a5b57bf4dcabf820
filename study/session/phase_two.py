"""The stages of phase two: choices, a correction round, fits, and what a gate may repeat."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence

from study.events.codes import Phase
from study.protocol import Protocol
from study.scorer_settings import CorrectionRoundPart
from study.session.plan import (
    PHASE_ONE_POLICY,
    FitPlan,
    PagesPlan,
    Place,
    PreparationPlan,
    StagePlan,
    TrialPlan,
    scorer_of,
)

SOURCES = ((Phase.TWO, ""),)


def phase_two(protocol: Protocol, *, warm: bool) -> Iterator[StagePlan]:
    """Return the stages of phase two in sequence.

    Args:
        protocol: the study.
        warm: whether scorers are fitted in the background before the last trial.
    """
    settings, round_ = protocol.phase_two, protocol.correction_round
    place = Place(Phase.TWO, block=1)
    warmed = [name for name, part in protocol.scorers.items() if part.warm_start and warm]
    yield PagesPlan("phase_two", place)
    trials = [_trial(protocol, number, settings.trials) for number in range(1, settings.trials + 1)]
    # Where a round follows, only its scorer is fitted before it.
    first = [name for name in warmed if round_ is None or name == round_.scorer]
    yield from _prepared(trials, first)
    if round_ is not None:
        name = round_.scorer
        yield _fit(place, name, warm=name in warmed)
        yield from _correction_round(round_, warmed)
    for name in protocol.scorers:
        attempt = 1 if protocol.scorers[name].gate else 0
        yield _fit(place, name, warm=name in warmed, attempt=attempt)
    yield from _repeats(protocol, warmed)


def _repeats(protocol: Protocol, warmed: Sequence[str]) -> Iterator[StagePlan]:
    """Return the further trials and fits, each passed over unless a gate asks for it."""
    gates = [part.gate for part in protocol.scorers.values() if part.gate]
    place, done = Place(Phase.TWO, block=1), protocol.phase_two.trials
    for attempt in range(2, max([gate.attempts for gate in gates], default=1) + 1):
        count = max(gate.repeat_trials for gate in gates if gate.attempts >= attempt)
        yield PagesPlan("repeat", place, repeat=attempt)
        trials = [
            dataclasses.replace(_trial(protocol, done + number, done + count), repeat=attempt)
            for number in range(1, count + 1)
        ]
        yield from _prepared(trials, warmed)
        done += count
        for name, part in protocol.scorers.items():
            fit = _fit(place, name, warm=name in warmed, attempt=attempt if part.gate else 0)
            yield dataclasses.replace(fit, repeat=attempt)


def _prepared(trials: Sequence[TrialPlan], warmed: Sequence[str]) -> Iterator[StagePlan]:
    """Return trials with the fits in the background that start before the last of them."""
    *before, last = trials
    yield from before
    if before:
        for name in warmed:
            yield PreparationPlan(
                last.place, scorer_of(name), name, SOURCES, repeat=last.repeat, needs=last.needs
            )
    yield last


def _fit(place: Place, name: str, *, warm: bool, attempt: int = 0) -> FitPlan:
    return FitPlan(place, scorer_of(name), "scorer", name, SOURCES, attempt=attempt, warm=warm)


def _trial(protocol: Protocol, number: int, trials: int) -> TrialPlan:
    settings = protocol.phase_two
    return TrialPlan(
        place=Place(Phase.TWO, block=1),
        trial=number,
        trials=trials,
        robots=settings.robots,
        timesteps=settings.trial_timesteps,
        allocation="manual",
        view="tiles",
        dwell=0,
        policy_id=PHASE_ONE_POLICY,
        scorer_id="",
        ends_with_robot=False,
        starts_key=(Phase.TWO, number),
        scored=True,
    )


def _correction_round(settings: CorrectionRoundPart, warmed: Sequence[str]) -> Iterator[StagePlan]:
    """Return the round's stages, passed over if its scorer could not be fitted."""
    place = Place(Phase.TWO, block=2)
    artefact = scorer_of(settings.scorer)
    yield PagesPlan("correction_round", place, needs=artefact)
    trials = [
        TrialPlan(
            place=place,
            trial=number,
            trials=settings.trials,
            robots=settings.robots,
            timesteps=settings.trial_timesteps,
            allocation="correction_round",
            view="tiles",
            dwell=settings.dwell,
            policy_id=PHASE_ONE_POLICY,
            scorer_id=artefact,
            ends_with_robot=False,
            starts_key=(Phase.TWO, place.block, number),
            scored=True,
            needs=artefact,
        )
        for number in range(1, settings.trials + 1)
    ]
    yield from _prepared(trials, warmed)
