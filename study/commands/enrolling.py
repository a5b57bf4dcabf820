"""A session's place in the register: reserved before it, and written back after it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Literal

from rich.markup import escape

from study.commands.composing import Assignment, parse_order, seed_from
from study.commands.given import refuse_new_name
from study.commands.resuming import Boundary
from study.commands.terminal import errors
from study.enrolment.files import files_in_words, out_of_reach
from study.enrolment.importing import NOT_UNDERSTOOD, bring_in_step
from study.enrolment.participants import HOLDING, Participant
from study.enrolment.pseudonyms import check_participant
from study.enrolment.register import Register
from study.enrolment.withdrawing import unlink, withdraw
from study.errors import StudyError
from study.loading import LoadedProtocol
from study.orders import possible_orders
from study.preflight_result import forget_rehearsed

BY_HAND = (
    "[yellow]Still to be done by hand:[/] erase reports, tables and exports of this participant, "
    "make those of several participants anew, and erase copies and backups elsewhere."
)
"""What the program cannot erase: it does not know where that is."""
_REMOVE = "The participant asked for it: remove the file by hand."


def assign(
    loaded: LoadedProtocol,
    participant: str,
    folder: Path,
    *,
    order: str = "",
    seed: int | None = None,
    again: bool = False,
    pilot: bool = False,
) -> Assignment:
    """Reserve a slot for a person, and with it decide order and seed of the session.

    Args:
        loaded: the protocol.
        participant: pseudonymous id; empty to draw one.
        folder: where this study's recordings and the register are.
        order: conditions separated by commas, to overrule.
        seed: to overrule the one derived from participant and protocol.
        again: whether a participant who has a recording may take part again.
        pilot: whether the session is none of the study's own.

    Raises:
        StudyError: the id cannot be used, looks like a name, has a recording, or the order is
            none; or the register cannot be used.
    """
    if participant:
        participant = check_participant(participant)
    conditions = [condition.name for condition in loaded.protocol.conditions]
    chosen = parse_order(order, conditions)
    with Register(folder) as register:
        bring_in_step(register)
        if participant:
            refuse_new_name(register, loaded, participant)
        orders = possible_orders(conditions, loaded.protocol.phase_three.order)
        # Asked for only where it is to be told that another one was set.
        planned = chosen and register.expected_order(
            loaded.protocol.study.name, orders, participant, pilot=pilot
        )
        reserved = register.reserve(
            loaded.protocol.study.name,
            orders,
            pseudonym=participant,
            order=chosen,
            pilot=pilot,
            again=again,
        )
    return Assignment(
        participant=reserved.pseudonym,
        seed=seed if seed is not None else _seed_of(loaded, reserved.pseudonym),
        order=reserved.order,
        planned_index=-1 if reserved.pilot else reserved.slot - 1,
        operator_kind="person",
        pilot=reserved.pilot,
        remark=_by_hand(reserved.order, planned) if chosen else "",
    )


def _by_hand(order: Sequence[str], planned: Sequence[str]) -> str:
    """Say that an order was set by hand, if another one was planned."""
    if tuple(order) == tuple(planned):
        return ""
    return f"Order set by hand: {' then '.join(order)}; the plan had {' then '.join(planned)}"


def foreseen(
    loaded: LoadedProtocol, participant: str, folder: Path, *, pilot: bool = False
) -> tuple[tuple[str, ...], int]:
    """Return order and seed that a person's session has, or would have if it began now.

    Args:
        loaded: the protocol.
        participant: pseudonymous id.
        folder: where this study's recordings and the register are.
        pilot: whether somebody whom the register does not know would take part as a pilot.

    Raises:
        StudyError: the id cannot be used, the participant withdrew, or the register cannot be used.
    """
    participant = check_participant(participant)
    conditions = [condition.name for condition in loaded.protocol.conditions]
    with Register(folder) as register:
        bring_in_step(register)
        refuse_new_name(register, loaded, participant)
        order = register.expected_order(
            loaded.protocol.study.name,
            possible_orders(conditions, loaded.protocol.phase_three.order),
            participant,
            pilot=pilot,
        )
    return order, _seed_of(loaded, participant)


def _seed_of(loaded: LoadedProtocol, pseudonym: str) -> int:
    return seed_from(f"{loaded.sha256} {pseudonym}")


def who_broke_off(loaded: LoadedProtocol, folder: Path) -> str:
    """Return the one participant whose session can be resumed.

    Raises:
        StudyError: there is none, or several.
    """
    with Register(folder) as register:
        bring_in_step(register)
        known = register.participants(loaded.protocol.study.name)
    interrupted = [each for each in known if each.interrupted]
    ended_early = [each for each in known if each.state == "dropped"]
    broken = interrupted or ended_early
    if not broken:
        raise StudyError(
            f"no session in {folder} broke off or was ended early", "Begin one without --resume."
        )
    if len(broken) != 1:
        raise StudyError(
            "--resume without --participant takes the one session that broke off; interrupted: "
            f"{_named(interrupted)}; ended early: {_named(ended_early)}",
            "Say whose with --participant.",
        )
    return broken[0].pseudonym


def _named(known: Sequence[Participant]) -> str:
    """List participants, with the reason where there is one."""
    names = [f"{e.pseudonym} ({e.reason})" if e.reason else e.pseudonym for e in known[:20]]
    more = f" and {len(known) - 20} more" if len(known) > 20 else ""
    return ", ".join(names) + more or "none"


@dataclasses.dataclass(frozen=True, slots=True)
class Finished:
    """What a session in a window came to.

    Attributes:
        paths: the recording, one file a part; none if there is none.
        outcome: "declined" if consent was not given, "erased" if the participant wants all data
            erased: this recording, which is still there, and those before it.
        reason: in words, of an early end.
    """

    paths: tuple[Path, ...]
    outcome: Literal["complete", "ended_early", "declined", "erased"]
    reason: str = ""


class Enrolled:
    """A participant's lease while this process conducts the session.

    A context manager: where the session ends by an error, the participant is interrupted, or,
    if nothing was recorded, the slot is free again.
    """

    def __init__(self, loaded: LoadedProtocol, participant: str, folder: Path) -> None:
        self._study = loaded.protocol.study.name
        self._participant = participant
        self._folder = folder
        self._written_back = False

    def __enter__(self) -> Enrolled:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        if error is None or self._written_back:
            return
        try:
            with Register(self._folder) as register:
                known = register.find(self._study, self._participant)
                if known is None:
                    return
                if known.state == "reserved":
                    register.release(self._study, self._participant)
                else:
                    broke = str(error).partition("\n")[0] or type(error).__name__
                    register.finish(self._study, self._participant, "running", broke[:200])
        except StudyError as second:
            _warn(second)

    def begin(self) -> None:
        """Note that the recording begins."""
        with Register(self._folder) as register:
            register.start(self._study, self._participant)

    def resume(self) -> Participant:
        """Take up a session that broke off, in its slot.

        Raises:
            StudyError: another process runs it, or the participant is excluded or withdrew.
        """
        with Register(self._folder) as register:
            bring_in_step(register)
            return register.resume(self._study, self._participant)

    def write_back(self, finished: Finished) -> None:
        """Note what the session came to. The recording is safe: a failure is only told.

        Raises:
            StudyError: not all of the data that were to be erased could be.
        """
        self._written_back = True
        if finished.outcome == "erased":
            self._erase(finished.paths)
            return
        try:
            with Register(self._folder) as register:
                self._write_back(register, finished)
        except StudyError as error:
            _warn(error)

    def _write_back(self, register: Register, finished: Finished) -> None:
        key = (self._study, self._participant)
        match finished.outcome:
            case "complete":
                register.finish(*key, "complete")
            case "declined":
                # Who declines leaves a count and nothing else.
                register.release(*key)
                forget_rehearsed(self._folder, self._participant)
            case "ended_early":
                failed = finished.reason == NOT_UNDERSTOOD
                register.finish(*key, "excluded" if failed else "dropped", finished.reason)

    def _erase(self, paths: Sequence[Path]) -> None:
        """Erase the participant's data, of earlier sessions too.

        The tombstone comes first: whatever fails after it, the data are left out of all analysis.
        """
        try:
            with Register(self._folder) as register:
                erased = withdraw(register, self._study, self._participant)
                missed = out_of_reach(register, self._study, self._participant)
        except StudyError as error:
            # What was recorded just now goes all the same: for that no register is needed.
            unlink(paths, _REMOVE)
            raise StudyError(
                f"not all data of {self._participant} could be erased, as the participant asked: "
                f"{error.message}",
                f"Mend that, then say `study participants withdraw {self._participant}`. "
                f"{error.hint}".rstrip(),
            ) from error
        # A recording that went on in another folder is not the register's.
        unlink(paths, _REMOVE)
        # The recorder names its files from the root, the register from where it was opened.
        files = sorted({path.resolve() for path in (*erased, *paths)})
        errors.print(
            f"{self._participant} had all data erased: {escape(files_in_words(files))}. A "
            f"tombstone is kept: pseudonym and time.\n{BY_HAND}"
        )
        tell_out_of_reach(missed)


def tell_out_of_reach(missed: Sequence[str]) -> None:
    """Say where a withdrawn participant's data are that were not erased."""
    for place in missed:
        errors.print(f"[bold yellow]Not erased:[/] {escape(place)}")


def _warn(error: StudyError) -> None:
    errors.print(
        f"[yellow]The outcome could not be written into the register:[/] {escape(str(error))}\n"
        "  The next `study run` or `study participants` reads it from the recording."
    )


def tell_place(loaded: LoadedProtocol, assignment: Assignment, folder: Path) -> None:
    """Warn where the plan is exceeded or a condition is run too often."""
    planned = loaded.protocol.study.planned_participants
    if assignment.planned_index >= planned:
        errors.print(
            f"[yellow]All {planned} planned participants have a slot:[/] this is number "
            f"{assignment.planned_index + 1}."
        )
    with Register(folder) as register:
        known = register.participants(loaded.protocol.study.name)
    used = [
        each.order
        for each in known
        if each.state in HOLDING and each.pilot == assignment.pilot and each.order
    ]
    designed = possible_orders(
        [condition.name for condition in loaded.protocol.conditions],
        loaded.protocol.phase_three.order,
    )
    least = min(used.count(order) for order in designed)
    mine = used.count(assignment.order)
    # Else it is the slot's, as in a second session, whatever the plan has next.
    if assignment.remark and (assignment.order not in designed or mine > least + 1):
        errors.print(
            f"[yellow]The order {escape(','.join(assignment.order))} is not the one that the plan "
            "has next;[/] the register notes that it was set by hand."
        )


def announce(assignment: Assignment) -> str:
    """Say who takes part, for the terminal."""
    place = "pilot" if assignment.pilot else f"slot {assignment.planned_index + 1}"
    return (
        f"Participant [bold]{assignment.participant}[/], {place}, "
        f"order {' then '.join(assignment.order)}. Escape pauses."
    )


def announce_resumed(boundary: Boundary, known: Participant) -> str:
    """Say who goes on, and in which slot, for the terminal."""
    opened = boundary.opened
    return (
        f"Participant [bold]{opened.participant}[/], "
        f"{'pilot' if known.pilot else f'slot {known.slot}'}, "
        f"order {' then '.join(opened.order)}: going on at the last stage entered. Escape pauses."
    )
