"""`study lock`: fix the plan before the first record."""

from __future__ import annotations

import hashlib
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.terminal import console
from study.errors import StudyError
from study.loading import LoadedProtocol, load_protocol
from study.recording.plan_lock import PlanLock, canonical_rules, lock_path, read_lock
from study.toml_text import parse_toml
from study.whole_file import replace_text


def lock(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    again: Annotated[  # noqa: FBT002
        bool, typer.Option("--again", help="Replace a lock that fixes something else.")
    ] = False,
) -> None:
    """Fix protocol, exclusions, analysis code and environment; recordings after it carry the lock.

    The lock is a file beside the protocol. A report says "confirmatory" only where it was made
    before the first record and nothing that it fixes has changed since.
    """
    loaded = load_protocol(protocol)
    path = lock_path(loaded.path)
    made = make_lock(loaded, datetime.now(UTC).isoformat(timespec="seconds"))
    try:
        before = read_lock(loaded.path)
    except StudyError:
        if not again:
            raise
        before = None
    if before is not None and before[1].same_plan(made):
        console.print(f"Locked since {before[1].locked_utc}; nothing has changed.")
        return
    if before is not None and not again:
        raise StudyError(
            f"{path} fixes another plan, since {before[1].locked_utc}",
            "Replace it with --again: what was recorded before keeps the earlier lock, and a "
            "report of both is not confirmatory.",
        )
    _write(path, made.to_json())
    console.print(f"Locked in {escape(str(path))}, {made.locked_utc}.", soft_wrap=True)


def make_lock(loaded: LoadedProtocol, locked_utc: str) -> PlanLock:
    """Return the lock of a protocol as things stand."""
    from analysis.environment import analysis_files, environment  # noqa: PLC0415 - needed here only

    return PlanLock(
        locked_utc=locked_utc,
        protocol_sha256=loaded.sha256,
        protocol_toml=loaded.text,
        questionnaires_sha256=hashlib.sha256(loaded.questionnaires_json().encode()).hexdigest(),
        exclusions=canonical_rules(parse_toml(loaded.text, str(loaded.path))),
        planned=loaded.protocol.analysis.planned,
        analysis_files=analysis_files(),
        environment=environment(),
    )


def _write(path: Path, text: str) -> None:
    try:
        replace_text(path, text)
    except OSError as error:
        raise StudyError(
            f"{path} cannot be written: {error.strerror}",
            "Copy the protocol to a folder of your own and lock it there.",
        ) from error
