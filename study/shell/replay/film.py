"""What each robot did since its episode began: enough for a task to take its pictures again.

A session that is fed with its recorded inputs asks for the same steps as it did then; noted down,
with the seeds, they lead a deterministic task to the same states. Pictures that were recorded are
found by the time of the answer that they came with.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.events.inputs import FleetObserved, SessionOpened
from study.events.task_description import TaskDescription
from study.session.effects import Effect, StartFleet, StepFleet


@dataclasses.dataclass(slots=True, eq=False)
class Episode:
    """One robot's episode so far.

    Attributes:
        seed: with which it was reset.
        actions: executed since.
    """

    seed: int
    actions: tuple[int, ...] = ()


@dataclasses.dataclass(slots=True, eq=False)
class Film:
    """The episodes of a fleet as they are on the screen.

    Attributes:
        episodes: one a robot.
        states: where they have led, float32 [n, d].
        number: another one after every step.
        t_ns: session time of the answer that led there; -1 before the first.
        protocol_toml: of the session; empty where the task takes no pictures: then nothing is
            noted down.
    """

    episodes: tuple[Episode, ...] = ()
    states: npt.NDArray[np.float32] = dataclasses.field(
        default_factory=lambda: np.zeros((0, 0), np.float32)
    )
    number: int = 0
    t_ns: int = -1
    protocol_toml: str = ""
    _asked: StartFleet | StepFleet | None = None

    def open(self, opened: SessionOpened) -> None:
        """Begin, if the task of the session takes pictures."""
        if TaskDescription.from_json(opened.task_json).scene.camera:
            self.protocol_toml = opened.protocol_toml

    def ask(self, effect: Effect) -> None:
        """Take note of what the session asks for; it happens when the fleet answers."""
        if self.protocol_toml and isinstance(effect, StartFleet | StepFleet):
            self._asked = effect

    def observe(self, answer: FleetObserved) -> None:
        """Take note of what the fleet answered."""
        asked = self._asked
        if asked is None or asked.request_id != answer.request_id:
            return
        self._asked = None
        self.number += 1
        self.t_ns = answer.t_ns
        self.states = answer.states
        if isinstance(asked, StartFleet):
            self.episodes = tuple(Episode(int(seed)) for seed in asked.seeds)
            return
        self.episodes = tuple(
            Episode(int(asked.seeds[robot]))
            if asked.reset[robot]
            else Episode(episode.seed, (*episode.actions, int(asked.actions[robot])))
            if asked.active[robot]
            else episode
            for robot, episode in enumerate(self.episodes)
        )

    def copy(self) -> Film:
        """Return one that goes on by itself."""
        return dataclasses.replace(self)
