"""A study as a TOML file: the model that it is validated against.

`parse_protocol` checks everything that the file alone decides. Names of tasks, policies,
scorers and questionnaires and their parameters are checked by `study.loading`, which may
import them.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from study.errors import ProtocolError

Allocation = Literal["manual", "assisted"]
View = Literal["tiles", "operated_only"]
Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,39}$")]
Occasion = Literal["before_reveal", "after_reveal"]


class _Part(BaseModel):
    """A table of the protocol file: unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class StudyPart(_Part):
    """What the study is."""

    name: Name = Field(description="short name; names files")
    title: str = Field(min_length=1, max_length=120, description="title of the report")
    description: str = Field(default="", max_length=2000, description="one paragraph")
    planned_participants: int = Field(ge=1, le=10_000, description="planned participants")


class TimingPart(_Part):
    """How fast the world goes."""

    timesteps_per_second: float = Field(
        gt=0, le=100, description="task steps a second (8-10 for people)"
    )


class TaskPart(_Part):
    """The robots' world."""

    name: str = Field(description="name of the task")
    on_end: Literal["reset", "stay"] = Field(
        default="reset", description="whether a robot that ended starts anew or stays"
    )
    parameters: dict[str, Any] = Field(default_factory=dict, description="see the task")


class MemberPart(_Part):
    """A policy or scorer with its hyper-parameters."""

    name: str = Field(description="name of the policy or scorer")
    fit_budget_seconds: float = Field(default=30.0, gt=0, description="when a fit is given up, s")
    parameters: dict[str, Any] = Field(default_factory=dict, description="hyper-parameters")


class PracticePart(_Part):
    """Unscored driving before phase one."""

    timesteps: int = Field(ge=0, le=100_000, description="length; 0 for none")


class PhaseOnePart(_Part):
    """One robot, corrected by the participant."""

    episodes: int = Field(ge=1, le=1000, description="episodes")
    initial_policy: Literal["uniform_random"] = Field(
        default="uniform_random", description="policy of the first episode"
    )
    refit: Literal["each_episode", "at_end"] = Field(
        default="each_episode", description="when the policy is fitted anew"
    )


class PhaseTwoPart(_Part):
    """A small fleet with free choice."""

    robots: int = Field(ge=2, le=48, description="fleet size, n")
    trials: int = Field(ge=1, le=1000, description="trials")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")


class PhaseThreePart(_Part):
    """The large fleet under each condition."""

    trials: int = Field(ge=1, le=1000, description="trials per condition")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")
    order: Literal["ab_ba", "latin_square", "fixed"] = Field(
        description="order design of the conditions"
    )
    paired_starts: bool = Field(
        default=True, description="the same start states in each condition's k-th trial"
    )


class PhaseFourPart(_Part):
    """The retrained policies alone."""

    robots: int = Field(ge=1, le=1000, description="robots evaluated at once")
    trials: int = Field(ge=1, le=1000, description="trials per policy")
    trial_timesteps: int = Field(ge=1, le=100_000, description="length of a trial, timesteps")
    training: Literal["phase_one_and_condition", "phase_three_only"] = Field(
        default="phase_one_and_condition", description="which demonstrations are used"
    )


class Condition(_Part):
    """A named combination of allocation, scorer, fleet size, dwell and view."""

    name: Name = Field(description="name in the data")
    label: str = Field(min_length=1, max_length=40, description="name in reports")
    allocation: Allocation = Field(description="who decides which robot is operated")
    view: View = Field(description="what the participant sees")
    robots: int = Field(ge=2, le=48, description="fleet size, n")
    scorer: str = Field(default="", description="which of [scorers] decides; empty for none")
    dwell: int = Field(
        default=0, ge=0, le=10_000, description="timesteps between automatic switches"
    )

    @model_validator(mode="after")
    def _check(self) -> Condition:
        if self.allocation == "assisted" and (not self.scorer or not self.dwell):
            raise ValueError("an assisted condition needs a scorer and a dwell of at least 1")
        if self.allocation == "manual" and self.dwell:
            raise ValueError("a manual condition has no dwell; remove it")
        if self.allocation == "manual" and self.view == "operated_only":
            raise ValueError('a manual condition shows all robots: use view = "tiles"')
        return self


class QuestionnaireUse(_Part):
    """A questionnaire and when it is asked, after each block of phase three."""

    name: str = Field(description="file stem under questionnaires/")
    when: tuple[Occasion, ...] = Field(min_length=1, description="occasions")


class KeyPart(_Part):
    """Which key does what."""

    up: str = Field(default="up", description="the action that the task binds to up")
    down: str = Field(default="down", description="the action bound to down")
    left: str = Field(default="left", description="the action bound to left")
    right: str = Field(default="right", description="the action bound to right")
    next_robot: str = Field(default="tab", description="choose the next robot")
    confirm: str = Field(default="return", description="go on, confirm")
    back: str = Field(default="backspace", description="go back")
    pause: str = Field(default="escape", description="pause")
    robots: tuple[str, ...] = Field(
        default=("1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-", "="),
        max_length=48,
        description="keys that choose robots 1, 2, ...",
    )

    @model_validator(mode="after")
    def _distinct(self) -> KeyPart:
        singles = [getattr(self, name) for name in type(self).model_fields if name != "robots"]
        keys = [*singles, *self.robots]
        twice = sorted({key for key in keys if keys.count(key) > 1})
        if twice:
            raise ValueError(f"bound twice: {', '.join(twice)}; each key does one thing")
        return self


class Exclusion(_Part):
    """A rule by which analysis leaves out a participant."""

    name: Name = Field(description="name of the rule")
    measure: Literal["complete_trials", "choices", "demonstrations"] = Field(
        description="what is counted for each participant"
    )
    at_least: float = Field(description="participants below this are left out")
    reason: str = Field(min_length=1, max_length=400, description="why")


class AnalysisPart(_Part):
    """Analyses planned before the data are seen."""

    primary: Literal["team_reward"] = Field(default="team_reward", description="primary measure")
    planned: tuple[
        Literal["rm_anova", "pooled_trials", "likert", "phase_four", "heat_maps"], ...
    ] = Field(min_length=1, description="what the report computes")
    equivalence_bound: float | None = Field(
        default=None, gt=0, description="smallest difference of interest, points"
    )


class Protocol(_Part):
    """A whole study."""

    format: Literal[1] = Field(description="version of this file format")
    study: StudyPart
    timing: TimingPart
    task: TaskPart
    policy: MemberPart
    scorers: dict[Name, MemberPart] = Field(default_factory=dict)
    practice: PracticePart
    phase_one: PhaseOnePart
    phase_two: PhaseTwoPart
    phase_three: PhaseThreePart
    phase_four: PhaseFourPart | None = None
    conditions: tuple[Condition, ...] = Field(min_length=1)
    questionnaires: tuple[QuestionnaireUse, ...] = ()
    keys: KeyPart = KeyPart()
    exclusions: tuple[Exclusion, ...] = ()
    analysis: AnalysisPart
    assumptions: dict[str, str] = Field(
        default_factory=dict, description="key path to why we set what the paper leaves open"
    )

    @model_validator(mode="after")
    def _check(self) -> Protocol:
        names = [condition.name for condition in self.conditions]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"conditions: the name {', '.join(twice)} is given twice")
        if self.phase_three.order == "ab_ba" and len(names) != 2:
            raise ValueError(
                f'phase_three.order: "ab_ba" needs two conditions, {len(names)} given; '
                'use "latin_square"'
            )
        for condition in self.conditions:
            if condition.scorer and condition.scorer not in self.scorers:
                raise ValueError(
                    f'conditions.{condition.name}.scorer: "{condition.scorer}" is not under '
                    f"[scorers]; there: {', '.join(self.scorers) or 'none'}"
                )
        largest = max(self.phase_two.robots, *(condition.robots for condition in self.conditions))
        if largest > len(self.keys.robots):
            raise ValueError(
                f"keys.robots: {len(self.keys.robots)} keys given for a fleet of {largest}; "
                "give one key a robot"
            )
        return self

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
    try:
        protocol = Protocol.model_validate(raw)
    except ValidationError as error:
        raise ProtocolError(source, list(validation_problems(error, Protocol))) from error
    missing = [path for path in protocol.assumptions if not _has_path(raw, path)]
    if missing:
        problems = [
            f'assumptions: "{path}" names no setting of this file; write the key path of one'
            for path in missing
        ]
        raise ProtocolError(source, problems)
    return protocol


def _has_path(raw: object, path: str) -> bool:
    """Whether a key path such as ``conditions.assisted.view`` leads somewhere."""
    node = raw
    for step in path.split("."):
        if isinstance(node, list):
            node = next(
                (item for item in node if isinstance(item, dict) and item.get("name") == step), None
            )
        elif isinstance(node, dict):
            node = node.get(step)
        if node is None:
            return False
    return True


def validation_problems(
    error: ValidationError, model: type[BaseModel], prefix: str = ""
) -> Iterator[str]:
    """Translate pydantic's errors: key path, what was given, what is allowed, nearest name."""
    for item in error.errors():
        location = [part for part in item["loc"] if not str(part).startswith(("function-", "["))]
        path = ".".join([*([prefix] if prefix else []), *(_step(part) for part in location)])
        kind, given = item["type"], item["input"]
        lead = f"{path}: " if path else ""
        if kind == "extra_forbidden":
            allowed = _keys_at(model, location[:-1])
            near = difflib.get_close_matches(str(location[-1]), allowed, n=1)
            hint = f'did you mean "{near[0]}"? ' if near else ""
            yield f"{lead}unknown key; {hint}allowed here: {', '.join(allowed)}"
        elif kind == "missing":
            yield f"{lead}missing; every protocol states it"
        elif kind == "value_error":
            yield f"{lead}{item['ctx']['error']}"
        elif kind == "literal_error":
            words = [
                word.strip(" '") for word in item["ctx"]["expected"].replace(" or ", ",").split(",")
            ]
            near = difflib.get_close_matches(str(given), words, n=1)
            hint = f' Did you mean "{near[0]}"?' if near else ""
            yield f"{lead}{_shown(given)} given, allowed: {item['ctx']['expected']}.{hint}"
        else:
            yield f"{lead}{_shown(given)} given; {item['msg'][0].lower()}{item['msg'][1:]}"


def _step(part: int | str) -> str:
    return str(part + 1) if isinstance(part, int) else part


def _shown(given: object) -> str:
    text = repr(given)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _keys_at(model: type[BaseModel], location: list[Any]) -> list[str]:
    """The keys allowed at a place in the model."""
    here = model
    for part in location:
        field = here.model_fields.get(str(part))
        # Names of table entries and places in lists are no fields: the model stays.
        if field is not None:
            here = _model_in(field.annotation) or here
    return sorted(here.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:  # noqa: ANN401 - a type form
    """The model that an annotation such as ``tuple[Condition, ...]`` or ``Part | None`` holds."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    found = (_model_in(part) for part in get_args(annotation))
    return next((model for model in found if model), None)
