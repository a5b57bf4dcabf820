"""`study preflight`: is all well before the participant sits down?"""

from __future__ import annotations

import dataclasses
import platform
import sys
import time
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape
from rich.table import Table

from study.commands.terminal import console, errors
from study.errors import StudyError
from study.loading import LoadedProtocol, load_protocol
from study.output_option import folder_wanted
from study.preflight_result import (
    FRESH_HOURS,
    Check,
    Preflight,
    as_json,
    keep_preflight,
    read_preflight,
)
from study.remarks import remarks
from study.shell.pygame_check import require_pygame_ce

if TYPE_CHECKING:
    from study.commands.composing import Assignment
    from study.commands.running import Seat

COLOURS = {"green": "green", "amber": "yellow", "red": "bold red"}


def preflight(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    participant: Annotated[
        str,
        typer.Option("--participant", "-p", help="Whose sequence to rehearse, by the register."),
    ] = "",
    order: Annotated[
        str, typer.Option(help="Conditions in the order rehearsed; default: the participant's.")
    ] = "",
    pilot: Annotated[  # noqa: FBT002
        bool, typer.Option("--pilot", help="A new participant would be a pilot.")
    ] = False,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", callback=folder_wanted, help="Folder of the recordings."),
    ] = Path("recordings"),
    size: Annotated[str, typer.Option(help="Window size, such as 1280x960.")] = "",
    fullscreen: Annotated[bool, typer.Option("--fullscreen", help="Fill the screen.")] = False,  # noqa: FBT002
    ui_scale: Annotated[
        float, typer.Option(help="Text 1 to 2 times the size that suits the window.")
    ] = 1.0,
    keys: Annotated[  # noqa: FBT002
        bool, typer.Option("--keys/--no-keys", help="Ask for two keys to be held together.")
    ] = True,
    json: Annotated[bool, typer.Option("--json", help="Print the result for a program.")] = False,  # noqa: FBT002
) -> None:
    """Check this computer, window and keyboard, and rehearse the participant's sequence.

    Takes about 20 seconds. The result is kept beside the recordings: `study run` does not begin
    within a day of a red one, unless told why it should.
    """
    from study.commands.run import parse_size  # noqa: PLC0415
    from study.commands.running import Seat  # noqa: PLC0415 - pygame is slow to import
    from study.shell.window import check_size, check_ui_scale  # noqa: PLC0415

    require_pygame_ce()
    loaded = load_protocol(protocol)
    wanted = check_size(parse_size(size))
    seat = Seat(wanted, fullscreen=fullscreen, ui_scale=check_ui_scale(ui_scale))
    assignment = _rehearsed(loaded, participant, order, output, pilot=pilot)
    found = _look(loaded, assignment, output, seat, with_keys=keys)
    found = found.model_copy(update={"participant": participant})
    try:
        output.mkdir(parents=True, exist_ok=True, mode=0o700)
        keep_preflight(output, found)
    except OSError as error:
        errors.print(f"[yellow]The result cannot be kept in {escape(str(output))}:[/] "
                     f"{escape(error.strerror or str(error))}")  # fmt: skip
    if json:
        sys.stdout.write(as_json(found) + "\n")
    else:
        console.print(_table(found))
    if found.state == "red":
        raise typer.Exit(3)


def _rehearsed(
    loaded: LoadedProtocol, participant: str, order: str, folder: Path, *, pilot: bool
) -> Assignment:
    """Return the order and seed to rehearse: a participant's own, if one is named.

    Raises:
        StudyError: the participant or the order cannot be used.
    """
    from study.commands.composing import parse_order  # noqa: PLC0415
    from study.commands.enrolling import foreseen  # noqa: PLC0415 - slow to import
    from study.commands.simulating import simulated_assignments  # noqa: PLC0415

    (assignment,) = simulated_assignments(loaded, 1, seed=1)
    if participant:
        own, seed = foreseen(loaded, participant, folder, pilot=pilot)
        assignment = dataclasses.replace(assignment, order=own, seed=seed)
    if chosen := parse_order(order, assignment.order):
        assignment = dataclasses.replace(assignment, order=chosen)
    return assignment


def _look(
    loaded: LoadedProtocol, assignment: Assignment, folder: Path, seat: Seat, *, with_keys: bool
) -> Preflight:
    began = time.perf_counter()
    checks = tuple(_checks(loaded, assignment, folder, seat, with_keys=with_keys))
    return Preflight(
        utc=datetime.now(UTC).isoformat(timespec="seconds"),
        host=platform.node(),
        protocol=str(loaded.path),
        protocol_sha256=loaded.sha256,
        seconds=round(time.perf_counter() - began, 1),
        checks=checks,
    )


def _checks(
    loaded: LoadedProtocol, assignment: Assignment, folder: Path, seat: Seat, *, with_keys: bool
) -> Iterator[Check]:
    """Make all checks; those in the window last, so that the experimenter is not kept there."""
    from study.commands.rehearsing import rehearse  # noqa: PLC0415
    from study.shell.preflight import display, keys, machine  # noqa: PLC0415

    protocol = loaded.protocol
    clocks = machine.Clocks()
    if said := remarks(protocol, loaded.description.horizon):
        yield Check(name="protocol", state="amber", found="; ".join(said),
                    wanted="settings that something can come of",
                    advice="Look at the protocol with `study validate`.")  # fmt: skip
    rehearsal = rehearse(loaded, assignment)
    yield from rehearsal.checks
    yield machine.disk_space(folder, rehearsal.bytes)
    yield machine.write_latency(folder)
    yield clocks.check()
    both = (protocol.keys.up, protocol.keys.left)
    if with_keys:
        # Whoever looks at the terminal now would let the time for it go by.
        errors.print(f"A window opens. When it asks for [bold]{escape(' and '.join(both))}[/], "
                     f"hold both down at once: it waits {keys.PATIENCE_S:g} s.")  # fmt: skip
    measured = display.refresh_rate(seat.size, fullscreen=seat.fullscreen)
    try:
        window = seat.open_window(protocol.study)
    except StudyError as error:
        yield Check(name="display", state="red", found=error.message, wanted="a window",
                    advice="Run it on the participant's desktop.")  # fmt: skip
        return
    with closing(window):
        yield display.display(window, measured)
        yield display.letters(rehearsal.texts)
        if rehearsal.fleet is not None:
            yield display.punctuality(window, rehearsal.fleet, protocol.timing.timesteps_per_second)
        if with_keys:
            yield keys.keyboard(window, both)
        else:
            yield Check(name=keys.NAME, state="amber", found="not tried (--no-keys)",
                        wanted="two keys held down at once",
                        advice="Try the keyboard by hand.")  # fmt: skip


@dataclasses.dataclass(frozen=True, slots=True)
class Before:
    """What a session records of the preflight before it.

    Attributes:
        remark: what it found; empty if there is none of today.
        note: for the experimenter's notes: why the session begins although it is red; or empty.
    """

    remark: str = ""
    note: str = ""


def preflight_before(
    folder: Path, protocol_sha256: str, override: str, participant: str = ""
) -> Before:
    """Return what a session records of the preflight before it.

    Args:
        folder: of the recordings.
        protocol_sha256: of the protocol that is to be run.
        override: why to begin although it is red; empty for no reason.
        participant: who is to take part; empty if that is not known yet.

    Raises:
        StudyError: it is red, and no reason is given to begin all the same.
    """
    found = read_preflight(folder)
    if found is None or found.age_hours() > FRESH_HOURS:
        return Before()
    remark = found.sentence
    if found.protocol_sha256 != protocol_sha256:
        remark += f"; of another protocol, {Path(found.protocol).name}"
    if found.participant and found.participant != participant:
        # Without the pseudonym, which could not be erased from somebody else's recording.
        remark += f"; rehearsed for {'another' if participant else 'a named'} participant"
    if found.state != "red":
        return Before(remark)
    red = "; ".join(f"{c.name}: {c.found}" for c in found.checks if c.state == "red")
    if not override.strip():
        raise StudyError(
            f"the preflight of {found.utc} is red ({red})",
            "Mend it and run `study preflight` again, or give a reason to begin all the same: "
            '--override-preflight "REASON"; it is recorded.',
        )
    why = " ".join(override.split())[:200]
    note = f"Begun although the preflight is red ({red[:300]}): {why}"
    return Before(f"{remark}; begun all the same: {why}", note)


def _table(found: Preflight) -> Table:
    title = f"Preflight, {found.seconds:.0f} s: {found.state}"
    table = Table(title=title, title_justify="left")
    for heading in ("", "Check", "Found", "What to do"):
        # A path that is cut off helps nobody.
        table.add_column(heading, overflow="fold")
    for check in found.checks:
        advice = f"{check.advice} Wanted: {check.wanted}." if check.advice else ""
        table.add_row(
            f"[{COLOURS[check.state]}]{check.state}[/]", check.name,
            escape(check.found), escape(advice),
        )  # fmt: skip
    return table
