"""A study as a TOML file: the model that it is validated against.

`parse_protocol` checks everything that the file alone decides. Names of tasks, policies,
scorers and questionnaires and their parameters are checked by `study.loading`, which may
import them.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator
from typing import Any, Literal

from pydantic import Field, ValidationError, model_validator

from study.errors import ProtocolError
from study.messages import SOURCE
from study.scorer_settings import CorrectionRoundPart, MemberPart, ScorerPart, scorer_problems
from study.seat_settings import (
    NUMBER_ROW,
    BreakPart,
    ComprehensionPart,
    ConsentPart,
    DebriefPart,
    Failure,
    KeyPart,
    Name,
    Part,
    RecordingPart,
    SwitchingPart,
)
from study.validation import missing_paths, nearest, validation_problems

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

    @model_validator(mode="after")
    def _check(self) -> Condition:
        if self.allocation == "assisted" and (not self.scorer or not self.dwell):
            raise ValueError("an assisted condition needs a scorer and a dwell of at least 1")
        if self.allocation == "suggested" and not self.scorer:
            raise ValueError("a suggested condition needs a scorer")
        if self.allocation == "manual" and self.dwell:
            raise ValueError("a manual condition has no dwell; remove it")
        if self.allocation != "assisted" and self.view == "operated_only":
            raise ValueError(
                f'a {self.allocation} condition shows all robots: view = "tiles" or "enlarged"'
            )
        return self


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

    @model_validator(mode="after")
    def _check(self) -> Protocol:
        problems = list(self._disagreements())
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _disagreements(self) -> Iterator[str]:
        """Say where parts that are right by themselves do not go together."""
        names = [condition.name for condition in self.conditions]
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield f'conditions: the name "{name}" is given twice'
        asked = [use.name for use in self.questionnaires]
        for name in sorted({name for name in asked if asked.count(name) > 1}):
            yield f'questionnaires: "{name}" is listed twice; list it once with all its occasions'
        if self.phase_three.order == "ab_ba" and len(names) != 2:
            yield (
                f'phase_three.order: "ab_ba" needs two conditions, {len(names)} given; '
                'use "latin_square"'
            )
        for condition in self.conditions:
            if condition.scorer and condition.scorer not in self.scorers:
                yield (
                    f'conditions.{condition.name}.scorer: "{condition.scorer}" is not under '
                    f"[scorers]; {nearest(condition.scorer, list(self.scorers))}"
                    f"there: {', '.join(self.scorers) or 'none'}"
                )
        yield from scorer_problems(self.scorers, self.correction_round, self.phase_two.trials)
        yield from self._key_conflicts()
        rounds = [self.correction_round.robots] if self.correction_round else []
        fleets = [each.robots for each in self.conditions]
        largest = max([self.phase_two.robots, *rounds, *fleets])
        if len(self.keys.robots) < min(largest, NUMBER_ROW):
            yield (
                f"keys.robots: {len(self.keys.robots)} keys given for a fleet of {largest}; "
                "give one key a robot"
            )
        elif largest > len(self.keys.robots):
            # Numbers are typed then: see study.session.number_entry.
            named = {name: getattr(self.keys, name) for name in ("up", "down", "left", "right")}
            digits = [name for name, key in named.items() if key.isdecimal()]
            if digits:
                yield (
                    f"keys.{digits[0]}: a digit given, but a fleet of {largest} is chosen from by "
                    "typing numbers; bind another key"
                )

    def _key_conflicts(self) -> Iterator[str]:
        """Only where something is suggested does the key that accepts have a meaning."""
        suggests = any(each.allocation == "suggested" for each in self.conditions)
        bound = self.keys.model_dump(exclude={"accept"})
        others = [*bound.pop("robots"), *bound.values()]
        if suggests and self.keys.accept in others:
            yield f'keys.accept: "{self.keys.accept}" is bound twice; each key does one thing'

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
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ProtocolError(source, [f"not TOML: {error}"]) from error
    if "experiment" in raw and "study" not in raw:
        raise ProtocolError(source, ["an experiment, not a study: run it with study experiment"])
    try:
        # By way of JSON pydantic can be strict ("2" and true are no numbers) and yet take
        # arrays for tuples.
        protocol = Protocol.model_validate_json(json.dumps(raw, default=str), strict=True)
    except ValidationError as error:
        problems = list(validation_problems(error, Protocol, given_file=raw))
        raise ProtocolError(source, problems) from error
    if problems := missing_paths(raw, protocol.assumptions):
        raise ProtocolError(source, problems)
    return protocol
