"""Carries out StartFleet and StepFleet: steps the task, asks policy and scorer.

The same code runs in the shell's process and in a process of its own, and again when a
recording is stepped anew. It knows no time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from study.events.task_description import TaskDescription
from study.families import load_member
from study.policies.base import Policy
from study.scorers.base import Scorer
from study.session.effects import StartFleet, StepFleet
from study.tasks.base import (
    FleetStep,
    PicturedTask,
    ReportingTask,
    RobotReport,
    Task,
    TellingTask,
)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FleetAnswer:
    """The fields of FleetObserved but its time, and what is only looked at.

    Attributes:
        pictures: what each robot shows, see `study.tasks.base.PicturedTask`; None unless asked
            for, or where the task takes none. The session never sees them.
        reports: which robots were stopped since the last answer, or may drive again.
    """

    request_id: int
    states: npt.NDArray[np.float32]
    rewards: npt.NDArray[np.float32]
    outcomes: npt.NDArray[np.int32]
    policy_actions: npt.NDArray[np.int32]
    scores: npt.NDArray[np.float64]
    pictures: npt.NDArray[np.uint8] | None = None
    reports: tuple[RobotReport, ...] = ()


@dataclasses.dataclass(frozen=True, slots=True)
class FleetNews:
    """What is told in the midst of a request whose answer is yet to come.

    Attributes:
        reports: which robots were stopped just now, or may drive again.
    """

    reports: tuple[RobotReport, ...]


class FleetHost:
    """Owns a task and what drives it.

    Args:
        task: name of the task.
        parameters: the task's parameters.
        tell: takes what cannot wait for the answer; without it, it waits.
    """

    def __init__(
        self,
        task: str,
        parameters: Mapping[str, object],
        tell: Callable[[FleetNews], None] | None = None,
    ) -> None:
        self._tell = tell
        self._module = load_member("study.tasks", "task", task)
        self._parameters = dict(parameters)
        self.description: TaskDescription = self._module.describe(self._parameters)
        self._tasks: dict[int, Task] = {}
        self._policies: dict[str, Policy] = {}
        self._scorers: dict[str, Scorer] = {}
        self._start: StartFleet | None = None
        self._random = np.random.default_rng(0)

    def add_artefact(self, artefact_id: str, kind: str, algorithm: str, weights: bytes) -> None:
        """Make a fit usable under its id."""
        package = "study.policies" if kind == "policy" else "study.scorers"
        loaded: Any = load_member(package, kind, algorithm).load(weights, self.description)
        (self._policies if kind == "policy" else self._scorers)[artefact_id] = loaded

    def answer(self, effect: StartFleet | StepFleet, *, pictures: bool = False) -> FleetAnswer:
        """Carry out one effect.

        Args:
            effect: what the session asks for.
            pictures: whether somebody looks: a task that takes pictures is then asked for them.
        """
        answer = self._started(effect) if isinstance(effect, StartFleet) else self._stepped(effect)
        if not pictures or not self.description.scene.camera or self._start is None:
            return answer
        task = self._task(self._start.robots)
        taken = task.pictures() if isinstance(task, PicturedTask) else None
        return dataclasses.replace(answer, pictures=taken)

    def _stepped(self, effect: StepFleet) -> FleetAnswer:
        assert self._start is not None  # noqa: S101 - the session starts a fleet before it steps it
        task = self._task(self._start.robots)
        step = task.step(effect.actions, effect.active)
        if effect.reset.any():
            states = task.reset(effect.reset, effect.seeds)
            outcomes = np.where(effect.reset, 0, step.outcomes).astype(np.int32)
            step = FleetStep(states, step.rewards, outcomes)
        return self._advised(effect.request_id, step)

    def _started(self, effect: StartFleet) -> FleetAnswer:
        self._start = effect
        self._random = np.random.Generator(np.random.PCG64(effect.policy_seed))
        robots = effect.robots
        begin = getattr(self._scorers.get(effect.scorer_id), "begin", None)
        if begin is not None:
            begin(robots, effect.policy_seed)
        states = self._task(robots).reset(np.ones(robots, dtype=np.bool_), effect.seeds)
        step = FleetStep(
            states, np.zeros(robots, dtype=np.float32), np.zeros(robots, dtype=np.int32)
        )
        return self._advised(effect.request_id, step)

    def _advised(self, request_id: int, step: FleetStep) -> FleetAnswer:
        assert self._start is not None  # noqa: S101 - set before every answer
        task = self._task(self._start.robots)
        policy = self._policy(self._start.policy_id)
        scorer_id = self._start.scorer_id
        scores = (
            self._scorers[scorer_id].scores(step.states)
            if scorer_id
            else np.empty(0, dtype=np.float64)
        )
        return FleetAnswer(
            request_id=request_id,
            states=np.array(step.states, dtype=np.float32),
            rewards=np.array(step.rewards, dtype=np.float32),
            outcomes=np.array(step.outcomes, dtype=np.int32),
            policy_actions=policy.actions(step.states, self._random),
            scores=scores,
            reports=task.take_reports() if isinstance(task, ReportingTask) else (),
        )

    def _policy(self, policy_id: str) -> Policy:
        if policy_id not in self._policies:
            module = load_member("study.policies", "policy", policy_id)
            self._policies[policy_id] = module.create(self.description)
        return self._policies[policy_id]

    def _task(self, robots: int) -> Task:
        if robots not in self._tasks:
            task: Task = self._module.create(robots, self._parameters)
            tell = self._tell
            if tell is not None and isinstance(task, TellingTask):
                task.tell(lambda reports: tell(FleetNews(reports)))
            self._tasks[robots] = task
        return self._tasks[robots]

    def close(self) -> None:
        """Free what the tasks hold."""
        for task in self._tasks.values():
            task.close()
        self._tasks.clear()
