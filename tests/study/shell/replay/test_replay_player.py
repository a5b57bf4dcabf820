"""The keys of a replay, in time that is handed in."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.shell.replay.marks import Marks, Span, Takeover
from study.shell.replay.player import SPEEDS, Player

SECOND = 1_000_000_000
MARKS = Marks(
    participant="P01",
    language="en",
    last_ns=100 * SECOND,
    spans=(
        Span("trial", 10 * SECOND, 40 * SECOND, "trial 1", 0, operated=True),
        Span("trial", 50 * SECOND, 80 * SECOND, "trial 2", 1, operated=True),
    ),
    takeovers=tuple(Takeover(t * SECOND, 3, "operator") for t in (12, 20, 55)),
    faults=(),
    sizes=(),
)


def paused(t_s: float) -> Player:
    """Return a player that stands still at a time, s."""
    player = Player(MARKS, round(t_s * SECOND))
    player.press("space")
    assert not player.playing
    return player


@pytest.mark.parametrize(
    ("at_s", "key", "to_s"),
    [
        (0, "n", 12), (12, "n", 20), (20, "p", 12), (56, "p", 55), (60, "n", 60), (5, "p", 5),
        (0, "t", 10), (10, "t", 50), (60, "r", 50), (50, "r", 10), (90, "t", 90),
        (20, "right", 25), (20, "left", 15), (2, "left", 0), (98, "right", 100),
        (70, "backspace", 0), (70, "x", 70),
    ],
)  # fmt: skip
def test_each_key_goes_where_it_says(at_s: float, key: str, to_s: float) -> None:
    """To the very time of the mark, and never beyond the ends."""
    player = paused(at_s)
    player.press(key)
    assert player.t_ns == to_s * SECOND


def test_playing_takes_time_by_its_speed_and_ends() -> None:
    """At the end it stands still; played again it begins anew."""
    player = Player(MARKS, 90 * SECOND)
    player.advance(2 * SECOND)
    assert player.t_ns == 92 * SECOND
    player.press("up")
    player.advance(2 * SECOND)
    assert player.t_ns == 96 * SECOND
    player.advance(5 * SECOND)
    assert (player.t_ns, player.playing) == (100 * SECOND, False)
    player.advance(SECOND)
    assert player.t_ns == 100 * SECOND
    player.press("space")
    assert (player.t_ns, player.playing) == (0, True)


def test_going_back_while_playing_passes_the_mark_just_heard() -> None:
    """Pressed twice in a row it goes back two takeovers, though time went on between."""
    player = Player(MARKS, 30 * SECOND)
    player.press("p")
    player.advance(SECOND // 3)
    player.press("p")
    assert player.t_ns == 12 * SECOND


@given(st.lists(st.sampled_from(["up", "down", "space", "left", "right", "n", "p", "t", "r"])))
def test_any_keys_stay_within_the_session(keys: list[str]) -> None:
    """Time stays between the ends and the speed one of those there are."""
    player = Player(MARKS, 15 * SECOND)
    for key in keys:
        player.press(key)
        player.advance(SECOND // 10)
        assert 0 <= player.t_ns <= MARKS.last_ns
        assert player.speed in SPEEDS
