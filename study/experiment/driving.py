"""Phase three: a large fleet under each scorer, all side by side."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.experiment.fleets import Fleets, drawn_actions
from study.experiment.protocol import GROUND_TRUTH
from study.experiment.world import Demonstrations, World
from study.scorers.base import Scorer

Floats = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FleetRun:
    """What came of one fleet under one scorer.

    Attributes:
        scorer: its name; "none" for a fleet that nobody helps.
        dwell: timesteps between two choices; 0 without an operator.
        team_reward: points of all robots over the run.
        own_agreement: part of the timesteps at which the scorer's first robot is phi's, in the
            states that this fleet visits; nan without a scorer.
        reference_agreement: the same in the states that a fleet visits which phi itself
            drives, choosing anew at every timestep.
        goals: episodes that ended at the goal.
        lost: episodes that ended with the robot lost.
        demonstrations: what the user did.
    """

    scorer: str
    dwell: int
    team_reward: float
    own_agreement: float
    reference_agreement: float
    goals: int
    lost: int
    demonstrations: Demonstrations


def drive(
    world: World,
    phi: Scorer,
    scorers: Mapping[str, Scorer],
    *,
    dwells: Sequence[int],
    robots: int,
    timesteps: int,
    name: str,
    unassisted: bool = False,
) -> list[FleetRun]:
    """Run one fleet for each scorer and dwell: the same starts, noise and user's noise.

    Args:
        world: the trial's.
        phi: the ground truth that agreement is measured against.
        scorers: by name; a fleet that phi drives is always run, and its row left out unless
            "ground_truth" is among them.
        dwells: timesteps between two choices, each.
        robots: fleet size, n.
        timesteps: length of the run.
        name: what the fleets are for; keys their streams.
        unassisted: whether to run a fleet without a user too.
    """
    columns = [(GROUND_TRUTH, 1)]
    columns += [(each, dwell) for each in scorers for dwell in dwells]
    columns = list(dict.fromkeys(columns))
    operated = len(columns)
    fleets = world.fleets(name, fleets=operated + unassisted, robots=robots, paired=True)
    asked = _Asked(phi, scorers, columns)
    asked.begin(robots, world.stream(f"{name} scorers"))
    marks = world.random(f"{name} user").random(timesteps)
    idle = np.random.default_rng(0)
    rows = np.arange(operated)
    dwell = np.array([each for _, each in columns])
    picked = np.zeros(operated, np.int64)
    points = np.zeros(operated + unassisted)
    agreed = np.zeros((2, operated))
    seen: list[npt.NDArray[np.float32]] = []
    done: list[npt.NDArray[np.int32]] = []
    for timestep in range(timesteps):
        now = fleets.states[:operated]
        first, own, reference = asked.at(now)
        agreed += [own, reference]
        picked = np.where(timestep % dwell == 0, first, picked)
        actions = fleets.policy_actions(world.policy, idle)
        operated_states = now[rows, picked]
        # One mark for all: users of two fleets in one state do the same.
        chances = world.user.probabilities(operated_states)
        driven = drawn_actions(chances, np.full(operated, marks[timestep]))
        actions[rows, picked] = driven
        seen.append(operated_states)
        done.append(driven)
        points += fleets.step(actions).sum(axis=1)
    return _runs(world, columns, scorers, fleets, points, agreed / timesteps, seen, done)


def _runs(
    world: World,
    columns: Sequence[tuple[str, int]],
    scorers: Mapping[str, Scorer],
    fleets: Fleets,
    points: Floats,
    agreed: Floats,
    seen: list[npt.NDArray[np.float32]],
    done: list[npt.NDArray[np.int32]],
) -> list[FleetRun]:
    states, actions = np.stack(seen, axis=1), np.stack(done, axis=1)
    runs = []
    for place in range(len(points)):
        if place < len(columns):
            name, dwell = columns[place]
            own, reference = agreed[:, place].tolist()
            kept = actions[place] != world.description.idle_action
            demonstrated = Demonstrations(states[place][kept], actions[place][kept])
        else:
            name, dwell, own, reference = "none", 0, float("nan"), float("nan")
            demonstrated = Demonstrations(states[0, :0], actions[0, :0])
        if name in scorers or name == "none":
            runs.append(
                FleetRun(
                    scorer=name,
                    dwell=dwell,
                    team_reward=float(points[place]),
                    own_agreement=own,
                    reference_agreement=reference,
                    goals=int(fleets.endings[place, Outcome.GOAL]),
                    lost=int(fleets.endings[place, Outcome.LOST]),
                    demonstrations=demonstrated,
                )
            )
    return runs


class _Asked:
    """Asks every scorer about its own fleets and about the reference fleet, in one call each.

    A scorer that remembers keeps each robot's memory apart, so fleets can be laid end to end.

    Args:
        phi: the ground truth.
        scorers: by name.
        columns: (scorer, dwell) of each fleet, the reference fleet first.
    """

    def __init__(
        self, phi: Scorer, scorers: Mapping[str, Scorer], columns: Sequence[tuple[str, int]]
    ) -> None:
        self._phi = phi
        self._scorers = {name: each for name, each in scorers.items() if name != GROUND_TRUTH}
        self._places = {
            name: [place for place, (column, _) in enumerate(columns) if column == name]
            for name in self._scorers
        }

    def begin(self, robots: int, seed: int) -> None:
        for name, scorer in self._scorers.items():
            if hasattr(scorer, "begin"):
                scorer.begin((len(self._places[name]) + 1) * robots, seed)

    def at(self, states: npt.NDArray[np.float32]) -> tuple[npt.NDArray[np.int64], Floats, Floats]:
        """Ask about states float32 [F, n, d].

        Returns:
            first: int64 [F], whom each fleet's scorer puts first.
            own: float64 [F], 1 where that is whom phi puts first.
            reference: float64 [F], 1 where the scorer agrees with phi on the reference fleet.
        """
        fleets, robots, width = states.shape
        worth = self._phi.scores(states.reshape(-1, width)).reshape(fleets, robots)
        truth = worth.argmax(axis=1)
        first = truth.copy()
        reference = np.ones(fleets)
        for name, scorer in self._scorers.items():
            places = self._places[name]
            shown = states[[*places, 0]].reshape(-1, width)
            best = scorer.scores(shown).reshape(-1, robots).argmax(axis=1)
            first[places] = best[:-1]
            reference[places] = float(best[-1] == truth[0])
        return first, (first == truth).astype(np.float64), reference
