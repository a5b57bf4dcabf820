"""Laps: counted by gates passed in order, so that going back and forth earns nothing.

A robot that goes back through the gate it passed last has to pass it again. Gates out of order
count nothing, backwards through the finish line neither. So between two laps lies one whole way
round, through every gate forwards, wherever else the robot has been.
"""

from __future__ import annotations

import dataclasses

from study.arena.course import Course, Gate

LONGEST_MOVE = 0.5
"""Metres between two poses beyond which no gate counts: robots do not jump, they are carried."""


@dataclasses.dataclass(frozen=True, slots=True)
class Progress:
    """How far a robot is.

    Attributes:
        passed: gates passed since the last lap, 0 to one less than the course has.
        laps: whole ones.
    """

    passed: int = 0
    laps: int = 0


def advance(
    course: Course, progress: Progress, before: tuple[float, float], now: tuple[float, float]
) -> Progress:
    """Return the progress after a move in a straight line.

    Args:
        course: with its gates in order.
        progress: before the move.
        before: x and y, metres.
        now: x and y, metres.
    """
    (x, y), (to_x, to_y) = before, now
    if (to_x - x) ** 2 + (to_y - y) ** 2 > LONGEST_MOVE**2:
        return progress
    crossed: list[tuple[float, int, int]] = []
    for number, gate in enumerate(course.gates):
        if found := _crossing(gate, before, now):
            crossed.append((found[0], number, found[1]))
    passed, laps, last = progress.passed, progress.laps, len(course.gates) - 1
    # One move can pass two gates only near their inner ends; the order is then that on the way.
    for _, number, direction in sorted(crossed):
        if direction > 0 and number == passed:
            if passed == last:
                passed, laps = 0, laps + 1
            else:
                passed += 1
        elif direction < 0 and number == passed - 1:
            passed -= 1
    return Progress(passed, laps)


def _crossing(
    gate: Gate, before: tuple[float, float], now: tuple[float, float]
) -> tuple[float, int] | None:
    """Return where on the move (0 to 1) a gate is crossed, and 1 for forwards, -1 for back.

    On the line counts as beyond it: a robot that stops there and goes on crosses once.
    """
    along_x, along_y = gate.outer_x - gate.inner_x, gate.outer_y - gate.inner_y

    def side(place: tuple[float, float]) -> float:
        return along_x * (place[1] - gate.inner_y) - along_y * (place[0] - gate.inner_x)

    first, last = side(before), side(now)
    if (first < 0) == (last < 0):
        return None
    at = first / (first - last)
    x = before[0] + at * (now[0] - before[0]) - gate.inner_x
    y = before[1] + at * (now[1] - before[1]) - gate.inner_y
    length = along_x**2 + along_y**2
    if not 0 <= x * along_x + y * along_y <= length:
        return None
    return at, 1 if first < 0 else -1
