"""Sessions of persons as they lie in a folder, and the register made of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from study.commands.composing import session_opened, start_failover_recorder
from study.commands.simulating import simulated_assignments
from study.enrolment.importing import bring_in_step
from study.enrolment.participants import Participant
from study.enrolment.register import Register
from study.events.events import SessionEnded
from study.loading import load_protocol


def record(
    folder: Path,
    participant: str,
    order: tuple[str, ...] = ("manual", "assisted"),
    ended: SessionEnded | None = None,
    pilot: bool = False,
) -> Path:
    """Record a person's session of two records, as if long ago: no register is touched."""
    loaded = load_protocol("smoke")
    (like,) = simulated_assignments(loaded, 1, seed=1)
    assignment = dataclasses.replace(
        like, participant=participant, order=order, operator_kind="person", operator_json="{}"
    )
    opened = session_opened(loaded, assignment)
    recorder = start_failover_recorder(folder, loaded, opened, pilot=pilot)
    recorder.write(opened, 1)
    if ended:
        recorder.write(ended, 2)
    recorder.close()
    return recorder.path


COMPLETE = SessionEnded(9, complete=True, reason="complete")


def known_in(folder: Path) -> dict[str, Participant]:
    """Bring a folder's register in step; return its participants."""
    with Register(folder) as register:
        bring_in_step(register)
        return {each.pseudonym: each for each in register.participants()}
