"""Asking for consent before anything is recorded."""

from __future__ import annotations

import dataclasses
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Literal

from study.enrolment.not_taking_part import count
from study.loading import LoadedProtocol
from study.messages import messages_for
from study.session.consent import Consent, consent_sha256
from study.shell.raw_inputs import RawClose, RawKey, RawPointer
from study.shell.window import Window


@dataclasses.dataclass(frozen=True, slots=True)
class Given:
    """What was agreed to, and when.

    Attributes:
        sha256: of the text, hexadecimal.
        utc: wall time, ISO 8601.
    """

    sha256: str = ""
    utc: str = ""


def ask_for_consent(
    loaded: LoadedProtocol, window: Window, folder: Path
) -> Given | Literal["declined", "closed"]:
    """Show the text until it is agreed to or declined, or the window is closed.

    Args:
        loaded: the protocol, which has a consent text.
        window: where it is shown.
        folder: where declining is counted.
    """
    part = loaded.protocol.consent
    assert part is not None  # noqa: S101 - asked only where there is a text
    consent = Consent(loaded.protocol, messages_for(loaded.protocol.study.language))
    began = time.perf_counter_ns()
    window.show(consent.screen())
    while True:
        for raw in window.poll():
            decision = ""
            if isinstance(raw, RawClose):
                return "closed"
            if isinstance(raw, RawKey) and raw.down:
                decision = consent.key(raw.key)
            elif isinstance(raw, RawPointer):
                decision = consent.point(raw.target)
            if decision == "agreed":
                utc = datetime.now(UTC).isoformat(timespec="milliseconds")
                return Given(consent_sha256(part), utc)
            if decision == "declined":
                count(folder, loaded.protocol.study.name, "declined")
                return "declined"
            window.show(consent.screen())
        window.draw(time.perf_counter_ns() - began)
        window.wait(1 / window.refresh_hz)
