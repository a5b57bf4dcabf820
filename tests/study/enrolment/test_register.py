"""What the register does with each thing that can happen to a participant."""

from __future__ import annotations

import sqlite3
from collections import Counter
from contextlib import closing
from pathlib import Path

import pytest

from study.enrolment import editing
from study.enrolment.participants import Participant
from study.enrolment.process_identity import ProcessIdentity
from study.enrolment.pseudonyms import check_participant, draw_pseudonym, looks_like_a_name
from study.enrolment.register import Register
from study.errors import StudyError
from study.orders import possible_orders
from study.recording.enrolled import planned_orders

AB, BA = ("a", "b"), ("b", "a")


def here(folder: Path, pid: int = 1, dead: tuple[int, ...] = ()) -> Register:
    """Open the register as some process; ``dead`` ones have ended."""
    me = ProcessIdentity("here", pid, "x")
    return Register(folder, me=me, alive=lambda process: process.pid not in dead)


def through(register: Register, pseudonym: str, state: str = "complete") -> Participant:
    """Run a session to an end."""
    register.reserve("s", [AB, BA], pseudonym=pseudonym)
    register.start("s", pseudonym)
    register.finish("s", pseudonym, state, "a reason")  # type: ignore[arg-type]
    known = register.find("s", pseudonym)
    assert known is not None
    return known


def test_pseudonyms_are_random_and_never_names() -> None:
    """Each can be used, holds a digit, and says nothing of the order in which people came."""
    drawn: set[str] = set()
    for _ in range(300):
        drawn.add(draw_pseudonym(drawn.__contains__))
    assert len(drawn) == 300
    assert all(check_participant(each) == each for each in drawn)
    assert not any(looks_like_a_name(each) for each in drawn)
    with pytest.raises(StudyError, match="no pseudonym is left"):
        draw_pseudonym(lambda _: True)


@pytest.mark.parametrize(
    ("given", "expected"),
    [("Anna", True), ("anna-smith", True), ("Smith_J", True), ("P01", False), ("AB", False)],
)
def test_ids_that_look_like_names(given: str, expected: bool) -> None:
    """Letters without a digit may be a name; initials and codes are not told from one another."""
    assert looks_like_a_name(given) == expected


def test_a_drop_out_is_repaired(tmp_path: Path) -> None:
    """The slot of who dropped out, and the order, go to the next."""
    with here(tmp_path) as register:
        first = through(register, "P1")
        second = through(register, "P2", "dropped")
        assert (first.order, second.order, second.slot) == (AB, BA, 2)
        third = register.reserve("s", [AB, BA])
        assert (third.slot, third.order) == (2, BA)


@pytest.mark.parametrize("conditions", [1, 2, 3, 4, 5])
def test_latin_squares_balance(tmp_path: Path, conditions: int) -> None:
    """Every order is given out equally often, whatever their number."""
    orders = possible_orders([f"c{place}" for place in range(conditions)], "latin_square")
    with here(tmp_path) as register:
        got = [register.reserve("s", orders).order for _ in range(2 * len(orders))]
    assert set(Counter(got).values()) == {2}
    assert set(got) == set(orders)


def test_pilots_and_studies_are_apart(tmp_path: Path) -> None:
    """Each has slots and balance of its own."""
    with here(tmp_path) as register:
        pilots = [register.reserve("s", [AB, BA], pilot=True) for _ in range(3)]
        assert [(each.slot, each.order) for each in pilots] == [(1, AB), (2, BA), (3, AB)]
        assert register.reserve("t", [AB, BA]).slot == 1
        known = register.reserve("s", [AB, BA])
        assert (known.slot, known.order) == (1, AB)
        register.start("s", known.pseudonym)
        register.finish("s", known.pseudonym, "complete")
        moved = editing.set_pilot(register, known, pilot=True)
        assert (moved.slot, moved.pilot) == (4, True)
        # The first slot is free again.
        assert register.reserve("s", [AB, BA]).order == AB
        assert editing.set_pilot(register, known, "a slip", pilot=False).slot == 2
        told = [line.detail for line in register.history("s", known.pseudonym)][-2:]
        assert told == ["a pilot; now in pilot slot 4", "no pilot: a slip; now in slot 2"]
        editing.set_pilot(register, known, pilot=True)
        with pytest.raises(StudyError, match="a pilot already"):
            editing.set_pilot(register, known, pilot=True)


def test_wrong_condition_is_recorded_and_balanced(tmp_path: Path) -> None:
    """An order given by hand counts as run; the history says what the plan had."""
    with here(tmp_path) as register:
        wrong = register.reserve("s", [AB, BA], order=BA)
        (line,) = register.history("s", wrong.pseudonym)
        assert line.detail == "slot 1, order b,a, by hand; the plan had a,b"
        assert [register.reserve("s", [AB, BA]).order for _ in range(2)] == [AB, AB]


def test_another_order_for_a_reserved_slot_is_in_the_history(tmp_path: Path) -> None:
    """Each change has a line, and what the plan had stays what it was at first."""

    def reserve(order: tuple[str, ...]) -> str:
        reserved = register.reserve("s", [AB, BA], pseudonym="P1", order=order)
        assert reserved.order == (order or AB)
        return register.history("s", "P1")[-1].detail

    with here(tmp_path) as register:
        assert reserve(()) == "slot 1, order a,b"
        assert reserve(BA) == "slot 1, order b,a, by hand; the plan had a,b"
        assert planned_orders(tmp_path) == {("s", "P1"): AB}
        assert reserve(AB) == "slot 1, order a,b"
        assert reserve(BA) == "slot 1, order b,a, by hand; the plan had a,b"
        reserve(BA)
        assert len(register.history("s", "P1")) == 4
        assert planned_orders(tmp_path) == {("s", "P1"): AB}


def test_another_order_for_a_second_session_leaves_the_first_ones(tmp_path: Path) -> None:
    """While it is reserved, too: the history has the line, and the balance the first order."""
    with here(tmp_path) as register:
        through(register, "P1")
        register.reserve("s", [AB, BA], pseudonym="P1", again=True)
        other = register.reserve("s", [AB, BA], pseudonym="P1", order=BA)
        assert (other.order, other.visits) == (BA, 2)
        assert register.history("s", "P1")[-1].detail == "session 2, order b,a"
        assert register.participants()[0].order == AB


def test_a_duplicate_is_refused(tmp_path: Path) -> None:
    """Whoever had a session is refused without --again, and told what to do."""
    with here(tmp_path) as register:
        through(register, "P1")
        through(register, "P2", "dropped")
        with pytest.raises(StudyError, match="already has a recording") as caught:
            register.reserve("s", [AB, BA], pseudonym="P1")
        assert "--resume" not in caught.value.hint
        with pytest.raises(StudyError, match="not complete") as caught:
            register.reserve("s", [AB, BA], pseudonym="P2")
        assert "--resume" in caught.value.hint
        with pytest.raises(StudyError, match="in capital letters only"):
            register.reserve("s", [AB, BA], pseudonym="p1", again=True)


def test_a_session_on_another_day(tmp_path: Path) -> None:
    """It keeps slot and order, counts once, and never undoes the first that was complete."""
    with here(tmp_path) as register:
        first = through(register, "P1")
        other = register.reserve("s", [AB, BA], pseudonym="P1", again=True)
        assert (other.slot, other.order, other.visits) == (first.slot, first.order, 2)
        register.start("s", "P1")
        register.finish("s", "P1", "dropped", "stopped by the participant")
        known = register.find("s", "P1")
        assert known is not None
        assert (known.state, known.slot) == ("complete", 1)
        assert known.reason == "session 2: dropped, stopped by the participant"
        assert [line.what for line in register.history("s", "P1")] == [
            *("reserved", "running", "complete", "reserved", "again", "running", "complete")
        ]


def test_another_session_that_never_began(tmp_path: Path) -> None:
    """Declined, or killed before it was recorded: the participant is as before."""
    with here(tmp_path) as register:
        through(register, "P1")
        register.reserve("s", [AB, BA], pseudonym="P1", again=True)
        register.release("s", "P1")
        known = register.find("s", "P1")
        assert known is not None
        assert (known.state, known.visits, known.lease) == ("complete", 1, None)


def test_another_session_carries_no_reason_of_what_was_before(tmp_path: Path) -> None:
    """What the session before came to, or was restored for, is told with that one alone."""
    with here(tmp_path) as register:
        known = through(register, "P1")
        editing.mark(register, known, "dropped", "hurried through")
        editing.restore(register, known, "a mistake")
        other = register.reserve("s", [AB, BA], pseudonym="P1", again=True)
        assert other.reason == ""
        told = [(line.what, line.detail) for line in register.history("s", "P1")][-3:]
        assert told == [
            ("complete", "restored by hand: a mistake"),
            ("reserved", ""),
            ("again", "session 2, order a,b"),
        ]
        # Of a session that is not begun nothing stays; what was so before is so again.
        register.release("s", "P1")
        assert register.participants()[0].reason == "restored by hand: a mistake"


def test_nothing_is_kept_of_who_declines(tmp_path: Path) -> None:
    """Neither a row nor a line of history; not even in the bytes of the file."""
    with here(tmp_path) as register:
        register.reserve("s", [AB, BA], pseudonym="P7UNIQUE")
        register.release("s", "P7UNIQUE")
        assert register.participants() == []
        assert register.history("s", "P7UNIQUE") == []
    assert b"P7UNIQUE" not in register.path.read_bytes()


def test_a_resume_keeps_its_slot_or_takes_a_free_one(tmp_path: Path) -> None:
    """Interrupted: the same slot. Dropped: the same if it is free, or else another, noted."""
    with here(tmp_path, 1) as register:
        register.reserve("s", [AB, BA], pseudonym="P1")
        register.start("s", "P1")
    with here(tmp_path, 2) as register:
        with pytest.raises(StudyError, match="is in a session: process 1"):
            register.resume("s", "P1")
        with pytest.raises(StudyError, match="is in a session"):
            editing.mark(register, register.participants()[0], "dropped", "x")
    with here(tmp_path, 2, dead=(1,)) as register:
        assert register.participants()[0].shown_state == "interrupted"
        assert register.resume("s", "P1").slot == 1
        register.finish("s", "P1", "dropped", "tired")
        assert register.reserve("s", [AB, BA]).slot == 1
        assert register.resume("s", "P1").slot == 2
        assert "slot 1 was given out; slot 2 instead" in register.history("s", "P1")[-1].detail


def test_marks_by_hand(tmp_path: Path) -> None:
    """Excluded and dropped with a reason, taken back, noted; each in the history."""
    with here(tmp_path) as register:
        known = through(register, "P1")
        editing.mark(register, known, "excluded", "fell ill")
        for again in (False, True):
            with pytest.raises(StudyError, match="is excluded: fell ill"):
                register.reserve("s", [AB, BA], pseudonym="P1", again=again)
        with pytest.raises(StudyError, match="excluded: fell ill"):
            register.resume("s", "P1")
        with pytest.raises(StudyError, match="excluded already"):
            editing.mark(register, known, "excluded", "x")
        # Else their data would be analysed again, without a word.
        with pytest.raises(StudyError, match="excluded already"):
            editing.mark(register, known, "dropped", "left town")
        assert editing.restore(register, known).state == "complete"
        with pytest.raises(StudyError, match="no mark can be taken back"):
            editing.restore(register, known)
        editing.note(register, known, "left-handed")
        assert register.participants()[0].note == "left-handed"
        waiting = register.reserve("s", [AB, BA])
        with pytest.raises(StudyError, match="no session yet"):
            editing.mark(register, waiting, "dropped", "x")
        with pytest.raises(StudyError, match="not reserved"):
            register.release("s", "P1")


def test_the_table_itself_refuses_two_holders(tmp_path: Path) -> None:
    """Even a program of somebody else's cannot give a slot twice."""
    with here(tmp_path) as register:
        through(register, "P1")
        through(register, "P2")
    with (
        closing(sqlite3.connect(register.path)) as other,
        pytest.raises(sqlite3.IntegrityError, match="UNIQUE"),
    ):
        other.execute("UPDATE participants SET slot = 1")
