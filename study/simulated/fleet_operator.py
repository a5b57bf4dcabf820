"""Before a fleet: driving one robot while keeping an eye on the others."""

from __future__ import annotations

import math

import numpy as np

from study.screens import FleetScreen, Tile
from study.simulated.attention import Glances, Memory
from study.simulated.driving import CorrectionMonitor
from study.simulated.keys import DrivingHand, KeyStroke, number_keys, tap
from study.simulated.parameters import OperatorParameters
from study.simulated.ratings import Experience
from study.simulated.ways import Skill, Way

_UNMET_NEED = 0.4
_PATIENCE_NS = 600_000_000


class FleetOperator:
    """Drives the operated robot, and chooses another where the choice is its own.

    Args:
        parameters: what makes it differ from others.
        random: its stream.
        skill: how it reads the map and drives.

    Attributes:
        noticed: robots looked at in the latest call of `act`, the operated one included.
    """

    def __init__(
        self,
        parameters: OperatorParameters,
        random: np.random.Generator,
        skill: Skill,
    ) -> None:
        self._parameters = parameters
        self._random = random
        self._hand = DrivingHand()
        self._skill = skill
        self._monitor = CorrectionMonitor(parameters)
        self._glances = Glances(parameters, random)
        self._memory = Memory(parameters, 0)
        self._seen: tuple[int, int, int] | None = None
        self._run: tuple[str, int, int] | None = None
        self._timestep = -1
        self._acted_ns = 0
        self.noticed: tuple[int, ...] = ()
        self._begin_run(0, 0)

    def leave(self) -> tuple[KeyStroke, ...]:
        """Let go of the keys: no fleet is shown."""
        self.noticed = ()
        self._seen = None
        self._run = None
        return self._hand.hold("")

    def act(
        self, screen: FleetScreen, experience: Experience, now_ns: int
    ) -> tuple[KeyStroke, ...]:
        """Return the keys pressed and released at one timestep.

        Args:
            screen: the fleet as shown.
            experience: where what happens is added up.
            now_ns: session time.
        """
        self.noticed = ()
        seen = (screen.t_ns, screen.operated, screen.switched_ns)
        if seen == self._seen:
            return ()
        self._seen = seen
        run = (screen.heading, screen.trial, screen.robots)
        if run != self._run or screen.timestep < self._timestep:
            self._run = run
            self._begin_run(screen.robots, now_ns)
        else:
            experience.driven_ns += now_ns - self._acted_ns
            if now_ns < self._oriented_ns:
                experience.reorienting_ns += now_ns - self._acted_ns
        self._timestep, self._acted_ns = screen.timestep, now_ns
        if screen.allocation == "none":
            return self._hand.hold("")
        plan = self._skill.read(screen)
        own = _tile_of(screen)
        strokes = self._notice_switch(plan, own, screen, now_ns)
        if own is not None:
            self.noticed = (own.robot,)
            self._memory.look(plan, own, now_ns)
            experience.see_ending(own)
        if screen.allocation in {"manual", "suggested"} and screen.view != "operated_only":
            strokes += self._choose(plan, screen, experience, now_ns)
        # Once a number is pressed, the hand waits for the new robot.
        if own is None or self._pressed or now_ns < self._oriented_ns:
            return strokes + self._hand.hold("")
        if screen.allocation == "correction" and not self._monitor.update(plan, own, now_ns):
            return strokes + self._hand.hold("")
        return strokes + self._hand.hold(self._skill.key(own))

    def _begin_run(self, robots: int, now_ns: int) -> None:
        self._memory = Memory(self._parameters, robots)
        self._glances.begin(robots, now_ns)
        self._operated: tuple[int, int, int] | None = None
        self._oriented_ns = now_ns
        self._target = -1
        self._press_ns = 0
        self._given_up_ns = 0
        self._pressed = False
        self._need_at_switch = 0.0
        self._effort_at_switch = 0.0

    def _notice_switch(
        self, plan: Way, own: Tile | None, screen: FleetScreen, now_ns: int
    ) -> tuple[KeyStroke, ...]:
        """Let go and find one's way in when another robot, or a new episode, is operated."""
        episode = own.episode if own is not None else -1
        operated = (screen.operated, screen.switched_ns, episode)
        if operated == self._operated:
            return ()
        self._operated = operated
        self._skill.begin()
        self._monitor.begin(now_ns)
        if own is None:
            return self._hand.hold("")
        self._oriented_ns = now_ns + round(self._parameters.reorientation_s * 1e9)
        self._glances.postpone(self._oriented_ns)
        self._target, self._pressed = -1, False
        self._need_at_switch = self._memory.need(own.robot, now_ns)
        impression = self._memory.look(plan, own, now_ns)
        impression.take_over(now_ns)
        self._effort_at_switch = impression.effort
        return self._hand.hold("")

    def _choose(
        self, plan: Way, screen: FleetScreen, experience: Experience, now_ns: int
    ) -> tuple[KeyStroke, ...]:
        """Look around, decide, and press a number when the hand has found it."""
        if self._target >= 0:
            return self._press(screen, experience, now_ns)
        noticed = self._glances.take(screen, now_ns)
        if noticed is None:
            return ()
        for tile in noticed:
            impression = self._memory.look(plan, tile, now_ns)
            experience.see_ending(tile)
            experience.looks += 1
            experience.unmet += impression.need > _UNMET_NEED
        self.noticed += tuple(tile.robot for tile in noticed)
        if noticed:
            self._target = self._decide(screen, now_ns)
            self._press_ns = now_ns + round(self._parameters.motor_delay_s * 1e9)
        return ()

    def _decide(self, screen: FleetScreen, now_ns: int) -> int:
        """Return the robot to go to, or -1 to stay: a Luce choice on needs."""
        parameters = self._parameters
        robots, needs = [], []
        shown = {tile.robot for tile in screen.tiles}
        for robot, impression in enumerate(self._memory.impressions):
            if impression is None or impression.unavailable or robot == screen.operated:
                continue
            if robot not in shown:
                continue
            trusted = parameters.suggestion_trust if robot == screen.suggested else 0.0
            robots.append(robot)
            needs.append(self._memory.need(robot, now_ns) + trusted)
        if screen.operated >= 0:
            robots.append(-1)
            needs.append(self._own_need(screen.operated) + parameters.switching_cost)
        if not robots:
            return -1
        highest = max(needs)
        weights = [math.exp((need - highest) / parameters.temperature) for need in needs]
        mark = self._random.random() * sum(weights)
        for robot, weight in zip(robots, weights, strict=True):
            mark -= weight
            if mark < 0.0:
                return robot
        return robots[-1]

    def _own_need(self, operated: int) -> float:
        """Return how badly the operated robot still needs its driver.

        The need that it was taken over for fades as it is driven past its trouble; a
        danger in view counts as for any other robot. What remains is small when it could
        go on by itself, so it is handed over before it is home.
        """
        impression = self._memory.impressions[operated]
        if impression is None:
            return self._need_at_switch
        gained = (self._effort_at_switch - impression.effort) / self._parameters.help_distance_m
        carried = self._need_at_switch * (1.0 - min(1.0, max(0.0, gained)))
        return max(carried, impression.need)

    def _press(
        self, screen: FleetScreen, experience: Experience, now_ns: int
    ) -> tuple[KeyStroke, ...]:
        """Press the chosen robot's key once the hand is there; give up if it does nothing."""
        if now_ns < self._press_ns:
            return ()
        if self._pressed and now_ns - self._press_ns > _PATIENCE_NS:
            impression = self._memory.impressions[self._target]
            if impression is not None:
                impression.unavailable = True
            self._target, self._pressed = -1, False
            return ()
        if self._pressed:
            return ()
        experience.choices += 1
        self._pressed = True
        keys = number_keys(self._target, screen.robots)
        if self._target == screen.suggested:
            keys = (screen.accept_key,)
        strokes = self._hand.hold("")
        for key in keys:
            strokes += tap(key)
        return strokes


def _tile_of(screen: FleetScreen) -> Tile | None:
    """Return the operated robot's tile, or None if no robot is operated."""
    operated = screen.operated
    if operated < 0:
        return None
    if operated < len(screen.tiles) and screen.tiles[operated].robot == operated:
        return screen.tiles[operated]
    return next((tile for tile in screen.tiles if tile.robot == operated), None)
