"""What is given to begin a session, looked at before all that the computer may be blamed for."""

from __future__ import annotations

from pathlib import Path

from study.commands.composing import parse_order
from study.enrolment.importing import bring_in_step
from study.enrolment.pseudonyms import looks_like_a_name, refuse_name
from study.enrolment.register import Register
from study.loading import LoadedProtocol
from study.recording.register_folders import has_register, recordings_under


def check_given(loaded: LoadedProtocol, participant: str, order: str, folder: Path) -> None:
    """Refuse an order that is none, and an id that may be a name.

    Args:
        loaded: the protocol.
        participant: pseudonymous id; empty to draw one.
        order: conditions separated by commas; empty for that of the slot.
        folder: of the recordings; none is made, and no register in one that holds nothing.

    Raises:
        StudyError: one of them cannot be used.
    """
    parse_order(order, [condition.name for condition in loaded.protocol.conditions])
    if not looks_like_a_name(participant):
        return
    if not has_register(folder) and not recordings_under(folder):
        refuse_name(participant)
    with Register(folder) as register:
        bring_in_step(register)
        refuse_new_name(register, loaded, participant)


def refuse_new_name(register: Register, loaded: LoadedProtocol, participant: str) -> None:
    """Refuse what looks like a name; who took part before under such an id still can.

    Raises:
        StudyError: it does, and nobody did.
    """
    if register.find(loaded.protocol.study.name, participant) is None:
        refuse_name(participant)
