"""A study as a TOML file: the model that it is validated against.

`parse_protocol` checks everything that the file alone decides. Names of tasks, policies,
scorers and questionnaires and their parameters are checked by `study.loading`, which may
import them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any, Literal

from pydantic import Field

from study.disagreements import RULES
from study.errors import ProtocolError
from study.messages import SOURCE
from study.rules import Part
from study.scorer_settings import CorrectionRoundPart, MemberPart, ScorerPart
from study.seat_settings import (
    BreakPart,
    ComprehensionPart,
    ConsentPart,
    DebriefPart,
    Failure,
    KeyPart,
    Name,
    RecordingPart,
    SwitchingPart,
)
from study.toml_text import parse_toml
from study.validation import checked, missing_paths

Allocation = Literal["manual", "suggested", "assisted"]
View = Literal["tiles", "operated_only", "enlarged"]
Occasion = Literal["at_start", "before_reveal", "after_reveal", "at_end"]


class StudyPart(Part):
    """What the study is."""

    name: Name = Field(description="short name; names files")
    title: str = Field(min_length=1, max_length=120, description="title of the report")
    description: str = Field(default="", max_length=2000, description="one paragraph")
    language: str = Field(
        default=SOURCE, description="language of what participants read in the window"
    )
    planned_participants: int = Field(ge=1, le=10_000, description="planned participants")


class TimingPart(Part):
    """How fast the world goes."""

    timesteps_per_second: float = Field(
        gt=0, le=100, description="task steps a second (8-10 for people)"
    )
    countdown_seconds: int = Field(
        default=0, ge=0, le=10, description="countdown before each trial, s; 0 for none"
    )


class TaskPart(Part):
    """The robots' world."""

    name: str = Field(description="name of the task")
    on_end: Literal["reset", "stay"] = Field(
        default="reset", description="whether a robot that ended starts anew or stays"
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="see the task")


class PracticePart(Part):
    """Unscored driving before phase one."""

    timesteps: int = Field(ge=0, le=100_000, description="longest length; 0 for none")
    goals: int = Field(
        default=0, ge=0, le=100, description="goals that end it at once; 0: it lasts its length"
    )
    attempts: int = Field(
        default=1, ge=1, le=5, description="how often it is run while the goals are not reached"
    )
    on_failure: Failure = Field(
        default="go_on", description="what happens if they never are; recorded as a deviation"
    )


class PhaseOnePart(Part):
    """One robot, corrected by the participant."""

    episodes: int = Field(ge=1, le=1000, description="episodes")
    episode_timesteps: int = Field(
        default=0, ge=0, le=100_000, description="an episode is over then; 0: when the task's is"
    )
    initial_policy: Literal["uniform_random"] = Field(
        default="uniform_random", description="policy of the first episode"
    )
    refit: Literal["each_episode", "at_end"] = Field(
        default="each_episode", description="when the policy is fitted anew"
    )


class PhaseTwoPart(Part):
    """A small fleet with free choice."""

    robots: int = Field(ge=2, le=48, description="fleet size, n")
    trials: int = Field(ge=1, le=1000, description="trials")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")


class PhaseThreePart(Part):
    """The large fleet under each condition."""

    trials: int = Field(ge=1, le=1000, description="trials per condition")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")
    order: Literal["ab_ba", "latin_square", "fixed"] = Field(
        description="order design of the conditions"
    )
    paired_starts: bool = Field(
        default=True, description="the same start states in each condition's k-th trial"
    )
    practice_timesteps: int = Field(
        default=0,
        ge=0,
        le=100_000,
        description="unscored practice of its own interface that opens each block; 0 for none",
    )


class PhaseFourPart(Part):
    """The retrained policies alone."""

    robots: int = Field(ge=1, le=1000, description="robots evaluated at once")
    trials: int = Field(ge=1, le=1000, description="trials per policy")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")
    training: Literal["phase_one_and_condition", "phase_three_only"] = Field(
        default="phase_one_and_condition", description="which demonstrations are used"
    )


class Condition(Part):
    """A named combination of allocation, scorer, fleet size, dwell and view."""

    name: Name = Field(description="name in the data")
    label: str = Field(min_length=1, max_length=40, description="name in reports")
    allocation: Allocation = Field(description="who decides which robot is operated")
    view: View = Field(description="what the participant sees")
    robots: int = Field(ge=2, le=48, description="fleet size, n")
    scorer: str = Field(default="", description="which of [scorers] decides; empty for none")
    dwell: int = Field(
        default=0,
        ge=0,
        le=10_000,
        description="timesteps between automatic switches; with suggested, for which a "
        "suggestion stays (0 renews it at every timestep)",
    )

    def _scorer_and_dwell(self) -> Iterator[str]:
        if self.allocation == "assisted" and (not self.scorer or not self.dwell):
            yield "an assisted condition needs a scorer and a dwell of at least 1"
        if self.allocation == "suggested" and not self.scorer:
            yield "a suggested condition needs a scorer"
        if self.allocation == "manual" and self.dwell:
            yield "a manual condition has no dwell; remove it"

    def _shows_all(self) -> Iterator[str]:
        if self.allocation != "assisted" and self.view == "operated_only":
            yield f'a {self.allocation} condition shows all robots: view = "tiles" or "enlarged"'

    rules = (_scorer_and_dwell, _shows_all)


class QuestionnaireUse(Part):
    """A questionnaire and when it is asked: around each block's reveal, or once."""

    name: str = Field(description="file stem under questionnaires/")
    when: tuple[Occasion, ...] = Field(min_length=1, description="occasions")


class Exclusion(Part):
    """A rule by which analysis leaves out a participant."""

    name: Name = Field(description="name of the rule")
    measure: Literal["complete_trials", "choices", "demonstrations"] = Field(
        description="what is counted for each participant"
    )
    at_least: float = Field(description="participants below this are left out")
    reason: str = Field(min_length=1, max_length=400, description="why")


class TrialExclusion(Part):
    """A rule by which analysis leaves out single trials that were disturbed."""

    name: Name = Field(description="name of the rule")
    deviations: tuple[
        Literal["paused", "recording_interrupted", "resumed", "robot_stopped"], ...
    ] = Field(min_length=1, description="a trial in which one of these happened is left out")
    reason: str = Field(min_length=1, max_length=400, description="why")


class AnalysisPart(Part):
    """Analyses planned before the data are seen."""

    primary: Literal["team_reward"] = Field(default="team_reward", description="primary measure")
    planned: tuple[
        Literal["rm_anova", "pooled_trials", "likert", "instruments", "phase_four", "heat_maps"],
        ...,
    ] = Field(min_length=1, description="what the report computes")
    equivalence_bound: float | None = Field(
        default=None, gt=0, description="smallest difference of interest, points"
    )


class Protocol(Part):
    """A whole study."""

    format: Literal[1] = Field(description="version of this file format")
    study: StudyPart
    timing: TimingPart
    task: TaskPart
    policy: MemberPart
    scorers: dict[Name, ScorerPart] = Field(default_factory=dict)
    practice: PracticePart
    phase_one: PhaseOnePart
    phase_two: PhaseTwoPart
    correction_round: CorrectionRoundPart | None = None
    phase_three: PhaseThreePart
    phase_four: PhaseFourPart | None = None
    conditions: tuple[Condition, ...] = Field(min_length=1)
    questionnaires: tuple[QuestionnaireUse, ...] = ()
    keys: KeyPart = KeyPart()
    consent: ConsentPart | None = None
    comprehension: ComprehensionPart | None = None
    breaks: BreakPart | None = None
    switching: SwitchingPart = SwitchingPart()
    debrief: DebriefPart | None = None
    recording: RecordingPart = RecordingPart()
    exclusions: tuple[Exclusion, ...] = ()
    trial_exclusions: tuple[TrialExclusion, ...] = ()
    analysis: AnalysisPart
    assumptions: dict[str, str] = Field(
        default_factory=dict, description="key path to why we set what the paper leaves open"
    )

    rules = RULES

    def condition(self, name: str) -> Condition:
        """Return the condition of that name; the name must exist."""
        return next(condition for condition in self.conditions if condition.name == name)


def parse_protocol(text: str, source: str) -> Protocol:
    """Read a protocol from the text of a TOML file.

    Args:
        text: the file's text.
        source: its name, for messages.

    Raises:
        ProtocolError: one message a problem, each with key path, what was given and what
            is allowed.
    """
    examined = examine(parse_toml(text, source), source)
    if examined.protocol is None or examined.problems:
        raise ProtocolError(source, examined.problems)
    return examined.protocol


@dataclasses.dataclass(frozen=True, slots=True)
class Examined:
    """What a file says, as far as it is right.

    Attributes:
        raw: the file, as plain values.
        protocol: all of it; None where a part is wrong.
        seen: all of it as far as it is right (see `study.rules`).
        problems: one message each.
    """

    raw: dict[str, Any]
    protocol: Protocol | None
    seen: Protocol
    problems: list[str]


def examine(given: dict[str, Any], source: str) -> Examined:
    """Check what a file says by itself, and go on past what is wrong.

    Args:
        given: the file as TOML has it.
        source: its name, for messages.

    Raises:
        ProtocolError: it is an experiment.
    """
    if "experiment" in given and "study" not in given:
        raise ProtocolError(source, ["an experiment, not a study: run it with study experiment"])
    found = checked(Protocol, given)
    problems = [*found.problems, *missing_paths(found)]
    return Examined(found.raw, found.made, found.seen, problems)
