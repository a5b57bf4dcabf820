"""The register of a folder: who takes part, in which slot and order, and how it went.

Every method is one transaction, so that sessions that start at once, on as many processes as you
like, get different slots. It holds pseudonyms only: there is no place for a name.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal

from study.enrolment.ledger import Ledger
from study.enrolment.participants import HOLDING, Happening, Participant, State, now_utc
from study.enrolment.pseudonyms import draw_pseudonym
from study.enrolment.refusals import refuse_another_session, withdrawn
from study.errors import StudyError
from study.orders import least_used_order
from study.recording.enrolled import PLAN_HAD, tombstones


class Register(Ledger):
    """A folder's register, open; a context manager that closes it. See `Ledger` for arguments.

    Raises:
        StudyError: from every method, if the file cannot be used.
    """

    def participants(self, study: str = "") -> list[Participant]:
        """Return all participants, or those of one study, by study, pilots last, and slot."""
        with self.transaction():
            return self.select("? IN ('', study)", study)

    def find(self, study: str, pseudonym: str) -> Participant | None:
        """Return a participant; None if the register has none of that pseudonym."""
        with self.transaction():
            return self.known(study, pseudonym)

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
                known = self.known(study, pseudonym)
                if known is not None:
                    return self._once_more(known, pseudonym, order, again=again)
            else:
                pseudonym = draw_pseudonym(lambda p: p in gone or self.known(study, p) is not None)
            planned = self._next_order(study, orders, pilot=pilot)
            slot = self.free_slot(study, pilot=pilot)
            ran = order or planned
            self.connection.execute(
                "INSERT INTO participants (study, pseudonym, state, slot, run_order, pilot, "
                "changed_utc) VALUES (?, ?, 'reserved', ?, ?, ?, ?)",
                (study, pseudonym, slot, ",".join(ran), int(pilot), now_utc()),
            )
            self.lease(study, pseudonym)
            reserved = self.must_know(study, pseudonym)
            self._note_reserved(reserved, ran, planned)
            return reserved

    def expected_order(
        self,
        study: str,
        orders: Sequence[tuple[str, ...]],
        pseudonym: str = "",
        *,
        pilot: bool = False,
    ) -> tuple[str, ...]:
        """Return the order that a participant has, or would be given now; nothing is reserved.

        Args:
            study: its name.
            orders: those of the design, in the sequence in which they are given out.
            pseudonym: whose; somebody whom the register does not know gets the next one.
            pilot: whether somebody whom it does not know would take part as a pilot.

        Raises:
            StudyError: that participant withdrew.
        """
        gone = tombstones(self.folder).get(study, {})
        if pseudonym and pseudonym.casefold() in map(str.casefold, gone):
            raise withdrawn(pseudonym)
        with self.transaction():
            known = self.known(study, pseudonym) if pseudonym else None
            if known is not None and known.order:
                return known.order
            return self._next_order(study, orders, pilot=pilot)

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
            known = self.must_know(study, pseudonym)
            self.refuse_if_conducted(known)
            if known.state == "excluded":
                raise StudyError(
                    f'participant "{pseudonym}" is excluded: {known.reason}',
                    f"To go on all the same say `study participants restore {pseudonym}` first.",
                )
            if known.state == "withdrawn":
                raise withdrawn(pseudonym)
            self.change(study, pseudonym, "running", "resumed")
            self.lease(study, pseudonym)
            return self.must_know(study, pseudonym)

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
            known = self.known(study, pseudonym)
            if known is None or known.state not in ("reserved", "running"):
                return
            earlier = self.earlier_state(study, pseudonym)
            kept: State = "complete" if earlier == "complete" else state
            detail = f"session {known.visits}: {state}, {reason}" if kept != state else reason
            self.change(study, pseudonym, kept, detail)

    def release(self, study: str, pseudonym: str) -> None:
        """Give a reserved slot back; of a person who had no session nothing is kept.

        Raises:
            StudyError: it is not reserved, or by a process that may live.
        """
        with self.transaction():
            known = self.must_know(study, pseudonym)
            if known.state != "reserved":
                raise StudyError(
                    f'participant "{pseudonym}" is {known.shown_state}, not reserved',
                    "Only a reserved slot is released; see `study participants drop`.",
                )
            self.refuse_if_conducted(known)
            self._give_up(known)

    def _once_more(
        self, known: Participant, given: str, order: tuple[str, ...], *, again: bool
    ) -> Participant:
        """Reserve for somebody whom the register knows."""
        self.refuse_if_conducted(known)
        refuse_another_session(known, given, self.folder, again=again)
        study, pseudonym = known.study, known.pseudonym
        if known.state == "reserved":
            visit = known.visits
            if visit == 1 and order:
                self._reorder(known, order)
        else:
            visit = known.visits + 1
            self.change(study, pseudonym, "reserved")
            # The reason is that of the session before: kept in case this one is not begun.
            self.connection.execute(
                "UPDATE participants SET before_edit = ?, visits = ?, reason = ? "
                "WHERE study = ? AND pseudonym = ?",
                (known.state, visit, known.reason, study, pseudonym),
            )
        self.lease(study, pseudonym)
        if visit > 1 and (order or known.state != "reserved"):
            self.note_history(
                *(study, pseudonym, "again"),
                f"session {visit}, order {','.join(order or known.order)}",
            )
        reserved = self.must_know(study, pseudonym)
        # The order of the first session stays the one that is balanced.
        return dataclasses.replace(reserved, order=order) if order else reserved

    def _reorder(self, known: Participant, order: tuple[str, ...]) -> None:
        """Give the order of a session that has not begun, and say so in the history."""
        if order == known.order:
            return
        study, pseudonym = known.study, known.pseudonym
        row = self.connection.execute(
            "SELECT detail FROM history WHERE study = ? AND pseudonym = ? AND instr(detail, ?) "
            "ORDER BY number LIMIT 1",
            (study, pseudonym, PLAN_HAD),
        ).fetchone()
        planned = tuple(row[0].partition(PLAN_HAD)[2].split(",")) if row else known.order
        self.connection.execute(
            "UPDATE participants SET run_order = ? WHERE study = ? AND pseudonym = ?",
            (",".join(order), study, pseudonym),
        )
        self._note_reserved(known, order, planned)

    def _note_reserved(
        self, known: Participant, order: tuple[str, ...], planned: tuple[str, ...]
    ) -> None:
        """Note slot and order of a reservation, and the plan's order if that is another."""
        overruled = f", {PLAN_HAD}{','.join(planned)}" if order != planned else ""
        detail = f"slot {known.slot}, order {','.join(order)}{overruled}"
        self.note_history(known.study, known.pseudonym, "reserved", detail)

    def _give_up_stale(self, study: str) -> None:
        for known in self.select("study = ? AND state = 'reserved'", study):
            if self._is_stale(known):
                self._give_up(known)

    def _is_stale(self, known: Participant) -> bool:
        """Whether a slot is reserved by a process that is gone."""
        gone = known.lease is None or self.alive(known.lease) is False
        return known.state == "reserved" and gone

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
        holders = self.select(f"study = ? AND pilot = ? AND state IN {HOLDING}", study, int(pilot))
        return least_used_order(
            orders, [known.order for known in holders if not self._is_stale(known)]
        )
