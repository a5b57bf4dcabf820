"""What the stages share: the plan's constants, what was learned, and an outbox."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from study.events.events import Event
from study.events.task_description import TaskDescription
from study.messages import Messages
from study.protocol import Protocol
from study.questionnaire import Questionnaire
from study.session.effects import Effect
from study.session.kept import KeptTimesteps


@dataclasses.dataclass(slots=True)
class Outbox:
    """Events and effects of the input being handled, in order."""

    events: list[Event] = dataclasses.field(default_factory=list)
    effects: list[Effect] = dataclasses.field(default_factory=list)


@dataclasses.dataclass(frozen=True, slots=True)
class Step:
    """What handling one input gave.

    Attributes:
        events: to be recorded, in order.
        effects: to be carried out, in order.
    """

    events: tuple[Event, ...]
    effects: tuple[Effect, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class Preparation:
    """What a fit left for a later one to go on from.

    Attributes:
        request_id: of the fit.
        content: safetensors bytes.
    """

    request_id: int
    content: bytes


@dataclasses.dataclass(slots=True)
class Knowledge:
    """What the session has learned so far.

    Attributes:
        timesteps: what is kept of the trials, by (phase, condition).
        artefacts: ids of the fits that took effect.
        preparing: fits asked for in the background: request to artefact.
        preparations: the newest there is to go on from, by artefact.
        repeats: attempts for which a gate asked for further trials and fits.
        replaced: scorers that did not pass their gate, and what runs in their place: another
            artefact, or "manual".
        block_rewards: team rewards of the trials so far, by condition.
        next_trial_id: number of the next fleet run.
        next_request_id: number of the next request.
        practice_passed: whether the practice's criterion was met.
        comprehension_wrong: ids of the questions answered wrong last; None before a check.
        stop_reason: why the session ends when the stage is done; empty if it goes on.
        held_robots: why robots were stopped that may not drive yet, by robot.
    """

    timesteps: dict[tuple[int, str], KeptTimesteps] = dataclasses.field(default_factory=dict)
    artefacts: set[str] = dataclasses.field(default_factory=set)
    preparing: dict[int, str] = dataclasses.field(default_factory=dict)
    preparations: dict[str, Preparation] = dataclasses.field(default_factory=dict)
    repeats: set[int] = dataclasses.field(default_factory=set)
    replaced: dict[str, str] = dataclasses.field(default_factory=dict)
    block_rewards: dict[str, list[float]] = dataclasses.field(default_factory=dict)
    practice_passed: bool = False
    comprehension_wrong: tuple[str, ...] | None = None
    stop_reason: str = ""
    held_robots: dict[int, list[str]] = dataclasses.field(default_factory=dict)
    next_trial_id: int = 0
    next_request_id: int = 1

    def request_id(self) -> int:
        """Return a fresh request id."""
        taken = self.next_request_id
        self.next_request_id += 1
        return taken

    def trial_id(self) -> int:
        """Return a fresh trial id."""
        taken = self.next_trial_id
        self.next_trial_id += 1
        return taken


@dataclasses.dataclass(frozen=True, slots=True)
class Context:
    """What every stage may read.

    Attributes:
        protocol: the study.
        description: the task.
        questionnaires: by name.
        participant: pseudonymous id.
        seed: the session's seed.
        order: conditions of phase three in the order run.
        knowledge: what was learned so far.
        messages: the texts of the participant's language.
        rules: version of the session's rules; see `study.session.rules`.
    """

    protocol: Protocol
    description: TaskDescription
    questionnaires: Mapping[str, Questionnaire]
    participant: str
    seed: int
    order: tuple[str, ...]
    knowledge: Knowledge
    messages: Messages
    rules: int = 0

    @property
    def shared(self) -> dict[int, object]:
        """What a fork of the session takes instead of a deep copy, by identity.

        What never changes itself; of what is kept of the timesteps a copy that shares its rows.
        """
        constant = (self.protocol, self.description, self.questionnaires, self.messages)
        kept = self.knowledge.timesteps.values()
        return {**{id(part): part for part in constant}, **{id(rows): rows.copy() for rows in kept}}

    def say(self, text: str, /, **values: object) -> str:
        """Return a text in the participant's language; see `study.messages.Messages.say`."""
        return self.messages.say(text, **values)

    def count(self, one: str, many: str, n: int, /, **values: object) -> str:
        """Return a text in the grammatical number of ``n``; see `study.messages`."""
        return self.messages.count(one, many, n, **values)
