"""What the transactions of a register are made of; each of these belongs inside one."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from types import TracebackType
from typing import Self

from study.enrolment.database import PATIENCE_S, open_database, transaction
from study.enrolment.participants import HOLDING, Participant, State, now_utc
from study.enrolment.process_identity import ProcessIdentity, is_alive, this_process
from study.enrolment.refusals import refuse_if_conducted
from study.enrolment.rows import COLUMNS, participant_of
from study.errors import StudyError
from study.recording.register_folders import FILE_NAME


class Ledger:
    """A register's file, open, with the steps that its transactions are made of.

    Args:
        folder: where the recordings are; it and the register are made if need be.
        me: the process that reserves and conducts sessions.
        alive: tells whether a process lives; None if that cannot be told.
        patience_s: how long other processes' transactions are waited for.

    Raises:
        StudyError: the file cannot be used.
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
        self.me = me or this_process()
        self.alive = alive
        self.connection = open_database(folder, patience_s=patience_s)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self.connection.close()

    def transaction(self) -> AbstractContextManager[None]:
        """Begin a transaction; nobody else writes in between."""
        return transaction(self.connection, self.path)

    def note_history(self, study: str, pseudonym: str, what: str, detail: str) -> None:
        """Add a line to a participant's history."""
        self.connection.execute(
            "INSERT INTO history (study, pseudonym, utc, what, detail) VALUES (?, ?, ?, ?, ?)",
            (study, pseudonym, now_utc(), what, detail),
        )

    def change(self, study: str, pseudonym: str, state: State, reason: str = "") -> None:
        """Change a state; find a slot if the new one holds one. No process has a lease then."""
        known = self.must_know(study, pseudonym)
        slot = known.slot
        if state in HOLDING and known.state not in HOLDING:
            slot = self.free_slot(study, pilot=known.pilot, wished=known.slot)
        self.connection.execute(
            "UPDATE participants SET state = ?, slot = ?, reason = ?, changed_utc = ?, "
            "host = NULL, pid = NULL, started = NULL WHERE study = ? AND pseudonym = ?",
            (state, slot, reason, now_utc(), study, pseudonym),
        )
        moved = (
            f"slot {known.slot} was given out; slot {slot} instead" if slot != known.slot else ""
        )
        self.note_history(study, pseudonym, state, "; ".join(filter(None, (reason, moved))))

    def lease(self, study: str, pseudonym: str) -> None:
        """Give this process the participant's session."""
        self.connection.execute(
            "UPDATE participants SET host = ?, pid = ?, started = ? "
            "WHERE study = ? AND pseudonym = ?",
            (self.me.host, self.me.pid, self.me.started, study, pseudonym),
        )

    def refuse_if_conducted(self, known: Participant) -> None:
        """Raise a StudyError if a process, other than this one, may be running a session."""
        refuse_if_conducted(known, self.me, self.alive)

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
        slot = self.free_slot(given.study, pilot=given.pilot) if holds else 0
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
        slot = self.free_slot(known.study, pilot=pilot) if known.state in HOLDING else 0
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
        """Return a participant; None if there is none of that pseudonym, capitals aside."""
        return next(iter(self.select("study = ? AND pseudonym = ?", study, pseudonym)), None)

    def free_slot(self, study: str, *, pilot: bool, wished: int = 0) -> int:
        """Return the slot wished for if it is free, or else the lowest that is."""
        rows = self.connection.execute(
            f"SELECT slot FROM participants WHERE study = ? AND pilot = ? AND state IN {HOLDING}",  # noqa: S608 - a constant
            (study, int(pilot)),
        )
        taken = {row[0] for row in rows}
        if wished > 0 and wished not in taken:
            return wished
        return next(slot for slot in range(1, len(taken) + 2) if slot not in taken)

    def must_know(self, study: str, pseudonym: str) -> Participant:
        """Return a participant.

        Raises:
            StudyError: there is none of that pseudonym.
        """
        found = self.known(study, pseudonym)
        if found is None:
            raise StudyError(
                f'no participant "{pseudonym}" of the study {study} in {self.path}',
                "`study participants` lists them.",
            )
        return found

    def select(self, where: str, *values: str | int) -> list[Participant]:
        """Return the participants for whom an SQL condition of ours holds."""
        query = f"SELECT {COLUMNS} FROM participants WHERE {where}"  # noqa: S608 - our own words
        rows = self.connection.execute(f"{query} ORDER BY study, pilot, slot, pseudonym", values)
        return [participant_of(row, self.alive) for row in rows.fetchall()]
