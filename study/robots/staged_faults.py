"""Faults of a twin's robots, made by lines of words, for rehearsals."""

from __future__ import annotations

import math

from study.arena.physics import ArenaPhysics
from study.errors import StudyError

LINES = (
    "camera_frozen ROBOT on|off, camera_dead ROBOT on|off, pose_lost ROBOT on|off, "
    "battery ROBOT LEVEL, put ROBOT X Y HEADING, quit"
)
"""What may be said."""


class StagedFaults:
    """What is wrong with which robot; all robots by their index from 0.

    Args:
        physics: of the robots, which can be put elsewhere.
        robots: number of robots.

    Attributes:
        unseen: robots that motion capture does not see.
        frozen: robots whose camera repeats its last picture.
        dead: robots whose camera takes no pictures.
        batteries: levels, 0 (flat) to 1 (full) [n].
    """

    def __init__(self, physics: ArenaPhysics, robots: int) -> None:
        self._physics = physics
        self.unseen: set[int] = set()
        self.frozen: set[int] = set()
        self.dead: set[int] = set()
        self.batteries = [1.0] * robots

    def command(self, line: str) -> bool:
        """Carry out a line, in which robots are numbered from 1, as on the screen.

        Returns:
            False if it says to quit.

        Raises:
            StudyError: it is none of `LINES`.
        """
        try:
            match line.split():
                case []:
                    return True
                case ["quit"]:
                    return False
                case ["camera_frozen" | "camera_dead" | "pose_lost" as fault, robot, switch]:
                    faults = {
                        "camera_frozen": self.frozen,
                        "camera_dead": self.dead,
                        "pose_lost": self.unseen,
                    }[fault]
                    {"on": faults.add, "off": faults.discard}[switch](self._robot(robot))
                case ["battery", robot, level]:
                    self.batteries[self._robot(robot)] = min(1.0, max(0.0, _number(level)))
                case ["put", robot, x, y, heading]:
                    self._physics.put(self._robot(robot), *map(_number, (x, y, heading)))
                case _:
                    raise ValueError
        except (ValueError, KeyError) as error:
            raise StudyError(
                f'the twin does not know "{line.strip()}"',
                f"Lines are {LINES}; ROBOT is 1 to {len(self.batteries)}.",
            ) from error
        return True

    def _robot(self, word: str) -> int:
        number = int(word)
        if not 1 <= number <= len(self.batteries):
            raise ValueError
        return number - 1


def _number(word: str) -> float:
    number = float(word)
    if not math.isfinite(number):
        raise ValueError
    return number
