"""An experiment as a TOML file: the model that it is validated against.

Every number of the paper's simulation experiments stands in the file as the paper gives it;
what the paper leaves open is a setting too, with its reason under ``[assumptions]``.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from study.errors import ProtocolError
from study.loading import find_protocol, read_text
from study.protocol_checks import check_member
from study.rules import Part, known_names, right
from study.seat_settings import Name
from study.toml_text import parse_toml
from study.validation import checked, missing_paths, nearest

SeedSet = Literal["development", "held_out"]
Training = Literal["phase_three_only", "phase_one_and_three"]
GROUND_TRUTH = "ground_truth"
"""The scorer that knows phi; it is always there and needs no entry."""
CORRECTED = "corrected"
"""The scorer that had a correction round."""
_RESERVED = (GROUND_TRUTH, CORRECTED, "none")


class ExperimentPart(Part):
    """What the experiment is."""

    name: Name = Field(description="short name")
    title: str = Field(min_length=1, max_length=120, description="title of the report")
    description: str = Field(default="", max_length=2000, description="one paragraph")
    trials: int = Field(ge=2, le=100_000, description="trials: whole worlds, each drawn anew")


class SeedsPart(Part):
    """What every world is drawn from; the two sets share no world."""

    development: int = Field(
        ge=0, lt=2**63, description="seed of the worlds that settings were chosen on"
    )
    held_out: int = Field(ge=0, lt=2**63, description="seed of the worlds that results come from")

    def _two_sets(self) -> Iterator[str]:
        if self.development == self.held_out:
            yield f"development and held_out are both {self.held_out}; they must differ"

    rules = (_two_sets,)


class MemberPart(Part):
    """A task, policy or scorer with its parameters."""

    name: str = Field(description="name of the member")
    parameters: dict[str, Any] = Field(default_factory=dict, description="see the member")


class ScorerPart(MemberPart):
    """A scorer to be compared."""

    label: str = Field(min_length=1, max_length=40, description="name in the report")


class PhaseOnePart(Part):
    """The user demonstrates, one robot at a time."""

    episodes: int = Field(ge=1, le=1000, description="episodes that the user drives")


class ValuesPart(Part):
    """V of the robots' policy: rollouts, and a network fitted to what they earned."""

    starts: int = Field(ge=10, le=100_000, description="rollouts, from states all over the map")
    held_out_starts: int = Field(ge=2, le=100_000, description="rollouts that R^2 is measured on")
    hidden: tuple[int, ...] = Field(
        description="units of each hidden layer: how smooth phi is; fewer are smoother"
    )
    epochs: int = Field(ge=1, le=1000, description="passes over the states")
    batch_size: int = Field(ge=1, description="states in a minibatch")
    learning_rate: float = Field(gt=0, description="Adam's step size at the start")


class PhaseTwoPart(Part):
    """The user chooses freely in a small fleet."""

    robots: int = Field(ge=2, le=1000, description="fleet size, n")
    runs: int = Field(ge=1, le=1000, description="fleet runs")
    timesteps: int = Field(ge=1, le=100_000, description="length of a run; a choice each")
    temperature: float = Field(
        gt=0, description="points: chances are exp(phi / temperature); 1 is the paper's model"
    )


class PhaseThreePart(Part):
    """The large fleet, driven by each scorer."""

    robots: int = Field(ge=2, le=1000, description="fleet size, n")
    timesteps: int = Field(ge=1, le=100_000, description="length of the run")
    dwells: tuple[int, ...] = Field(min_length=1, description="timesteps between two choices, each")


class PhaseFourPart(Part):
    """The policies fitted to phase three's demonstrations, alone."""

    episodes: int = Field(ge=1, le=1000, description="episodes of each policy")
    training: tuple[Training, ...] = Field(
        min_length=1, description="which demonstrations are fitted; the first is the main one"
    )


class CorrectionPart(Part):
    """A second round of choices in the states that a first scorer leads to."""

    scorer: str = Field(description="which of [scorers] is corrected")
    fraction: float = Field(
        gt=0, lt=1, description="part of the choices that is asked in the second round"
    )
    robots: int = Field(ge=2, le=1000, description="size of the fleet that the first scorer drives")
    asked: int = Field(ge=2, le=1000, description="robots that the user chooses among")

    def _as_many_there(self) -> Iterator[str]:
        if self.asked > self.robots:
            yield f"asked is {self.asked}; there are only {self.robots} robots"

    rules = (_as_many_there,)


class SensitivityPart(Part):
    """Agreement as one dial at a time is turned."""

    trials: int = Field(ge=0, le=100_000, description="of the trials, the first so many")
    scorers: tuple[str, ...] = Field(description="which of [scorers]")
    temperatures: tuple[float, ...] = Field(default=(), description="of phase two's choices")
    runs: tuple[int, ...] = Field(default=(), description="of phase two: how many choices")
    hidden: tuple[int, ...] = Field(default=(), description="units of the values' hidden layers")


class FleetSizesPart(Part):
    """What assistance is worth as the fleet grows."""

    trials: int = Field(ge=0, le=100_000, description="of the trials, the first so many")
    sizes: tuple[int, ...] = Field(description="fleet sizes, n")
    timesteps: int = Field(ge=1, le=100_000, description="length of a run")
    scorers: tuple[str, ...] = Field(description="which scorers drive")


class ExperimentProtocol(Part):
    """A whole experiment."""

    format: Literal[1] = Field(description="version of this file format")
    experiment: ExperimentPart
    seeds: SeedsPart
    task: MemberPart
    policy: MemberPart
    values: ValuesPart
    scorers: dict[Name, ScorerPart]
    phase_one: PhaseOnePart
    phase_two: PhaseTwoPart
    phase_three: PhaseThreePart
    phase_four: PhaseFourPart
    correction: CorrectionPart | None = None
    sensitivity: SensitivityPart | None = None
    fleet_sizes: FleetSizesPart | None = None
    assumptions: dict[str, str] = Field(
        default_factory=dict, description="key path to why we set what the paper leaves open"
    )

    def _names_free(self) -> Iterator[str]:
        for name in _RESERVED:
            if name in self.scorers:
                yield (
                    f'scorers.{name}: the name is taken by the program; use another than "{name}"'
                )

    def _corrected_there(self) -> Iterator[str]:
        if self.correction:
            yield from self._unknown("correction.scorer", [self.correction.scorer])

    def _turned_there(self) -> Iterator[str]:
        if self.sensitivity:
            yield from self._unknown("sensitivity.scorers", self.sensitivity.scorers)

    def _driving_there(self) -> Iterator[str]:
        if self.fleet_sizes:
            more = [GROUND_TRUTH, *([CORRECTED] if self.correction else [])]
            yield from self._unknown("fleet_sizes.scorers", self.fleet_sizes.scorers, more)

    def _unknown(self, path: str, names: Iterable[str], more: Iterable[str] = ()) -> Iterator[str]:
        allowed = [*known_names(self.scorers), *more]
        for name in dict.fromkeys(right(names)):
            if name not in allowed:
                yield (
                    f'{path}: "{name}" is not there; {nearest(name, allowed)}'
                    f"there: {', '.join(allowed)}"
                )

    rules = (_names_free, _corrected_there, _turned_there, _driving_there)

    def world_seed_of(self, seeds: SeedSet) -> int:
        """Return the seed of a set of worlds."""
        return self.seeds.development if seeds == "development" else self.seeds.held_out


@dataclasses.dataclass(frozen=True, slots=True)
class LoadedExperiment:
    """An experiment that was read and checked.

    Attributes:
        path: where it was read from.
        text: the file as it is.
        sha256: of the text.
        protocol: what it says.
    """

    path: Path
    text: str
    sha256: str
    protocol: ExperimentProtocol


def load_experiment(given: str) -> LoadedExperiment:
    """Read and check an experiment's file, or a shipped one by its name.

    Raises:
        StudyError: there is no such file.
        ProtocolError: one message a problem.
    """
    path = find_protocol(given, "experiment")
    text = read_text(path)
    protocol = parse_experiment(text, str(path))
    return LoadedExperiment(path, text, hashlib.sha256(text.encode()).hexdigest(), protocol)


def is_experiment(text: str) -> bool:
    """Say whether a TOML file's text is meant as an experiment, right or wrong."""
    try:
        return "experiment" in parse_toml(text, "")
    except ProtocolError:
        return False


def parse_experiment(text: str, source: str) -> ExperimentProtocol:
    """Read an experiment from the text of a TOML file.

    Raises:
        ProtocolError: one message a problem, with key path and what is allowed.
    """
    raw = parse_toml(text, source)
    if "experiment" not in raw:
        hint = "it has no [experiment]; a study with people or participants is for study run"
        raise ProtocolError(source, [f"no experiment: {hint} and study simulate"])
    found = checked(ExperimentProtocol, raw)
    problems = [*found.problems, *missing_paths(found)]
    members = [("study.tasks", "task", "task", found.raw.get("task"))]
    members += [("study.policies", "policy", "policy", found.raw.get("policy"))]
    scorers = found.raw.get("scorers")
    for name, scorer in scorers.items() if isinstance(scorers, dict) else ():
        members.append(("study.scorers", "scorer", f"scorers.{name}", scorer))
    for package, family, path, member in members:
        check_member(package, family, path, member, problems)
    if problems or found.made is None:
        raise ProtocolError(source, problems)
    return found.made
