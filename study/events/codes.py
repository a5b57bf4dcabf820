"""Small closed sets of values that records hold as integers."""

from __future__ import annotations

from enum import IntEnum


class Outcome(IntEnum):
    """How a robot stands after a timestep; anything but RUNNING ends its episode."""

    RUNNING = 0
    GOAL = 1
    LOST = 2
    TIME_UP = 3


class ActionSource(IntEnum):
    """Who decided a robot's executed action."""

    POLICY = 0
    OPERATOR = 1
    OPERATOR_IDLE = 2
    """The operator holds the robot but no key: it stands still. Not a demonstration."""
    INACTIVE = 3
    """The robot had ended and was not stepped."""


class ChoiceSource(IntEnum):
    """Who decided which robot is operated."""

    NONE = 0
    """There is nothing to choose: one robot only, or nobody operates."""
    OPERATOR = 1
    SCORER = 2
    ACCEPTED_SUGGESTION = 3


class ChoiceFlag(IntEnum):
    """Why a choice row may not be fitted."""

    USABLE = 0
    BEFORE_FIRST_SELECTION = 1
    CYCLING = 2
    """The robot is being passed on the way to another one (Tab) and was not driven."""
    NO_CHOICE = 3
    """One robot only, or nobody operates."""


class Phase(IntEnum):
    """The paper's four phases; practice stands before them."""

    PRACTICE = 0
    ONE = 1
    TWO = 2
    THREE = 3
    FOUR = 4
