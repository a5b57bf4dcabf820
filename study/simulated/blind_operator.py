"""Before pictures that it cannot read: somebody who holds keys, and changes them now and then.

It sees pictures of tasks that nobody taught it. So it drives at random, with the keys that the
header names, and takes over one robot after another. A session with it shows that everything
works; its results mean nothing.
"""

from __future__ import annotations

import numpy as np

from study.screens import FleetScreen
from study.simulated.keys import DrivingHand, KeyStroke, number_keys, tap
from study.simulated.ratings import Experience

_HOLDS_S = 0.5
"""How long a key is held on average."""
_STAYS_S = 3.0
"""How long it stays with a robot on average."""
_CORRECTS = 0.5
"""Share of the time for which it corrects a robot that drives itself."""


class BlindOperator:
    """Presses driving keys at random, and chooses robots at random.

    Args:
        random: its stream.

    Attributes:
        noticed: the robot operated, if any.
    """

    def __init__(self, random: np.random.Generator) -> None:
        self._random = random
        self._hand = DrivingHand()
        self._seen: tuple[int, int, int] | None = None
        self._switched_ns = -2
        self.noticed: tuple[int, ...] = ()

    def leave(self) -> tuple[KeyStroke, ...]:
        """Let go of the keys: no fleet is shown."""
        self.noticed = ()
        self._seen = None
        return self._hand.hold("")

    def act(
        self, screen: FleetScreen, experience: Experience, now_ns: int
    ) -> tuple[KeyStroke, ...]:
        """Return the keys pressed and released at one timestep.

        Args:
            screen: the fleet as shown.
            experience: where choices are counted.
            now_ns: session time.
        """
        del now_ns
        seen = (screen.t_ns, screen.operated, screen.switched_ns)
        if seen == self._seen:
            return ()
        self._seen = seen
        self.noticed = (screen.operated,) if screen.operated >= 0 else ()
        if screen.allocation == "none":
            return self._hand.hold("")
        strokes: tuple[KeyStroke, ...] = ()
        if screen.switched_ns != self._switched_ns:
            # What is held across a switch does not act until it is pressed again.
            self._switched_ns = screen.switched_ns
            strokes = self._hand.hold("")
        if screen.allocation in ("manual", "suggested") and screen.view != "operated_only":
            chosen = self._chosen(screen)
            if chosen:
                experience.choices += 1
                return (*strokes, *self._hand.hold(""), *chosen)
        if screen.operated < 0:
            return strokes + self._hand.hold("")
        if self._hand.held and not self._happens(screen, _HOLDS_S):
            return strokes
        return strokes + self._hand.hold(self._key(screen))

    def _chosen(self, screen: FleetScreen) -> tuple[KeyStroke, ...]:
        """Return the keys that choose another robot, if it is time to."""
        others = [tile.robot for tile in screen.tiles if tile.robot != screen.operated]
        if not others or (screen.operated >= 0 and not self._happens(screen, _STAYS_S)):
            return ()
        robot = others[int(self._random.integers(len(others)))]
        if robot == screen.suggested:
            return tap(screen.accept_key)
        keys = number_keys(robot, screen.robots)
        return tuple(stroke for key in keys for stroke in tap(key))

    def _key(self, screen: FleetScreen) -> str:
        if screen.allocation == "correction" and self._random.random() >= _CORRECTS:
            return ""
        keys = screen.keys[0][0].split()
        return keys[int(self._random.integers(len(keys)))]

    def _happens(self, screen: FleetScreen, seconds: float) -> bool:
        """Return whether what happens about every so many seconds happens now."""
        return bool(self._random.random() < screen.timestep_seconds / seconds)
