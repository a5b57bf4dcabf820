"""How near a user is to the best there is: both driven from the same starts, in the same noise."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy import stats

from study.errors import StudyError
from study.events.codes import Outcome
from study.seeding import generator
from study.simulated.rollouts import Acting, Rollouts, roll_out
from study.simulated.trained_user import TrainedUser
from study.tasks._navigation_parameters import Parameters
from study.training.grid_model import GridModel
from study.training.user import Course
from study.training.value_iteration import SoftGridPolicy, solve


@dataclasses.dataclass(frozen=True, slots=True)
class Estimate:
    """A mean with its 95 % confidence interval (Student's t)."""

    mean: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.mean:.2f} [{self.low:.2f}, {self.high:.2f}]"


@dataclasses.dataclass(frozen=True, slots=True)
class Comparison:
    """What user and grid earned from one kind of start, paired by start and noise.

    Attributes:
        starts: "task" for the task's own, "anywhere" for starts spread over the map.
        robots: pairs.
        user, grid, difference: points of an episode; the difference is user less grid.
        user_discounted, grid_discounted, difference_discounted: the same, discounted.
        user_goals, grid_goals: part of the robots that reached the goal.
    """

    starts: str
    robots: int
    user: Estimate
    grid: Estimate
    difference: Estimate
    user_discounted: Estimate
    grid_discounted: Estimate
    difference_discounted: Estimate
    user_goals: float
    grid_goals: float


def estimate(values: np.ndarray[tuple[int], np.dtype[np.float64]]) -> Estimate:
    """Return the mean of values [n] and its interval; n at least 2."""
    mean = float(values.mean())
    half = float(stats.t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values)))
    return Estimate(mean, mean - half, mean + half)


def solved_policy(
    course: Course,
    user: TrainedUser,
    cell: float = 0.25,
    report: Callable[[int, float], None] | None = None,
) -> SoftGridPolicy:
    """Solve the user's task, with its discount and temperature, on a grid.

    Args:
        course: the task.
        user: whose discount and temperature are taken.
        cell: distance of the grid's places, metres.
        report: see `study.training.value_iteration.solve`.

    Raises:
        StudyError: the task is none that a grid can be made of.
    """
    if not isinstance(course.parameters, Parameters):
        raise StudyError(
            f'task "{course.name}" cannot be solved on a grid',
            "Only navigation can; train without the check.",
        )
    temperature = float(user.made_of["training"]["temperature"])
    solved = solve(GridModel(course.parameters, cell), user.discount, temperature, report=report)
    return SoftGridPolicy(solved, user.discount, temperature)


def compare(
    course: Course, user: Acting, best: Acting, discount: float, seed: int, robots: int
) -> tuple[Comparison, Comparison]:
    """Drive user and grid from the task's own starts, and from anywhere on the map.

    Args:
        course: the task.
        user: the trained user.
        best: see `solved_policy`.
        discount: gamma.
        seed: of starts, noise and actions.
        robots: pairs for each kind of start.
    """
    random = generator(seed, "compared_starts")
    seeds = random.integers(0, 2**63, robots).astype(np.uint64)
    spread = course.spread(random, robots)

    def driven(policy: Acting, *, anywhere: bool) -> Rollouts:
        own = generator(seed, "compared_actions")
        states = spread if anywhere else None
        return roll_out(course.fleet(robots), policy, seeds, own, states=states)

    found = []
    for starts in ("task", "anywhere"):
        first = driven(user, anywhere=starts == "anywhere")
        second = driven(best, anywhere=starts == "anywhere")
        mine, theirs = first.returns(discount)[0], second.returns(discount)[0]
        found.append(
            Comparison(
                starts=starts,
                robots=robots,
                user=estimate(first.points()),
                grid=estimate(second.points()),
                difference=estimate(first.points() - second.points()),
                user_discounted=estimate(mine),
                grid_discounted=estimate(theirs),
                difference_discounted=estimate(mine - theirs),
                user_goals=float((first.outcomes == Outcome.GOAL).mean()),
                grid_goals=float((second.outcomes == Outcome.GOAL).mean()),
            )
        )
    return found[0], found[1]
