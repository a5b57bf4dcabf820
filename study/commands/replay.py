"""`study replay`: watch a recording again, or prove that its events follow from its inputs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.terminal import console, errors
from study.errors import StudyError
from study.output_option import new_file_wanted
from study.recording.parts import part_files, recordings_in
from study.shell.pygame_check import require_pygame_ce

_SOMETHING_MISSING = 3


def replay(
    files: Annotated[
        list[Path],
        typer.Argument(help="Recording to watch; to verify, several or folders of them."),
    ],
    participant_view: Annotated[  # noqa: FBT002
        bool,
        typer.Option(
            "--participant-view/--analyst-view",
            help="The participant's screen alone, or with timeline and every robot's score.",
        ),
    ] = False,
    video: Annotated[
        Path | None,
        typer.Option(help="Write a video (VP9 in WebM) to this new file; open no window."),
    ] = None,
    trial: Annotated[
        int | None, typer.Option(min=0, help="Only this trial: its trial_id in the tables.")
    ] = None,
    first: Annotated[
        str, typer.Option("--from", help='Begin at this session time: "12:34.5" or seconds.')
    ] = "",
    last: Annotated[str, typer.Option("--to", help="End of the video: a session time.")] = "",
    speed: Annotated[
        float, typer.Option(min=0.25, max=16, help="Seconds of the session in a second.")
    ] = 1.0,
    size: Annotated[
        str, typer.Option(help="Window or video: 1280x960; default: what suits the recording.")
    ] = "",
    rate: Annotated[int, typer.Option(min=1, max=60, help="Frames a second of a video.")] = 30,
    ui_scale: Annotated[
        float, typer.Option(help="The --ui-scale that the session was run with.")
    ] = 1.0,
    verify: Annotated[  # noqa: FBT002
        bool, typer.Option("--verify", help="Show nothing; compare the events byte for byte.")
    ] = False,
    resimulate: Annotated[  # noqa: FBT002
        bool, typer.Option("--resimulate", help="Also step the task anew and compare.")
    ] = False,
) -> None:
    """Watch a session as the participant saw it, from the recorded inputs alone.

    Of a session in several parts one is enough: the others beside it are found. Keys: space
    plays and pauses, left and right go 5 s, up and down change the speed, n and p go to the next
    and previous takeover, t and r to the next and previous trial, v changes the view, q ends. A
    click on a timeline goes there.

    Exit status 0: all was shown, or agrees. 1: with --verify or --resimulate, something differs,
    or a file is not whole, so that only a part could be compared. 3: the video lacks what the
    recording lacks.
    """
    if verify or resimulate:
        if video is not None:
            raise StudyError("--video with --verify or --resimulate", "Ask for one at a time.")
        _verify(files, resimulate=resimulate)
        return
    if video is not None and video.suffix.lower() != ".webm":
        raise StudyError(f"{video}: a video is WebM", f"Name it {video.with_suffix('.webm')}.")
    if video is not None:
        new_file_wanted("--video", video)
    from study.commands.run import parse_size  # noqa: PLC0415 - slow to import

    require_pygame_ce()
    from study.commands.replaying import Wish, film, watch  # noqa: PLC0415

    if len(files) > 1:
        raise StudyError(f"{len(files)} recordings to watch", "Give one, or say --verify.")
    wish = Wish(
        view="participant" if participant_view else "analyst",
        trial=trial,
        first=first,
        last=last,
        size=parse_size(size),
        speed=speed,
        rate=rate,
        ui_scale=ui_scale,
    )
    (file,) = files
    if file.is_dir():
        there = len(recordings_in(file))
        raise StudyError(
            f"{file} is a folder, of {there} recordings" if there else f"{file} is a folder",
            "Give one recording (*.mcap) to watch; --verify takes folders.",
        )
    if video is None:
        watch(file, wish)
    elif not film(file, wish, video):
        raise typer.Exit(_SOMETHING_MISSING)


def _verify(files: list[Path], *, resimulate: bool) -> None:
    """Verify sessions, each once; exit with status 1 if not all agrees."""
    sessions: dict[tuple[Path, ...], Path] = {}
    for given in files:
        found = recordings_in(given) if given.is_dir() else [given]
        if given.is_dir() and not found:
            raise StudyError(f"no recordings in {given}", "Give recordings (*.mcap), or a folder.")
        for file in found:
            if not file.is_file():
                raise StudyError(f"no recording or folder {file}", "Give recordings (*.mcap).")
            sessions.setdefault(tuple(part_files(file)), file)
    whole = True
    for file in sessions.values():
        if len(sessions) > 1:
            console.print(f"[bold]{escape(file.name)}[/]")
        whole &= _replayed(file, resimulate=resimulate)
    if not whole:
        raise typer.Exit(1)


def _replayed(file: Path, *, resimulate: bool) -> bool:
    """Replay one session, say what was found, and return whether all agrees."""
    from study.verification import verify  # noqa: PLC0415 - slow to import

    verdict = verify(file, resimulate=resimulate)
    console.print(f"{verdict.inputs} inputs replayed, {verdict.events} events compared")
    if verdict.parts > 1:
        console.print(
            f"The session has {verdict.parts} parts; fleet runs broken off and left out: "
            f"{verdict.left_out_trials}"
        )
    if resimulate:
        console.print(
            f"{verdict.resimulated} fleet answers stepped anew, "
            f"largest difference of a state {verdict.largest_deviation:g}"
        )
    if not verdict.matches:
        errors.print(f"[bold red]Different:[/] {escape(verdict.difference)}")
        return False
    if verdict.problems:
        errors.print("[bold yellow]Not whole:[/] what can be read agrees, but")
        for problem in verdict.problems:
            errors.print(f"  {escape(problem)}")
        return False
    console.print("[green]Identical:[/] every event follows from the inputs, byte for byte.")
    return True
