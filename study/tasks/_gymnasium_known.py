"""What Gymnasium's own environments do not say of themselves, from their documentation.

An environment names neither its actions nor its observations, nor what it means that an episode
is over. A protocol can say so for any; for these it need not.
"""

from __future__ import annotations

import dataclasses
from typing import Literal

Termination = Literal["goal", "lost", "goal_if_rewarded"]
WAIT = "wait"


@dataclasses.dataclass(frozen=True, slots=True)
class Known:
    """What is known of an environment.

    Attributes:
        actions: names by action number.
        keys: direction or key to action number.
        without_key: the action that does nothing; -1 if there is none.
        termination: what it means that an episode ends.
        fields: names of the observation's numbers; empty for a number of a state.
        instruction: one sentence on what is to be done.
        aspect: width of a picture over its height.
    """

    actions: tuple[str, ...]
    keys: dict[str, int]
    without_key: int
    termination: Termination
    fields: tuple[str, ...]
    instruction: str
    aspect: float


KNOWN = {
    "CartPole": Known(
        actions=("push left", "push right"),
        keys={"left": 0, "right": 1},
        without_key=-1,
        termination="lost",
        fields=("cart position", "cart velocity", "pole angle", "pole angular velocity"),
        instruction="Keep the pole upright, and the cart on its track.",
        aspect=1.5,
    ),
    "MountainCar": Known(
        actions=("push left", "no push", "push right"),
        keys={"left": 0, "right": 2},
        without_key=1,
        termination="goal",
        fields=("position", "velocity"),
        instruction="Bring the car up to the flag: it has to gather speed first.",
        aspect=1.5,
    ),
    "Acrobot": Known(
        actions=("turn the joint one way", "no torque", "turn the joint the other way"),
        keys={"left": 0, "right": 2},
        without_key=1,
        termination="goal",
        fields=(
            "cosine of angle 1", "sine of angle 1", "cosine of angle 2", "sine of angle 2",
            "angular velocity 1", "angular velocity 2",
        ),
        instruction="Swing the lower end of the two links above the line.",
        aspect=1.0,
    ),
    "FrozenLake": Known(
        actions=("step left", "step down", "step right", "step up"),
        keys={"left": 0, "down": 1, "right": 2, "up": 3},
        without_key=-1,
        termination="goal_if_rewarded",
        fields=(),
        instruction="Cross the ice to the goal without falling into a hole.",
        aspect=1.0,
    ),
    "CliffWalking": Known(
        actions=("step up", "step right", "step down", "step left"),
        keys={"up": 0, "right": 1, "down": 2, "left": 3},
        without_key=-1,
        termination="goal",
        fields=(),
        instruction="Walk to the goal, and keep off the cliff: a fall begins anew, and costs.",
        aspect=3.0,
    ),
    "Taxi": Known(
        actions=("drive down", "drive up", "drive right", "drive left", "pick up", "drop off"),
        keys={"down": 0, "up": 1, "right": 2, "left": 3, "p": 4, "d": 5},
        without_key=-1,
        termination="goal",
        fields=(),
        instruction="Fetch the passenger, and drop them off where they want to go.",
        aspect=550 / 350,
    ),
    "Blackjack": Known(
        actions=("stick", "hit"),
        keys={"left": 0, "right": 1},
        without_key=-1,
        termination="goal_if_rewarded",
        fields=(),
        instruction="Come closer to 21 than the dealer without going over.",
        aspect=384 / 376,
    ),
    "LunarLander": Known(
        actions=("nothing", "left engine", "main engine", "right engine"),
        keys={"left": 1, "up": 2, "right": 3},
        without_key=0,
        termination="goal_if_rewarded",
        fields=(
            "x", "y", "velocity in x", "velocity in y", "angle", "angular velocity",
            "left leg touches", "right leg touches",
        ),
        instruction="Land softly between the flags.",
        aspect=1.5,
    ),
}  # fmt: skip
"""By the environment's name without its version."""

DIRECTIONS = ("left", "up", "right", "down")
LETTERS = "qwertzuiopasdfghjklxcvbnm"
MEANT = {"UP": "up", "DOWN": "down", "LEFT": "left", "RIGHT": "right", "FIRE": "f"}
"""Keys for what some environments, as those of the arcade machine, call their actions."""
NOTHING = "NOOP"


def default_keys(names: tuple[str, ...], without_key: int) -> dict[str, int]:
    """Return keys for the actions of an environment that nothing is known of.

    Names that are directions get their arrows; else the first actions get the arrows. All
    others get letters, in the order of the keyboard.
    """
    keys = {MEANT[name]: action for action, name in enumerate(names) if name in MEANT}
    directions = () if keys else DIRECTIONS
    free = [key for key in (*directions, *LETTERS) if key not in keys]
    rest = [
        action
        for action in range(len(names))
        if action not in keys.values() and action != without_key
    ]
    if not keys and len(rest) == 2:
        # Two actions lie beside each other.
        free = ["left", "right"]
    return {**keys, **dict(zip(free, rest, strict=False))}
