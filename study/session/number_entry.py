"""Robots chosen by number: one key a robot, or two digits where there are more robots than keys."""

from __future__ import annotations

SECOND_DIGIT_NS = 400_000_000
"""How long a first digit waits for a second one."""


class NumberEntry:
    """Turns keys into robots.

    With no more robots than keys each robot has a key. With more, numbers are typed: a digit
    that can begin no larger number chooses at once, others wait for a second digit for
    `SECOND_DIGIT_NS`; 0 before a digit chooses without waiting.

    Args:
        keys: names of the keys that choose robots 1, 2, ...
        robots: n.
    """

    def __init__(self, keys: tuple[str, ...], robots: int) -> None:
        self._robots = robots
        self._direct = {key: robot for robot, key in enumerate(keys[:robots])}
        self.typed = robots > len(keys)
        self._first = -1
        self._first_ns = 0

    def press(self, key: str, t_ns: int) -> tuple[int, ...]:
        """A key went down; return the robots (from 0) chosen by it, in order; most often one.

        A first digit whose time is up chooses its own robot before the key is looked at.
        """
        if not self.typed:
            robot = self._direct.get(key, -1)
            return (robot,) if robot >= 0 else ()
        due = self.due(t_ns)
        if not (len(key) == 1 and key.isascii() and key.isdecimal()):
            return due
        digit = int(key)
        if self._first >= 0:
            number, self._first = 10 * self._first + digit, -1
            return (*due, *self._chosen(number))
        if 10 * digit <= self._robots:
            self._first, self._first_ns = digit, t_ns
            return due
        return (*due, *self._chosen(digit))

    def due(self, t_ns: int) -> tuple[int, ...]:
        """Time went on; return the robot of a first digit that has waited long enough."""
        if self._first < 0 or t_ns - self._first_ns < SECOND_DIGIT_NS:
            return ()
        number, self._first = self._first, -1
        return self._chosen(number)

    def forget(self) -> None:
        """Drop a digit that waits."""
        self._first = -1

    def _chosen(self, number: int) -> tuple[int, ...]:
        return (number - 1,) if 1 <= number <= self._robots else ()
