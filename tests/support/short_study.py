"""A protocol with every stage in a handful of timesteps, for driving the session by hand."""

from __future__ import annotations

import tempfile
from functools import cache
from pathlib import Path

from protocols import variant
from study.events.inputs import SessionOpened
from study.loading import LoadedProtocol, load_protocol
from study.session.consent import consent_sha256
from study.session.rules import CURRENT

SHORTER = (
    ("horizon = 20", "horizon = 6"),
    ("[practice]\ntimesteps = 10", "[practice]\ntimesteps = 2"),
    ("robots = 4\ntrials = 2\ntrial_timesteps = 30", "robots = 3\ntrials = 2\ntrial_timesteps = 6"),
    ("trials = 1\ntrial_timesteps = 40", "trials = 1\ntrial_timesteps = 8"),
    ("robots = 12", "robots = 5"),
    ("dwell = 15", "dwell = 3"),
    ("robots = 4\ntrials = 1\ntrial_timesteps = 20", "robots = 2\ntrials = 1\ntrial_timesteps = 3"),
)


@cache
def short_study(*changes: tuple[str, str]) -> LoadedProtocol:
    """Load the short protocol, with texts of it replaced."""
    with tempfile.TemporaryDirectory() as folder:
        return load_protocol(str(variant(Path(folder), *SHORTER, *changes)))


def opened(
    loaded: LoadedProtocol, *, seed: int = 7, order: tuple[str, ...] = ("manual", "assisted")
) -> SessionOpened:
    """Return the first input of a session; a consent text is agreed to."""
    part = loaded.protocol.consent
    return SessionOpened(
        t_ns=0,
        session_id="0" * 16,
        participant="P01",
        seed=seed,
        order=order,
        protocol_toml=loaded.text,
        protocol_sha256=loaded.sha256,
        task_json=loaded.description.to_json(),
        operator_kind="person",
        operator_json="{}",
        versions_json="{}",
        started_utc="2026-01-01T00:00:00+00:00",
        planned_index=0,
        questionnaires_json=loaded.questionnaires_json(),
        rules=CURRENT,
        consent_sha256=consent_sha256(part) if part else "",
        consented_utc="2026-01-01T00:00:00+00:00" if part else "",
    )
