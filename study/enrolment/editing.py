"""What an experimenter changes in the register by hand; each change is in the history."""

from __future__ import annotations

from study.enrolment.participants import HOLDING, Participant, State
from study.enrolment.register import Register
from study.errors import StudyError


def mark(register: Register, known: Participant, state: State, reason: str) -> None:
    """Mark a participant dropped or excluded: the slot is given out anew, in its order.

    Args:
        register: where.
        known: whom.
        state: "dropped" or "excluded".
        reason: in words; never a name.

    Raises:
        StudyError: a session runs, the participant withdrew, is only reserved, or is so or
            excluded already.
    """
    with register.transaction():
        now = _current(register, known)
        register.refuse_if_conducted(now)
        if now.state == "reserved":
            raise StudyError(
                f'participant "{now.pseudonym}" has had no session yet',
                f"Give the slot back: `study participants release {now.pseudonym}`.",
            )
        if now.state in (state, "excluded"):
            # An exclusion is not undone in passing: their data would be analysed again.
            raise StudyError(
                f'participant "{now.pseudonym}" is {now.state} already: {now.reason}',
                f"`study participants restore {now.pseudonym}` takes that back.",
            )
        _remember(register, now)
        register.change(now.study, now.pseudonym, state, reason)


def restore(register: Register, known: Participant, reason: str = "") -> Participant:
    """Take back that somebody was marked; in the old slot, or if that was given out, a free one.

    Args:
        register: where.
        known: whom.
        reason: in words, for the history; never a name.

    Raises:
        StudyError: nothing was marked by hand.
    """
    with register.transaction():
        now = _current(register, known)
        before = register.earlier_state(now.study, now.pseudonym)
        if now.state not in ("dropped", "excluded") or (not before and now.state == "dropped"):
            raise StudyError(
                f'participant "{now.pseudonym}" is {now.shown_state}: no mark can be taken back',
                "A session that was ended early goes on with `study run --resume`."
                if now.state == "dropped"
                else "",
            )
        # Excluded by the session itself, for its comprehension check: it is over.
        told = _with_reason("restored by hand", reason)
        register.change(now.study, now.pseudonym, before or "dropped", told)  # type: ignore[arg-type]
        _remember(register, now, "")
        return _current(register, known)


def set_pilot(
    register: Register, known: Participant, reason: str = "", *, pilot: bool
) -> Participant:
    """Move a participant among the pilots, or back, with a slot of those.

    Args:
        register: where.
        known: whom.
        reason: in words, for the history; never a name.
        pilot: whether a pilot.

    Raises:
        StudyError: a session runs, the participant withdrew, or it is so already.
    """
    with register.transaction():
        now = _current(register, known)
        register.refuse_if_conducted(now)
        word = "a pilot" if pilot else "no pilot"
        if now.pilot == pilot:
            raise StudyError(f'participant "{now.pseudonym}" is {word} already')
        register.move(now, pilot=pilot)
        after = _current(register, known)
        detail = _with_reason(word, reason)
        if after.state in HOLDING:
            # Pilots have slots of their own, and one that was left may be somebody else's by now.
            kind = "pilot slot" if pilot else "slot"
            detail += f"; now in {kind} {after.slot}"
        register.note_history(now.study, now.pseudonym, "marked", detail)
        return after


def note(register: Register, known: Participant, text: str) -> None:
    """Replace the experimenter's note on a participant.

    Raises:
        StudyError: the participant withdrew.
    """
    with register.transaction():
        now = _current(register, known)
        register.connection.execute(
            "UPDATE participants SET note = ? WHERE study = ? AND pseudonym = ?",
            (text, now.study, now.pseudonym),
        )
        register.note_history(now.study, now.pseudonym, "noted", text)


def _with_reason(what: str, reason: str) -> str:
    return f"{what}: {reason}" if reason else what


def _current(register: Register, known: Participant) -> Participant:
    now = register.known(known.study, known.pseudonym)
    if now is None or now.state == "withdrawn":
        raise StudyError(f'participant "{known.pseudonym}" withdrew; nothing is kept to change')
    return now


def _remember(register: Register, now: Participant, state: str | None = None) -> None:
    register.connection.execute(
        "UPDATE participants SET before_edit = ? WHERE study = ? AND pseudonym = ?",
        (now.state if state is None else state, now.study, now.pseudonym),
    )
