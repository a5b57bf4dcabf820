"""The watchdog against a clock of ours."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from study.robots.link import (
    STOP_BOUND_S,
    VALID_S,
    Busy,
    Command,
    EmergencyStop,
    Goodbye,
    Hello,
    Release,
    RobotState,
    Status,
    Welcome,
)
from study.robots.watchdog import Limits, Watchdog

MS = 1_000_000
OPERATOR = b"operator"
UNLIMITED = Limits()


class Wheels:
    """Keeps what it was told."""

    def __init__(self) -> None:
        self.now = (9.0, 9.0)

    def set_velocity(self, linear: float, angular: float) -> None:
        """Take it."""
        self.now = (linear, angular)


def held(limits: Limits = UNLIMITED) -> tuple[Watchdog, Wheels]:
    """Return a watchdog held by the operator in session 1."""
    wheels = Wheels()
    watchdog = Watchdog(wheels, lambda: 0.7, limits)
    assert isinstance(watchdog.hear(OPERATOR, Hello(1), 0), Welcome)
    return watchdog, wheels


def command(sequence: int, sent_ns: int, linear: float = 0.2) -> Command:
    """Return a command of session 1."""
    return Command(1, sequence, sent_ns, linear, 0.0)


def test_it_stands_until_told() -> None:
    """A new agent stops its motors at once, and drives for nobody unknown."""
    wheels = Wheels()
    watchdog = Watchdog(wheels, lambda: 1.0)
    assert wheels.now == (0.0, 0.0)
    assert watchdog.hear(b"somebody", command(1, 0), 0) is None
    assert wheels.now == (0.0, 0.0)


def test_silence_stops_it() -> None:
    """After the last command it drives for `VALID_S` and no longer."""
    watchdog, wheels = held()
    watchdog.hear(OPERATOR, command(1, 0), 0)
    watchdog.tick(int(VALID_S * 1e9) - 1)
    assert wheels.now == (0.2, 0.0)
    assert watchdog.tick(int(VALID_S * 1e9))
    assert wheels.now == (0.0, 0.0)
    status = watchdog.status(int(VALID_S * 1e9))
    assert status.state == RobotState.SILENT
    assert VALID_S < STOP_BOUND_S


def test_older_commands_are_ignored() -> None:
    """Reordered and repeated commands do nothing, and are counted."""
    watchdog, wheels = held()
    watchdog.hear(OPERATOR, command(5, 0, 0.2), 0)
    for sequence in (4, 5, 1):
        assert watchdog.hear(OPERATOR, command(sequence, 0, 0.4), MS) is None
    assert wheels.now == (0.2, 0.0)
    assert watchdog.status(MS).ignored == 3


def test_a_burst_after_a_stall_does_not_move_it() -> None:
    """What was held up on the way is too old when it comes, though its numbers are new."""
    watchdog, wheels = held()
    watchdog.hear(OPERATOR, command(1, 0), 5 * MS)
    watchdog.tick(900 * MS)
    for number in range(2, 20):
        watchdog.hear(OPERATOR, command(number, 40 * MS * (number - 1)), 1000 * MS)
        if 40 * (number - 1) + 5 + 180 <= 1000:
            assert wheels.now == (0.0, 0.0)
    assert watchdog.status(1000 * MS).ignored > 10


def test_clocks_need_not_agree() -> None:
    """The operator's clock may be hours off; a slow drift is followed."""
    watchdog, wheels = held()
    hour = 3_600_000 * MS
    for number in range(1, 60_000):
        now = 40 * MS * number
        assert watchdog.hear(OPERATOR, command(number, 7 * hour + int(now * (1 - 1e-4))), now)
    assert wheels.now == (0.2, 0.0)


def test_an_emergency_lasts_until_released() -> None:
    """Anybody let in can stop it; commands do not move it; nor does the release alone."""
    watchdog, wheels = held()
    watchdog.hear(OPERATOR, command(1, 0), 0)
    stopped = watchdog.hear(b"another", EmergencyStop(2), MS)
    assert isinstance(stopped, Status)
    assert stopped.state == RobotState.EMERGENCY
    watchdog.hear(OPERATOR, command(2, 2 * MS), 2 * MS)
    watchdog.hear(OPERATOR, command(3, 4 * MS), 4 * MS)
    assert wheels.now == (0.0, 0.0)
    watchdog.hear(OPERATOR, Goodbye(1), 5 * MS)
    watchdog.hear(OPERATOR, Hello(3), 6 * MS)
    watchdog.hear(OPERATOR, Command(3, 1, 7 * MS, 0.2, 0.0), 7 * MS)
    assert wheels.now == (0.0, 0.0)
    watchdog.hear(OPERATOR, Release(3), 8 * MS)
    assert wheels.now == (0.0, 0.0)
    watchdog.hear(OPERATOR, Command(3, 2, 9 * MS, 0.2, 0.0), 9 * MS)
    assert wheels.now == (0.2, 0.0)


def test_one_operator_at_a_time() -> None:
    """A second one is refused while the first is heard, and served once that one is silent."""
    watchdog, wheels = held()
    watchdog.hear(OPERATOR, command(1, 0), 0)
    assert watchdog.hear(b"second", Hello(2), MS) == Busy(2)
    watchdog.hear(b"second", Command(2, 9, MS, -0.4, 0.0), MS)
    assert wheels.now == (0.2, 0.0)
    assert isinstance(watchdog.hear(b"second", Hello(2), 200 * MS), Welcome)
    assert wheels.now == (0.0, 0.0)
    watchdog.hear(OPERATOR, command(2, 200 * MS), 200 * MS)
    assert wheels.now == (0.0, 0.0)


def test_speeds_are_limited() -> None:
    """A robot that may be slower than the protocol is."""
    watchdog, wheels = held(Limits(0.1, 1.0))
    watchdog.hear(OPERATOR, Command(1, 1, 0, 0.5, -4.0), 0)
    assert wheels.now == (0.1, -1.0)


@given(
    st.lists(
        st.tuples(st.integers(1, 400), st.integers(0, 400), st.booleans()), min_size=1, max_size=60
    )
)
def test_it_never_drives_longer_than_the_bound(steps: list[tuple[int, int, bool]]) -> None:
    """Whatever is dropped, delayed or reordered: no motion without a command sent just before.

    The first command defines what is no delay.
    """
    watchdog, wheels = held()
    watchdog.hear(OPERATOR, command(1, 0), 0)
    arrivals = []
    sent = 0
    for number, (gap, delay, dropped) in enumerate(steps, start=2):
        sent += gap * MS
        if not dropped:
            arrivals.append((sent + delay * MS, number, sent))
    newest = 0
    for arrived, number, sent in sorted(arrivals):
        watchdog.tick(arrived)
        if wheels.now != (0.0, 0.0):
            assert arrived - newest < VALID_S * 1e9 + 2e-4 * arrived
        if isinstance(watchdog.hear(OPERATOR, command(number, sent), arrived), Status):
            newest = max(newest, sent)
        if wheels.now != (0.0, 0.0):
            assert arrived - newest < VALID_S * 1e9 + 2e-4 * arrived
