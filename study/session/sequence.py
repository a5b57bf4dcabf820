"""The sequence of stages that a protocol and an order of conditions give."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

from study.events.codes import Phase
from study.protocol import Condition, Protocol
from study.session.phase_two import phase_two
from study.session.plan import (
    PHASE_ONE_POLICY,
    UNIFORM_RANDOM,
    BreakPlan,
    CheckPlan,
    FitPlan,
    PagesPlan,
    Place,
    RevealPlan,
    StagePlan,
    SurveyPlan,
    TrialPlan,
    policy_of,
    scorer_of,
)
from study.session.rules import CURRENT, WARM_STARTS

NO_LIMIT = 1_000_000
"""Timesteps of a run that ends with its robot."""


def stage_plans(
    protocol: Protocol, order: tuple[str, ...], rules: int = CURRENT
) -> tuple[StagePlan, ...]:
    """Return all stages in sequence.

    Args:
        protocol: the study.
        order: conditions of phase three in the order run.
        rules: version of the session's rules.
    """
    before, after = Place(Phase.PRACTICE), Place(Phase.FOUR)
    stages: list[StagePlan] = [PagesPlan("welcome", before)]
    stages += _surveys(protocol, before, "at_start")
    if protocol.practice.timesteps:
        stages.append(PagesPlan("practice", before))
        stages += [
            _practice(protocol, attempt) for attempt in range(1, protocol.practice.attempts + 1)
        ]
    if protocol.comprehension:
        stages.append(CheckPlan(before, attempt=1))
        for attempt in range(2, protocol.comprehension.explanations + 2):
            stages += [PagesPlan("explanation", before), CheckPlan(before, attempt)]
    stages += _phase_one(protocol)
    stages += phase_two(protocol, warm=rules >= WARM_STARTS)
    for block, name in enumerate(order, start=1):
        if protocol.breaks:
            stages.append(BreakPlan(Place(Phase.THREE, block, name)))
        stages += _phase_three_block(protocol, protocol.condition(name), block)
    if protocol.phase_four:
        stages += _phase_four(protocol)
    stages += _surveys(protocol, after, "at_end")
    if protocol.debrief:
        stages.append(PagesPlan("debrief", after))
    stages.append(PagesPlan("thanks", after))
    return tuple(stages)


def _surveys(protocol: Protocol, place: Place, occasion: str) -> list[SurveyPlan]:
    asked = [use.name for use in protocol.questionnaires if occasion in use.when]
    return [SurveyPlan(place, name, occasion) for name in asked]


def _practice(protocol: Protocol, attempt: int) -> TrialPlan:
    return TrialPlan(
        place=Place(Phase.PRACTICE),
        trial=1,
        trials=1,
        robots=1,
        timesteps=protocol.practice.timesteps,
        allocation="manual",
        view="tiles",
        dwell=0,
        policy_id=UNIFORM_RANDOM,
        scorer_id="",
        ends_with_robot=False,
        starts_key=(Phase.PRACTICE,) if attempt == 1 else (Phase.PRACTICE, attempt),
        scored=False,
        goals_needed=protocol.practice.goals,
        attempt=attempt,
        attempts=protocol.practice.attempts,
    )


def _phase_one(protocol: Protocol) -> Iterator[StagePlan]:
    place = Place(Phase.ONE, block=1)
    yield PagesPlan("phase_one", place)
    episodes = protocol.phase_one.episodes
    each = protocol.phase_one.refit == "each_episode"
    for episode in range(1, episodes + 1):
        refitted = each and episode > 1
        yield TrialPlan(
            place=place,
            trial=episode,
            trials=episodes,
            robots=1,
            timesteps=protocol.phase_one.episode_timesteps or NO_LIMIT,
            allocation="correction",
            view="tiles",
            dwell=0,
            policy_id=PHASE_ONE_POLICY if refitted else UNIFORM_RANDOM,
            scorer_id="",
            ends_with_robot=True,
            starts_key=(Phase.ONE, episode),
            scored=True,
        )
        if each or episode == episodes:
            yield FitPlan(place, PHASE_ONE_POLICY, "policy", "policy", ((Phase.ONE, ""),))


def _phase_three_block(protocol: Protocol, condition: Condition, block: int) -> Iterator[StagePlan]:
    place = Place(Phase.THREE, block=block, condition=condition.name)
    settings = protocol.phase_three
    yield PagesPlan("phase_three", place)
    unpaired = () if settings.paired_starts else (block,)
    first = TrialPlan(
        place=place,
        trial=1,
        trials=settings.trials,
        robots=condition.robots,
        timesteps=settings.trial_timesteps,
        allocation=condition.allocation,
        view=condition.view,
        dwell=condition.dwell,
        policy_id=PHASE_ONE_POLICY,
        scorer_id=scorer_of(condition.scorer) if condition.scorer else "",
        ends_with_robot=False,
        starts_key=(Phase.THREE, 1, *unpaired),
        scored=True,
    )
    if settings.practice_timesteps:
        yield dataclasses.replace(
            first,
            place=dataclasses.replace(place, phase=Phase.PRACTICE),
            trials=1,
            timesteps=settings.practice_timesteps,
            starts_key=(Phase.PRACTICE, Phase.THREE, block),
            scored=False,
        )
    every = protocol.breaks.every_trials if protocol.breaks else 0
    for trial in range(1, settings.trials + 1):
        if every and trial > 1 and (trial - 1) % every == 0:
            yield BreakPlan(place)
        yield dataclasses.replace(first, trial=trial, starts_key=(Phase.THREE, trial, *unpaired))
    before = _surveys(protocol, place, "before_reveal")
    after = _surveys(protocol, place, "after_reveal")
    yield from before
    yield RevealPlan(place, surveys_follow=bool(after))
    yield from after


def _phase_four(protocol: Protocol) -> Iterator[StagePlan]:
    settings = protocol.phase_four
    if settings is None:
        return
    # The phase-one policy is evaluated too: what a condition's data added is the difference.
    policies: list[tuple[str, str]] = [("", PHASE_ONE_POLICY)]
    base = ((Phase.ONE, ""),) if settings.training == "phase_one_and_condition" else ()
    for block, condition in enumerate(protocol.conditions, start=1):
        place = Place(Phase.FOUR, block=block + 1, condition=condition.name)
        artefact = policy_of(condition.name)
        policies.append((condition.name, artefact))
        yield FitPlan(place, artefact, "policy", "policy", (*base, (Phase.THREE, condition.name)))
    for block, (name, artefact) in enumerate(policies, start=1):
        for trial in range(1, settings.trials + 1):
            yield TrialPlan(
                place=Place(Phase.FOUR, block=block, condition=name),
                trial=trial,
                trials=settings.trials,
                robots=settings.robots,
                timesteps=settings.trial_timesteps,
                allocation="none",
                view="tiles",
                dwell=0,
                policy_id=artefact,
                scorer_id="",
                ends_with_robot=False,
                starts_key=(Phase.FOUR, trial),
                scored=True,
            )
