"""The tables of a protocol about what is fitted: policy, scorers, their gates, correction round."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal

from pydantic import Field

from study.rules import Part
from study.seat_settings import Name

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

    def _fewer_offered(self) -> Iterator[str]:
        if self.offered >= self.robots:
            yield (
                f"offered: {self.offered} of {self.robots} robots given; offer fewer than there are"
            )

    def _longer_than_dwell(self) -> Iterator[str]:
        if self.trial_timesteps <= self.dwell:
            yield (
                f"trial_timesteps: {self.trial_timesteps} given; nothing is offered "
                f"before the dwell of {self.dwell} is over"
            )

    rules = (_fewer_offered, _longer_than_dwell)
