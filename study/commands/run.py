"""`study run`: seat a person at a keyboard."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from study.commands.composing import lock_warning
from study.commands.kept_folder import check_kept
from study.commands.preflight import preflight_before
from study.commands.recorded_scorers import parse_overrides, recorded_weights
from study.commands.terminal import console, errors, shown_path, tell
from study.enrolment.importing import NOT_UNDERSTOOD
from study.enrolment.pseudonyms import check_participant
from study.errors import StudyError
from study.foxglove.live_tap import DEFAULT_PORT, LOOPBACK, LiveTap, require_live
from study.loading import load_protocol
from study.messages import messages_for
from study.output_option import folder_wanted
from study.shell.pygame_check import require_pygame_ce

if TYPE_CHECKING:
    from study.commands.enrolling import Finished
    from study.shell.last_words import LastWords


def run(
    protocol: Annotated[str, typer.Argument(help="Protocol file, or name of a shipped one.")],
    given: Annotated[
        str | None,
        typer.Option("--participant", "-p", help="Pseudonymous id; default: one is drawn."),
    ] = None,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", callback=folder_wanted, help="Folder of the recordings."),
    ] = Path("recordings"),
    order: Annotated[
        str, typer.Option(help="Conditions in order, by commas; default: that of the slot.")
    ] = "",
    seed: Annotated[int | None, typer.Option(min=0, max=2**63 - 1, help="Session seed.")] = None,
    size: Annotated[str, typer.Option(help="Window size, such as 1280x960.")] = "",
    fullscreen: Annotated[bool, typer.Option("--fullscreen", help="Fill the screen.")] = False,  # noqa: FBT002
    ui_scale: Annotated[
        float, typer.Option(help="Text 1 to 2 times the size that suits the window.")
    ] = 1.0,
    again: Annotated[  # noqa: FBT002
        bool, typer.Option("--again", help="Allow a participant who has a recording.")
    ] = False,
    pilot: Annotated[  # noqa: FBT002
        bool, typer.Option("--pilot", help="A pilot: counted apart, and not analysed.")
    ] = False,
    scorer: Annotated[
        list[str] | None,
        typer.Option(help="NAME=PATH: take a recorded scorer from that recording."),
    ] = None,
    resume: Annotated[  # noqa: FBT002
        bool, typer.Option("--resume", help="Go on with a session that broke off.")
    ] = False,
    live: Annotated[  # noqa: FBT002
        bool, typer.Option("--live", help="Let an experimenter watch in Foxglove.")
    ] = False,
    live_host: Annotated[
        str, typer.Option("--live-host", help="Address of the live view.")
    ] = LOOPBACK[0],
    live_port: Annotated[
        int,
        typer.Option("--live-port", min=0, max=65535, help="Its port; 0: any that is free."),
    ] = DEFAULT_PORT,
    override_preflight: Annotated[
        str,
        typer.Option("--override-preflight", help="Why to begin although the preflight is red."),
    ] = "",
    lsl: Annotated[  # noqa: FBT002
        bool, typer.Option("--lsl", help="Publish markers to Lab Streaming Layer.")
    ] = False,
) -> None:
    """Run one session with a person at the keyboard, in a window."""
    from study.commands import enrolling  # noqa: PLC0415 - slow to import
    from study.commands.given import check_given  # noqa: PLC0415
    from study.commands.resuming import find_boundary  # noqa: PLC0415
    from study.commands.running import (  # noqa: PLC0415 - pygame is slow to import
        Seat,
        resume_session,
        run_session,
    )
    from study.commands.space import tell_space  # noqa: PLC0415
    from study.shell import last_words as words  # noqa: PLC0415
    from study.shell.fleet import check_installed, check_live  # noqa: PLC0415
    from study.shell.lsl import load_pylsl  # noqa: PLC0415
    from study.shell.window import check_size, check_ui_scale  # noqa: PLC0415

    require_pygame_ce()
    if live:
        require_live()
    if lsl:
        load_pylsl()
    loaded = load_protocol(protocol)
    if warning := lock_warning(loaded):
        errors.print(f"[yellow]{escape(warning)}[/]")
    check_installed(loaded.protocol.task.name, loaded.protocol.task.parameters)
    window_size = check_size(parse_size(size))
    check_ui_scale(ui_scale)
    # An empty id is a slip, as of a variable that was never set: no pseudonym is drawn for it.
    participant = "" if given is None else check_participant(given)
    recorded = recorded_weights(loaded, parse_overrides(scorer or []))
    if resume:
        if again or order or seed is not None or pilot:
            raise StudyError(
                "--resume keeps the session's order, seed and slot, and begins no other session",
                "Leave out --again, --order, --seed and --pilot.",
            )
        check_kept(output)
    else:
        check_given(loaded, participant, order, output)
    # A red preflight is no answer to somebody who made a slip.
    before = preflight_before(output, loaded.sha256, override_preflight, participant)
    check_live(loaded.protocol.task.name, loaded.protocol.task.parameters)
    tell_space(loaded, output, recorded)
    # All that can be refused is refused by now, or by the live view: nobody has a slot for nothing.
    with closing(words.LastWords(messages_for(loaded.protocol.study.language))) as last_words:
        with _told_first(last_words), ExitStack() as stack:
            tap = stack.enter_context(_live_view(live_host, live_port, wanted=live))
            if resume:
                whose = participant or check_participant(enrolling.who_broke_off(loaded, output))
                boundary = find_boundary(loaded, whose, output)
                enrolled = enrolling.Enrolled(loaded, whose, output)
                known = enrolled.resume()
                console.print(enrolling.announce_resumed(boundary, known))
                session = partial(resume_session, loaded, boundary, output, pilot=known.pilot)
                order_note = ""
            else:
                assignment = enrolling.assign(
                    loaded, participant, output, order=order, seed=seed, again=again, pilot=pilot
                )
                enrolled = enrolling.Enrolled(loaded, assignment.participant, output)
                console.print(enrolling.announce(assignment))
                enrolling.tell_place(loaded, assignment, output)
                session = partial(run_session, loaded, assignment, output, enrolled=enrolled)
                order_note = assignment.remark
            stack.enter_context(enrolled)
            seat = Seat(
                window_size,
                fullscreen=fullscreen,
                ui_scale=ui_scale,
                tap=tap,
                lsl=lsl,
                remark=before.remark,
                notes=tuple(filter(None, (before.note, order_note))),
                last_words=last_words,
            )
            finished = session(seat=seat, recorded=recorded)
            enrolled.write_back(finished)
        own = {"--again": again, "--order": order, "--seed": seed is not None, "--pilot": pilot}
        whose = "" if participant or resume else assignment.participant
        _tell_outcome(finished, whose, [option for option, is_given in own.items() if is_given])
        if finished.outcome == "erased":
            last_words.say("erased")
        if last_words.awaited:
            console.print("The participant's window is closed by Enter.")
        last_words.wait()
    if finished.outcome != "complete":
        raise typer.Exit(3)


@contextmanager
def _told_first(last_words: LastWords) -> Iterator[None]:
    """Tell what went wrong before the participant's window is waited for, not after."""
    try:
        yield
    except StudyError as error:
        if not last_words.awaited:
            raise
        tell(error)
        last_words.wait()
        raise typer.Exit(error.exit_status) from error


def _tell_outcome(finished: Finished, drawn: str, not_resumed: Sequence[str]) -> None:
    """Print what a session came to.

    Args:
        finished: that.
        drawn: the participant's pseudonym where none was given.
        not_resumed: the options given that a session is not resumed with.
    """
    if finished.outcome == "erased":
        return
    if finished.outcome == "declined":
        errors.print("[yellow]No recording: the participant did not consent.[/]")
        return
    for path in finished.paths:
        console.print(f"Recorded in {shown_path(path)}")
    if finished.outcome == "complete":
        return
    go_on = f"To go on where it broke off, say the same {_with_resume(drawn, not_resumed)}."
    if finished.reason == NOT_UNDERSTOOD:
        go_on = f"The participant is excluded: {finished.reason}."
    errors.print(
        f"[yellow]The session was ended early; the recording holds what there was.[/] {go_on}"
    )


def _with_resume(drawn: str, not_resumed: Sequence[str]) -> str:
    """Say how a command differs that goes on with a session."""
    whose = f"--participant {drawn} and " if drawn else ""
    without = f", without {' and '.join(not_resumed)}" if not_resumed else ""
    return f"with {whose}--resume{without}"


@contextmanager
def _live_view(host: str, port: int, *, wanted: bool) -> Iterator[LiveTap | None]:
    """Start a live view if one is wanted, and say where it is; end it in the end."""
    if not wanted:
        yield None
        return
    if host not in LOOPBACK:
        errors.print(
            f"[bold yellow]Careful:[/] everyone who can reach {escape(host)} can watch the session."
        )
    tap = LiveTap.start(host, port)
    try:
        console.print(f"Live view for Foxglove: {escape(tap.url)}")
        yield tap
    finally:
        tap.close()
        if tap.dropped:
            why = "it ended early" if tap.ended else "it was too slow"
            missed = f"The live view missed {tap.dropped} records: {why}."
            errors.print(f"{missed} The recording has them.")


def parse_size(given: str) -> tuple[int, int] | None:
    """Return (width, height) of "1280x960"; None if empty.

    Raises:
        StudyError: it is no size.
    """
    if not given:
        return None
    width, _, height = given.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise StudyError(f'window size "{given}"', "Give width x height in pixels: 1280x960.")
    return int(width), int(height)
