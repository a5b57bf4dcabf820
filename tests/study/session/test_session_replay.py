"""The session under any inputs: it never fails, its books agree, and its events replay."""

from __future__ import annotations

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from event_books import check_books
from fake_shell import STEP_NS, FakeShell, Moods, replayed
from short_study import opened, short_study
from study.events.events import SessionEnded, Timestep
from study.events.inputs import (
    FitFailed,
    FitTimedOut,
    FocusChanged,
    QuitRequested,
    TimestepDue,
)
from study.session.effects import StepFleet
from study.training_sets import choice_sets

KEYS = [
    *"1234590qyx",
    "tab",
    "up",
    "down",
    "left",
    "right",
    "return",
    "backspace",
    "escape",
    "",
    "ä",
]
TARGETS = ["", "confirm", "back", "continue", "stop", "robot:0", "robot:4", "robot:99", "robot:x"]
TARGETS += ["robot:-1", "answer:q1:5", "answer:q2:9", "answer:q9:1", "focus:q2", "answer:q1:"]

COMMANDS = ["pause", "pause", "resume", "annotate", "end", "", "dance"]
wild_moves = st.one_of(
    st.tuples(st.just("command"), st.sampled_from(COMMANDS), st.booleans()),
    st.tuples(st.just("key"), st.sampled_from(KEYS), st.booleans()),
    st.tuples(st.just("point"), st.sampled_from(TARGETS), st.just(False)),
    st.tuples(
        st.sampled_from(
            [
                *["focus", "due", "answer", "stale", "fit", "stale fit", "help", "wait"],
                *["interrupt", "restore"],
            ]
        ),
        st.just(""),
        st.booleans(),
    ),
)
moods = st.builds(
    Moods,
    end_chance=st.sampled_from([0.0, 0.1, 0.6]),
    odd_chance=st.sampled_from([0.0, 0.3]),
    lawful=st.booleans(),
    fits=st.lists(
        st.sampled_from(["completed", "completed", "failed", "timed out"]), min_size=1
    ).map(tuple),
)


def make(shell: FakeShell, kind: str, what: str, yes: bool) -> None:
    """Do one wild thing."""
    if kind == "key":
        shell.key(what, down=yes)
    elif kind == "point":
        shell.point(what)
    elif kind == "command":
        shell.command(what, "a reason, <b>or</b> a note" if yes else "")
    elif kind == "focus":
        shell.feed(FocusChanged(shell.later(), yes))
    elif kind == "due":
        shell.feed(TimestepDue(shell.later(), late_ns=5))
    elif kind == "answer" and shell.fleet:
        shell.answer_fleet()
    elif kind == "stale" and isinstance(shell.fleet, StepFleet):
        shell.feed(shell.made_up(shell.fleet, request_id=shell.fleet.request_id - 1))
    elif kind == "fit" and shell.fit:
        shell.answer_fit()
    elif kind == "stale fit":
        answer = FitFailed if yes else FitTimedOut
        shell.feed(answer(shell.later(), 9999, "late" if yes else 1.0))  # type: ignore[arg-type]
    elif kind == "interrupt":
        shell.interrupt()
    elif kind == "restore":
        shell.restore()
    elif kind == "wait":
        shell.later(7 * STEP_NS)
    else:
        shell.help()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(max_examples=60, phases=[Phase.explicit, Phase.generate])
@given(
    seed=st.integers(0, 2**63 - 1),
    moods=moods,
    stay=st.booleans(),
    moves=st.lists(st.tuples(st.integers(0, 25), wild_moves), max_size=60),
    ending=st.sampled_from(["open", "quit", "complete"]),
)
def test_any_inputs_replay_byte_for_byte(
    seed: int,
    moods: Moods,
    stay: bool,
    moves: list[tuple[int, tuple[str, str, bool]]],
    ending: str,
) -> None:
    """No input sequence raises, the books agree, and inputs over the wire give equal events."""
    changes = (('on_end = "reset"', 'on_end = "stay"'),) if stay else ()
    loaded = short_study(*changes)
    shell = FakeShell(opened(loaded, seed=seed), seed % 1000, moods)
    for helped, (kind, what, yes) in moves:
        for _ in range(helped):
            shell.help()
        make(shell, kind, what, yes)
    if ending == "quit":
        shell.feed(QuitRequested(shell.later(), "SIGTERM"))
    elif ending == "complete":
        shell.go_on_until(lambda: shell.finished)
    check_books(shell.events, loaded.description.idle_action, lawful=moods.lawful)
    assert replayed(shell.inputs) == shell.log
    if ending != "open":
        assert isinstance(shell.events[-1], SessionEnded)
        assert shell.session.finished
        assert shell.feed(TimestepDue(shell.later(), 0)) == ()
    rows = [event for event in shell.events if isinstance(event, Timestep)]
    sets = choice_sets(rows, 3, 4)
    assert all(sets.available[row, robot] for row, robot in enumerate(sets.chosen))


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_undisturbed_session_is_complete(seed: int) -> None:
    """A participant who only confirms and waits passes every stage."""
    loaded = short_study()
    shell = FakeShell(opened(loaded, seed=seed), seed, Moods())
    shell.go_on_until(lambda: shell.finished)
    last = shell.events[-1]
    assert isinstance(last, SessionEnded)
    assert last.complete
    assert shell.session.complete
