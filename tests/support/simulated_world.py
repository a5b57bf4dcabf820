"""A small stand-in for a session: steps the real task and obeys an operator's keys."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt

from study.events.codes import Outcome
from study.screens import Cue, FleetScreen, Tile, View
from study.seeding import stream_seed
from study.session.number_entry import NumberEntry
from study.simulated.keys import KeyStroke
from study.simulated.operator import Operator
from study.tasks.base import SnapshotTask
from study.tasks.navigation import IDLE, create

STEP_NS = 125_000_000
NUMBER_KEYS = {key: robot for robot, key in enumerate("1234567890-=")}

Policy = Callable[[npt.NDArray[np.float32]], npt.NDArray[np.int32]]


class Keyboard:
    """Which keys are down, checked for strokes that no hand can make."""

    def __init__(self) -> None:
        self.down: list[str] = []
        self.tapped: list[str] = []

    def take(self, strokes: Iterable[KeyStroke]) -> None:
        """Press and release, in order."""
        self.tapped = []
        for stroke in strokes:
            if stroke.down:
                assert stroke.key not in self.down, f"{stroke.key} pressed twice"
                self.down.append(stroke.key)
                self.tapped.append(stroke.key)
            else:
                assert stroke.key in self.down, f"{stroke.key} was not down"
                self.down.remove(stroke.key)

    def newest(self, keys: Iterable[str]) -> str | None:
        """Return the newest of ``keys`` held, or tapped in the latest strokes."""
        wanted = [key for key in (*self.down, *self.tapped) if key in keys]
        return wanted[-1] if wanted else None


@dataclasses.dataclass
class Row:
    """One timestep as it happened."""

    t_ns: int
    screen: FleetScreen
    strokes: tuple[KeyStroke, ...]
    noticed: tuple[int, ...]
    states: npt.NDArray[np.float32]
    action: int
    """What the operator did to the operated robot; -1 if it did nothing."""
    rewards: npt.NDArray[np.float32]
    outcomes: npt.NDArray[np.int32]


class World:
    """A fleet run, with the navigation task unless another is given.

    Args:
        robots: n.
        allocation: "correction", "manual" or "assisted" (a switch each dwell, in turn).
        policy: what the robots do by themselves.
        seed: of the start states.
        dwell: timesteps between automatic switches.
        view: "tiles" or "operated_only".
        places: start states float32 [n, 4] instead of the task's own.
        task: what is stepped; None for navigation.
    """

    def __init__(
        self,
        robots: int,
        allocation: str,
        policy: Policy,
        *,
        seed: int = 0,
        dwell: int = 15,
        view: View = "tiles",
        places: npt.NDArray[np.float32] | None = None,
        task: SnapshotTask | None = None,
    ) -> None:
        self.task = create(robots, {}) if task is None else task
        self.robots, self.allocation, self.view = robots, allocation, view
        self.dwell, self.policy = dwell, policy
        self.episodes = [1] * robots
        self.cues: list[Cue | None] = [None] * robots
        self.seed = seed
        self.states = self.task.reset(np.ones(robots, np.bool_), self._seeds())
        if places is not None:
            snapshot = self.task.snapshot()
            snapshot["states"] = places
            self.task.restore(snapshot)
            self.states = places.copy()
        self._numbers = NumberEntry(tuple(NUMBER_KEYS), robots)
        self.operated = -1 if allocation == "manual" and robots > 1 else 0
        self.switched_ns = -1
        self.timestep = 0
        self.keyboard = Keyboard()

    def _seeds(self) -> npt.NDArray[np.uint64]:
        return np.array(
            [
                stream_seed(self.seed, "start", robot, self.episodes[robot])
                for robot in range(self.robots)
            ],
            np.uint64,
        )

    @property
    def now_ns(self) -> int:
        """Session time."""
        return self.timestep * STEP_NS

    def screen(self) -> FleetScreen:
        """What is shown."""
        visible = range(self.robots) if self.view == "tiles" else [self.operated]
        tiles = tuple(
            tile_of(self.states[robot], robot, self.cues[robot], self.episodes[robot])
            for robot in visible
        )
        return FleetScreen(
            heading="Part 3 of 4, block 1 of 2",
            trial=1,
            trials=8,
            seconds_left=10.0,
            seconds_total=10.0,
            scene=self.task.description.scene,
            tiles=tiles,
            robots=self.robots,
            operated=self.operated,
            allocation=self.allocation,
            view=self.view,
            suggested=-1,
            dwell_left=-1.0,
            switched_ns=self.switched_ns,
            timestep=self.timestep,
            t_ns=self.now_ns,
            timestep_seconds=STEP_NS * 1e-9,
            keys=(),
            message="",
        )

    def _obey(self, strokes: tuple[KeyStroke, ...]) -> int:
        """Take the keys in and return the action asked for, -1 for none."""
        self.keyboard.take(strokes)
        if self.allocation == "manual" and self.robots > 1:
            for key in self.keyboard.tapped:
                before = self.operated
                for robot in self._numbers.press(key, self.now_ns):
                    self.operated = robot
                if key == "tab":
                    self.operated = (self.operated + 1) % self.robots
                if self.operated != before:
                    self.switched_ns = self.now_ns
        actions = self.task.description.key_actions
        driving = self.keyboard.newest(actions)
        return -1 if driving is None else actions[driving]

    def step(
        self, operator: Operator, alter: Callable[[FleetScreen], FleetScreen] | None = None
    ) -> Row:
        """Let the operator act and step the fleet once."""
        shown = self.screen() if alter is None else alter(self.screen())
        strokes = operator.act(shown, self.now_ns)
        noticed = getattr(operator, "noticed", ())
        t_ns, states = self.now_ns, self.states
        action = self._obey(strokes)
        actions = self.policy(states)
        if self.operated >= 0 and (action >= 0 or self.allocation != "correction"):
            idle = self.task.description.idle_action
            actions[self.operated] = action if action >= 0 else idle
        stepped = self.task.step(actions, np.ones(self.robots, np.bool_))
        self.states = stepped.states
        self.timestep += 1
        self._settle(stepped.outcomes)
        return Row(t_ns, shown, strokes, noticed, states, action, stepped.rewards, stepped.outcomes)

    def _settle(self, outcomes: npt.NDArray[np.int32]) -> None:
        """Start ended robots anew, show what befell them, and switch when it is time."""
        ended = outcomes != Outcome.RUNNING
        for robot in range(self.robots):
            cue = self.cues[robot]
            if ended[robot]:
                kind = "goal" if outcomes[robot] == Outcome.GOAL else "lost"
                self.cues[robot] = Cue("goal" if kind == "goal" else "lost", 0.0, self.now_ns)
                self.episodes[robot] += 1
            elif cue is not None and self.now_ns - cue.since_ns > 1_000_000_000:
                self.cues[robot] = None
        if ended.any():
            self.states = self.task.reset(ended, self._seeds())
        due = self.timestep % self.dwell == 0 or ended[self.operated]
        if self.allocation == "assisted" and due:
            self.operated = (self.operated + 1) % self.robots
            self.switched_ns = self.now_ns


def tile_of(
    state: npt.NDArray[np.float32], robot: int = 0, cue: Cue | None = None, episode: int = 1
) -> Tile:
    """Show a state [x, y, heading, health] as a tile."""
    x, y, heading, health = map(float, state)
    return Tile(robot, x, y, heading, health, cue, episode)


def idle_policy(states: npt.NDArray[np.float32]) -> npt.NDArray[np.int32]:
    """Robots that stand still by themselves."""
    return np.full(len(states), IDLE, np.int32)


def random_policy(seed: int) -> Policy:
    """Robots that act at random."""
    random = np.random.default_rng(seed)
    return lambda states: random.integers(0, 4, len(states)).astype(np.int32)


def drive_home(operator: Operator, world: World, timesteps: int = 200) -> tuple[int, float]:
    """Run until robot 0's first episode ends; return its outcome and reward."""
    reward = 0.0
    for _ in range(timesteps):
        row = world.step(operator)
        reward += float(row.rewards[0])
        if row.outcomes[0] != Outcome.RUNNING:
            return int(row.outcomes[0]), reward
    return int(Outcome.RUNNING), reward
