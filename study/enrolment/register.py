"""The register of a folder: who takes part, in which slot and order, and how it went.

Every method is one transaction, so that sessions that start at once, on as many processes as you
like, get different slots. It holds pseudonyms only: there is no place for a name.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from types import TracebackType
from typing import Literal

from study.enrolment.database import PATIENCE_S, open_database, transaction
from study.enrolment.participants import HOLDING, Happening, Participant, State, now_utc
from study.enrolment.process_identity import ProcessIdentity, is_alive, this_process
from study.enrolment.pseudonyms import draw_pseudonym
from study.enrolment.refusals import refuse_another_session, refuse_if_conducted, withdrawn
from study.enrolment.rows import COLUMNS, participant_of
from study.errors import StudyError
from study.orders import least_used_order
from study.recording.enrolled import FILE_NAME, tombstones

class Register:
    """A folder's register, open; a context manager that closes it.

    Args:
        folder: where the recordings are; it and the register are made if need be.
        me: the process that reserves and conducts sessions.
        alive: tells whether a process lives; None if that cannot be told.
        patience_s: how long other processes' transactions are waited for.

    Raises:
        StudyError: from every method, if the file cannot be used.
    """

    def __init__(
        self,
        folder: Path,
        *,
        me: ProcessIdentity | None = None,
        alive: Callable[[ProcessIdentity], bool | None] = is_alive,
        patience_s: float = PATIENCE_S,
    ) -> None:
        self.folder = folder
        self.path = folder / FILE_NAME
        self._me = me or this_process()
        self._alive = alive
        self.connection = open_database(folder, patience_s=patience_s)

    def __enter__(self) -> Register:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self.connection.close()

    def transaction(self) -> AbstractContextManager[None]:
        """Begin a transaction; nobody else writes in between."""
        return transaction(self.connection, self.path)

    def participants(self, study: str = "") -> list[Participant]:
        """Return all participants, or those of one study, by study, pilots last, and slot."""
        with self.transaction():
            return self._select("? IN ('', study)", study)

    def find(self, study: str, pseudonym: str) -> Participant | None:
        """Return a participant; None if the register has none of that pseudonym."""
        with self.transaction():
            return self._find(study, pseudonym)

    def history(self, study: str, pseudonym: str) -> list[Happening]:
        """Return what happened to a participant, in order."""
        query = "SELECT utc, what, detail FROM history WHERE study = ? AND pseudonym = ?"
        with self.transaction():
            rows = self.connection.execute(f"{query} ORDER BY number", (study, pseudonym))
            return [Happening(*row) for row in rows]

    def reserve(
        self,
        study: str,
        orders: Sequence[tuple[str, ...]],
        *,
        pseudonym: str = "",
        order: tuple[str, ...] = (),
        pilot: bool = False,
        again: bool = False,
    ) -> Participant:
        """Reserve a slot; the order is the one that participants with a slot have least often.

        A reservation whose process is gone is given up first. Pilots have slots of their own.

        Args:
            study: its name.
            orders: those of the design, in the sequence in which they are given out.
            pseudonym: whose slot; drawn at random if empty.
            order: to overrule; it is recorded, and counts as what is run.
            pilot: whether it is a pilot session.
            again: whether somebody who had a session may have another one, in the same order.

        Raises:
            StudyError: that pseudonym is in a session, had one, withdrew or is excluded.
        """
        gone = tombstones(self.folder).get(study, {})
        with self.transaction():
            self._give_up_stale(study)
            if pseudonym:
                if pseudonym.casefold() in map(str.casefold, gone):
                    raise withdrawn(pseudonym)
                known = self._find(study, pseudonym)
                if known is not None:
                    return self._once_more(known, pseudonym, order, again=again)
            else:
                pseudonym = draw_pseudonym(lambda p: p in gone or self._find(study, p) is not None)
            planned = self._next_order(study, orders, pilot=pilot)
            slot = self._free_slot(study, pilot=pilot)
            ran = order or planned
            self.connection.execute(
                "INSERT INTO participants (study, pseudonym, state, slot, run_order, pilot, "
                "changed_utc) VALUES (?, ?, 'reserved', ?, ?, ?, ?)",
                (study, pseudonym, slot, ",".join(ran), int(pilot), now_utc()),
            )
            self.lease(study, pseudonym)
            overruled = f", by hand; the plan had {','.join(planned)}" if ran != planned else ""
            self.note_history(
                study, pseudonym, "reserved", f"slot {slot}, order {','.join(ran)}{overruled}"
            )
            return self._known(study, pseudonym)

    def start(self, study: str, pseudonym: str) -> None:
        """Note that the recording begins, by this process."""
        with self.transaction():
            self.change(study, pseudonym, "running")
            self.lease(study, pseudonym)

    def resume(self, study: str, pseudonym: str) -> Participant:
        """Take up a session that broke off, in its slot; if that was given out, in a free one.

        Raises:
            StudyError: the session is being run, or the participant is excluded or withdrew.
        """
        with self.transaction():
            known = self._known(study, pseudonym)
            refuse_if_conducted(known, self._me, self._alive)
            if known.state == "excluded":
                raise StudyError(
                    f'participant "{pseudonym}" is excluded: {known.reason}',
                    f"To go on all the same say `study participants restore {pseudonym}` first.",
                )
            if known.state == "withdrawn":
                raise withdrawn(pseudonym)
            self.change(study, pseudonym, "running", "resumed")
            self.lease(study, pseudonym)
            return self._known(study, pseudonym)

    def finish(
        self,
        study: str,
        pseudonym: str,
        state: Literal["complete", "dropped", "excluded", "running"],
        reason: str = "",
    ) -> None:
        """Write back what a session came to; a later one never undoes a complete one.

        Args:
            study: its name.
            pseudonym: the participant.
            state: "running" for a session that broke off: it is interrupted, and keeps its slot.
            reason: in words.
        """
        with self.transaction():
            known = self._find(study, pseudonym)
            if known is None or known.state not in ("reserved", "running"):
                return
            earlier = self.earlier_state(study, pseudonym)
            kept: State = "complete" if earlier == "complete" else state
            detail = f"this session: {state}, {reason}" if kept != state else reason
            self.change(study, pseudonym, kept, detail)

    def release(self, study: str, pseudonym: str) -> None:
        """Give a reserved slot back; of a person who had no session nothing is kept.

        Raises:
            StudyError: it is not reserved, or by a process that may live.
        """
        with self.transaction():
            known = self._known(study, pseudonym)
            if known.state != "reserved":
                raise StudyError(
                    f'participant "{pseudonym}" is {known.shown_state}, not reserved',
                    "Only a reserved slot is released; see `study participants drop`.",
                )
            refuse_if_conducted(known, self._me, self._alive)
            self._give_up(known)

    # What follows belongs inside a transaction; editing, importing and withdrawing use it too.

    def note_history(self, study: str, pseudonym: str, what: str, detail: str) -> None:
        """Add a line to a participant's history."""
        self.connection.execute(
            "INSERT INTO history (study, pseudonym, utc, what, detail) VALUES (?, ?, ?, ?, ?)",
            (study, pseudonym, now_utc(), what, detail),
        )

    def change(self, study: str, pseudonym: str, state: State, reason: str = "") -> None:
        """Change a state; find a slot if the new one holds one. No process has a lease then."""
        known = self._known(study, pseudonym)
        slot = known.slot
        if state in HOLDING and known.state not in HOLDING:
            slot = self._free_slot(study, pilot=known.pilot, wished=known.slot)
        self.connection.execute(
            "UPDATE participants SET state = ?, slot = ?, reason = ?, changed_utc = ?, "
            "host = NULL, pid = NULL, started = NULL WHERE study = ? AND pseudonym = ?",
            (state, slot, reason, now_utc(), study, pseudonym),
        )
        moved = f"slot {known.slot} was given out; slot {slot} instead" if slot != known.slot else ""
        self.note_history(study, pseudonym, state, "; ".join(filter(None, (reason, moved))))

    def lease(self, study: str, pseudonym: str) -> None:
        """Give this process the participant's session."""
        self.connection.execute(
            "UPDATE participants SET host = ?, pid = ?, started = ? "
            "WHERE study = ? AND pseudonym = ?",
            (self._me.host, self._me.pid, self._me.started, study, pseudonym),
        )

    def refuse_if_conducted(self, known: Participant) -> None:
        """Raise a StudyError if a process, other than this one, may be running a session."""
        refuse_if_conducted(known, self._me, self._alive)

    def earlier_state(self, study: str, pseudonym: str) -> str:
        """Return the state before another session or a mark by hand; empty if there was none."""
        row = self.connection.execute(
            "SELECT before_edit FROM participants WHERE study = ? AND pseudonym = ?",
            (study, pseudonym),
        ).fetchone()
        return row[0] if row else ""

    def insert(self, given: Participant) -> None:
        """Add a participant that recordings tell of, in a free slot where the state holds one."""
        holds = given.state in HOLDING
        slot = self._free_slot(given.study, pilot=given.pilot) if holds else 0
        self.connection.execute(
            "INSERT INTO participants (study, pseudonym, state, slot, run_order, pilot, visits, "
            "reason, changed_utc) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)",
            (
                *(given.study, given.pseudonym, given.state, slot, ",".join(given.order)),
                *(int(given.pilot), given.visits, given.reason, given.changed_utc),
            ),
        )
        self.note_history(given.study, given.pseudonym, given.state, "found in the recordings")

    def move(self, known: Participant, *, pilot: bool) -> None:
        """Put a participant among the pilots, or out of them, in a free slot there."""
        slot = self._free_slot(known.study, pilot=pilot) if known.state in HOLDING else 0
        self.connection.execute(
            "UPDATE participants SET pilot = ?, slot = ? WHERE study = ? AND pseudonym = ?",
            (int(pilot), slot, known.study, known.pseudonym),
        )

    def bury(self, study: str, pseudonym: str, utc: str) -> None:
        """Overwrite all that is known of a participant but pseudonym and time of withdrawal."""
        key = (study, pseudonym)
        self.connection.execute(
            "UPDATE participants SET state = 'withdrawn', slot = 0, run_order = '', pilot = 0, "
            "visits = 0, reason = '', note = '', before_edit = '', changed_utc = ?, host = NULL, "
            "pid = NULL, started = NULL WHERE study = ? AND pseudonym = ?",
            (utc, *key),
        )
        self.connection.execute("DELETE FROM history WHERE study = ? AND pseudonym = ?", key)

    def known(self, study: str, pseudonym: str) -> Participant | None:
        """Return a participant, inside a transaction."""
        return self._find(study, pseudonym)

    def _once_more(
        self, known: Participant, given: str, order: tuple[str, ...], *, again: bool
    ) -> Participant:
        """Reserve for somebody whom the register knows."""
        refuse_another_session(known, given, self.folder, again=again)
        refuse_if_conducted(known, self._me, self._alive)
        study, pseudonym = known.study, known.pseudonym
        if known.state == "reserved":
            if order:
                self.connection.execute(
                    "UPDATE participants SET run_order = ? WHERE study = ? AND pseudonym = ?",
                    (",".join(order), study, pseudonym),
                )
            self.lease(study, pseudonym)
            return self._known(study, pseudonym)
        visit = known.visits + 1
        self.change(study, pseudonym, "reserved", known.reason)
        self.connection.execute(
            "UPDATE participants SET before_edit = ?, visits = ? "
            "WHERE study = ? AND pseudonym = ?",
            (known.state, visit, study, pseudonym),
        )
        self.lease(study, pseudonym)
        self.note_history(
            study, pseudonym, "again", f"session {visit}, order {','.join(order or known.order)}"
        )
        reserved = self._known(study, pseudonym)
        # The order of the first session stays the one that is balanced.
        return dataclasses.replace(reserved, order=order) if order else reserved

    def _give_up_stale(self, study: str) -> None:
        for known in self._select("study = ? AND state = 'reserved'", study):
            if known.lease is None or self._alive(known.lease) is False:
                self._give_up(known)

    def _give_up(self, known: Participant) -> None:
        """Undo a reservation."""
        key = (known.study, known.pseudonym)
        before = self.earlier_state(*key)
        if before:
            self.connection.execute(
                "UPDATE participants SET state = ?, before_edit = '', visits = visits - 1, "
                "host = NULL, pid = NULL, started = NULL WHERE study = ? AND pseudonym = ?",
                (before, *key),
            )
            self.note_history(*key, before, "another session was not begun")
            return
        self.connection.execute("DELETE FROM participants WHERE study = ? AND pseudonym = ?", key)
        self.connection.execute("DELETE FROM history WHERE study = ? AND pseudonym = ?", key)

    def _next_order(
        self, study: str, orders: Sequence[tuple[str, ...]], *, pilot: bool
    ) -> tuple[str, ...]:
        holders = self._select(
            f"study = ? AND pilot = ? AND state IN {HOLDING}", study, int(pilot)
        )
        return least_used_order(orders, [known.order for known in holders])

    def _free_slot(self, study: str, *, pilot: bool, wished: int = 0) -> int:
        rows = self.connection.execute(
            f"SELECT slot FROM participants WHERE study = ? AND pilot = ? AND state IN {HOLDING}",  # noqa: S608 - a constant
            (study, int(pilot)),
        )
        taken = {row[0] for row in rows}
        if wished > 0 and wished not in taken:
            return wished
        return next(slot for slot in range(1, len(taken) + 2) if slot not in taken)

    def _known(self, study: str, pseudonym: str) -> Participant:
        found = self._find(study, pseudonym)
        if found is None:
            raise StudyError(
                f'no participant "{pseudonym}" of the study {study} in {self.path}',
                "`study participants` lists them.",
            )
        return found

    def _find(self, study: str, pseudonym: str) -> Participant | None:
        return next(iter(self._select("study = ? AND pseudonym = ?", study, pseudonym)), None)

    def _select(self, where: str, *values: str | int) -> list[Participant]:
        query = f"SELECT {COLUMNS} FROM participants WHERE {where}"  # noqa: S608 - our own words
        rows = self.connection.execute(f"{query} ORDER BY study, pilot, slot, pseudonym", values)
        return [participant_of(row, self._alive) for row in rows.fetchall()]
