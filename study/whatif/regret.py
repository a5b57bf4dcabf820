"""What taking over another robot would have earned, by rolling the task forward.

From the recorded state each robot is driven on, for a stated horizon, once by whoever takes over
and once by the recorded policy, with the same noise. Robots of a task that can be placed do not
influence each other (`study.tasks.base`), so a fleet in which robot i is taken over earns what
all robots earn under the policy, plus what the driver adds to robot i: its *gain*. The regret of
a choice is the largest gain among the available robots less that of the robot chosen.

A robot whose episode ends within the horizon earns nothing after it, and the episode's own clock
starts afresh at the recorded state. Noise and the driver's luck are keyed by fleet run, timestep
and robot: what is rolled out beside a choice makes no difference to it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from pydantic import ValidationError

from study.errors import StudyError, UnknownNameError
from study.families import load_member
from study.seeding import generator
from study.simulated.rollouts import Acting, roll_out
from study.simulated.trained_user import TrainedUser
from study.tasks.base import PlaceableTask
from study.whatif.measuring import Answers, TableBuilder, run_keys
from study.whatif.sessions import ChoiceSession, FleetRun

Floats = npt.NDArray[np.float64]
States = npt.NDArray[np.float32]

TRAINED, DEMONSTRATIONS = "trained", "demonstrations"
BATCH = 6000
"""Robots rolled out side by side: as many choices as make up about so many."""


@dataclasses.dataclass(frozen=True, slots=True)
class RegretSettings:
    """How alternatives are rolled out.

    Attributes:
        horizon: timesteps.
        draws: futures, of noise and luck, averaged over.
        choices: at most so many a participant, spread evenly.
        driver: who drives the robot taken over: "trained" (the user that ships with the task),
            "demonstrations" (nearest of the participant's own), or a trained user's file.
        seed: of noise and luck.
    """

    horizon: int = 40
    draws: int = 4
    choices: int = 50
    driver: str = TRAINED
    seed: int = 0


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class RollingOut:
    """All that a session's alternatives are rolled out with.

    Attributes:
        session: whose choices.
        settings: how.
        make_task: makes a fleet of so many robots.
        driver: who drives the robot taken over.
        policies: the recorded policies, by id.
    """

    session: ChoiceSession
    settings: RegretSettings
    make_task: Callable[[int], PlaceableTask]
    driver: Acting
    policies: dict[str, Acting]

    def gains(self, run: FleetRun, picked: npt.NDArray[np.int64]) -> Floats:
        """Return what taking over each robot adds, points, float64 [k, n].

        Args:
            run: a fleet run.
            picked: int64 [k], which of its choices. Robots that were not available have 0.

        Raises:
            ValueError: a robot cannot be put where it was.
        """
        offered, states = run.offered[picked], run.states[run.rows[picked]]
        choice, robot = np.nonzero(offered)
        draws = self.settings.draws
        seeds, marks = self._luck(run, picked)
        placed = np.repeat(states[choice, robot], draws, axis=0)
        own_seeds = seeds[choice, robot].reshape(-1)
        own_marks = marks[choice, robot].reshape(-1, self.settings.horizon)
        task = self.make_task(len(placed))
        try:
            earned = [
                roll_out(
                    task,
                    acting,
                    own_seeds,
                    Marks(own_marks),
                    states=placed,
                    timesteps=self.settings.horizon,
                    everyone=True,
                ).points()
                for acting in (self.driver, self.policies[run.started.policy_id])
            ]
        finally:
            task.close()
        gains = np.zeros(offered.shape)
        gains[choice, robot] = (earned[0] - earned[1]).reshape(-1, draws).mean(axis=1)
        return gains

    def _luck(
        self, run: FleetRun, picked: npt.NDArray[np.int64]
    ) -> tuple[npt.NDArray[np.uint64], Floats]:
        """Return seeds of the noise [k, n, draws] and the driver's marks [k, n, draws, horizon]."""
        shape = (run.states.shape[1], self.settings.draws)
        seeds, marks = [], []
        for at in picked.tolist():
            key = (run.trial_id, int(run.timesteps[at]))
            random = generator(self.settings.seed ^ self.session.opened.seed, "what if", *key)
            seeds.append(random.integers(0, 1 << 63, shape).astype(np.uint64))
            marks.append(random.random((*shape, self.settings.horizon)))
        return np.stack(seeds), np.stack(marks)


class Marks(np.random.Generator):
    """A stream whose uniform numbers were drawn before: a column at each call.

    Args:
        marks: float64 [n, T], those of each robot.
    """

    def __init__(self, marks: Floats) -> None:
        super().__init__(np.random.PCG64(0))
        self._marks = marks
        self._at = 0

    def random(self, size: Any = None, *_: Any, **__: Any) -> Any:  # noqa: ANN401 - NumPy's own is overloaded
        """Return the next number of each robot; other sizes come from an own stream."""
        if size != len(self._marks) or self._at >= self._marks.shape[1]:
            return super().random(size)
        self._at += 1
        return self._marks[:, self._at - 1]


def open_rollouts(
    session: ChoiceSession, settings: RegretSettings, note: Callable[[str], None]
) -> RollingOut | None:
    """Return what a session's alternatives are rolled out with; None, and a note, if it cannot be.

    Raises:
        StudyError: the driver's file cannot be used.
    """
    name = session.task.name
    part = session.protocol.get("task", {})
    parameters = dict(part.get("parameters", {}))
    try:
        module = load_member("study.tasks", "task", name)
        described = module.describe(parameters)
        probe = module.create(1, parameters)
    except (UnknownNameError, StudyError, ValidationError, ValueError) as error:
        note(f"No regret: the task {name} cannot be made as recorded: {str(error)[:200]}.")
        return None
    probe.close()
    if not isinstance(probe, PlaceableTask):
        note(f"No regret: robots of the task {name} cannot be put into a recorded state.")
        return None
    if described.to_json() != session.task.to_json():
        note(f"No regret: the task {name} is not what it was when this was recorded.")
        return None
    driver = _driver(session, settings.driver, parameters, module)
    return RollingOut(
        session=session,
        settings=settings,
        make_task=lambda robots: module.create(robots, parameters),
        driver=driver,
        policies={run.started.policy_id: _policy(session, run) for run in session.runs},
    )


def add_regret(
    table: TableBuilder,
    rollouts: RollingOut,
    answers: Sequence[Answers],
    note: Callable[[str], None],
) -> None:
    """Append the regret of the operator, of chance and of each scorer, at choices spread evenly."""
    session = rollouts.session
    for run, picked in _spread(session, rollouts.settings.choices):
        robots = run.states.shape[1]
        step = max(1, BATCH // (robots * rollouts.settings.draws))
        for start in range(0, len(picked), step):
            some = picked[start : start + step]
            try:
                gains = rollouts.gains(run, some)
            except ValueError:
                note(
                    f"{session.participant}: choices of fleet run {run.trial_id} have no regret: "
                    "a robot cannot be put where it was."
                )
                break
            _add_rows(table, session, run, some, gains, answers)


def _spread(session: ChoiceSession, most: int) -> list[tuple[FleetRun, npt.NDArray[np.int64]]]:
    """Choose choices evenly, in order: those after the own scorers' fits, if there are any."""
    later = [np.flatnonzero(~session.fitted(run)) for run in session.runs]
    if not any(len(rows) for rows in later):
        later = [np.arange(len(run.chosen)) for run in session.runs]
    ends = np.cumsum([len(rows) for rows in later])
    total = int(ends[-1]) if len(ends) else 0
    wanted = np.unique(np.linspace(0, total - 1, min(most, total)).round().astype(np.int64))
    found = []
    for run, rows, end in zip(session.runs, later, ends, strict=True):
        mine = wanted[(wanted >= end - len(rows)) & (wanted < end)] - (end - len(rows))
        if len(mine):
            found.append((run, rows[mine]))
    return found


def _add_rows(
    table: TableBuilder,
    session: ChoiceSession,
    run: FleetRun,
    picked: npt.NDArray[np.int64],
    gains: Floats,
    answers: Sequence[Answers],
) -> None:
    offered = run.offered[picked]
    masked = np.where(offered, gains, -np.inf)
    best, largest = masked.argmax(axis=1), masked.max(axis=1)
    rows = np.arange(len(picked))
    common = {
        **run_keys(session, run),
        "timestep": run.timesteps[picked],
        "available": offered.sum(axis=1),
        "fitted": session.fitted(run)[picked],
        "best": best + 1,
        "best_gain": largest,
    }

    def add(who: str, robot: npt.NDArray[np.int64], *, seen: object) -> None:
        gain = gains[rows, robot]
        regret = largest - gain
        table.add(
            len(rows), **common, who=who, seen=seen, robot=robot + 1, gain=gain, regret=regret
        )

    add("operator", run.chosen[picked], seen=False)
    mean = np.where(offered, gains, 0.0).sum(axis=1) / offered.sum(axis=1)
    table.add(
        len(rows), **common, who="chance", seen=False, robot=0, gain=mean, regret=largest - mean
    )
    for one in answers:
        place = next((at for at, own in enumerate(one.runs) if own is run), None)
        if place is not None and one.asked.trials is None:
            seen = one.seen(run)[picked]
            add(one.asked.name, one.judged[place].first[picked], seen=seen)


def _policy(session: ChoiceSession, run: FleetRun) -> Acting:
    fit = session.fit(run.started.policy_id)
    if fit is None:
        module = load_member("study.policies", "policy", run.started.policy_id)
        made: Acting = module.create(session.task)
        return made
    loaded: Acting = load_member("study.policies", "policy", fit.algorithm).load(
        fit.weights, session.task
    )
    return loaded


def _driver(
    session: ChoiceSession,
    name: str,
    parameters: dict[str, Any],
    module: Any,  # noqa: ANN401
) -> Acting:
    filled = module.Parameters.model_validate(parameters).model_dump(mode="json")
    if name == TRAINED:
        return TrainedUser.shipped(session.task.name, filled)
    if name == DEMONSTRATIONS:
        from study.whatif.demonstrators import own_driver  # noqa: PLC0415 - seldom wanted

        return own_driver(session)
    path = Path(name)
    if not path.is_file():
        raise StudyError(
            f'no driver "{name}"',
            f'Give "{TRAINED}", "{DEMONSTRATIONS}", or the file that `study train-user` wrote.',
        )
    return TrainedUser.load(path, session.task.name, filled)
