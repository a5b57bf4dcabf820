"""The tables of a protocol about what is fitted: policy, scorers, their gates, correction round."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal

from pydantic import Field

from study.seat_settings import Name, Part
from study.validation import nearest

MANUAL = "manual"
"""What a gate's ``fallback`` says if the participant is to choose."""
LEAST_GATED_TRIALS = 3
"""Trials without which nothing can be held out."""


class MemberPart(Part):
    """A policy or scorer with its hyper-parameters."""

    name: str = Field(description="name of the policy or scorer")
    fit_budget_seconds: float = Field(default=30.0, gt=0, description="when a fit is given up, s")
    parameters: dict[str, Any] = Field(default_factory=dict, description="hyper-parameters")


class GatePart(Part):
    """What a fitted scorer must reach on held-out trials, and what happens if it does not."""

    min_likelihood_gain: float = Field(
        default=0.0,
        description="least held-out log-likelihood a choice above that of chance, nats",
    )
    min_top1_gain: float = Field(
        default=0.0,
        ge=-1,
        le=1,
        description="least share of held-out choices named by the highest score, above chance",
    )
    max_calibration_error: float = Field(
        default=1.0,
        ge=0,
        le=1,
        description="largest expected calibration error on held-out choices",
    )
    attempts: int = Field(
        default=1,
        ge=1,
        le=5,
        description="how often it is fitted while it does not pass; before each fit after the "
        "first, phase two goes on for some trials",
    )
    repeat_trials: int = Field(
        default=2, ge=1, le=100, description="trials of phase two before each further attempt"
    )
    on_failure: Literal["go_on", "fallback", "end"] = Field(
        default="go_on", description="what happens if it never passes; recorded as a deviation"
    )
    fallback: str = Field(
        default=MANUAL,
        description='what takes its place: another name under [scorers], or "manual": the '
        "participant chooses",
    )


class ScorerPart(MemberPart):
    """A scorer with its hyper-parameters and its gate."""

    warm_start: bool = Field(
        default=True,
        description="whether it is fitted in the background before the last trial, so that the "
        "fit after it goes on from there and nobody waits",
    )
    gate: GatePart | None = None


class CorrectionRoundPart(Part):
    """Further choices between phases two and three, in a larger fleet that the scorer drives."""

    scorer: Name = Field(description="which of [scorers] drives, as fitted to phase two")
    robots: int = Field(ge=2, le=48, description="fleet size, n")
    offered: int = Field(ge=2, le=48, description="robots offered at a time, drawn at random")
    trials: int = Field(ge=1, le=1000, description="trials")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")
    dwell: int = Field(
        ge=1,
        le=10_000,
        description="timesteps for which the robot chosen by the scorer is operated, between "
        "two offers",
    )
    offer_timesteps: int = Field(
        ge=1,
        le=10_000,
        description="timesteps for which robots are offered and the participant chooses",
    )


def scorer_problems(
    scorers: Mapping[str, ScorerPart], part: CorrectionRoundPart | None, trials: int
) -> Iterator[str]:
    """Say where gates and correction round do not go with the rest of a protocol.

    Args:
        scorers: by name.
        part: the correction round, if there is one.
        trials: of phase two.
    """
    known = list(scorers)
    for name, scorer in scorers.items():
        gate = scorer.gate
        if gate is None:
            continue
        if trials + (part.trials if part else 0) < LEAST_GATED_TRIALS:
            yield (
                f"scorers.{name}.gate: needs at least {LEAST_GATED_TRIALS} trials in phase two, "
                f"to hold one out; {trials} given"
            )
        others = [other for other in known if other != name]
        if gate.fallback not in (MANUAL, *others):
            yield (
                f'scorers.{name}.gate.fallback: "{gate.fallback}" given; '
                f"{nearest(gate.fallback, [MANUAL, *others])}"
                f'"{MANUAL}" or another scorer: {", ".join(others) or "there is none"}'
            )
    if part is None:
        return
    if part.scorer not in scorers:
        yield (
            f'correction_round.scorer: "{part.scorer}" is not under [scorers]; '
            f"{nearest(part.scorer, known)}there: {', '.join(known) or 'none'}"
        )
    if part.offered >= part.robots:
        yield (
            f"correction_round.offered: {part.offered} of {part.robots} robots given; "
            "offer fewer than there are"
        )
    if part.trial_timesteps <= part.dwell:
        yield (
            f"correction_round.trial_timesteps: {part.trial_timesteps} given; nothing is offered "
            f"before the dwell of {part.dwell} is over"
        )
