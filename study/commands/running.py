"""One session with a person at the keyboard."""

from __future__ import annotations

from contextlib import ExitStack, closing
from pathlib import Path

from study.commands.composing import (
    Assignment,
    check_participant,
    next_order,
    orders_used,
    seed_from,
    session_opened,
    start_recorder,
)
from study.errors import StudyError
from study.loading import LoadedProtocol
from study.recording.client import Recorder
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.fitting import ProcessFitter
from study.shell.fleet import open_fleet
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.window import Window


def assign(
    loaded: LoadedProtocol,
    participant: str,
    folder: Path,
    *,
    order: str = "",
    seed: int | None = None,
    again: bool = False,
) -> Assignment:
    """Decide order and seed of a person's session.

    Args:
        loaded: the protocol.
        participant: pseudonymous id.
        folder: where this study's recordings are: the order run least often there is taken.
        order: conditions separated by commas, to overrule.
        seed: to overrule the one derived from participant and protocol.
        again: whether a participant who has a recording may take part again.

    Raises:
        StudyError: the id cannot be used, has a recording, or the order is none.
    """
    participant = check_participant(participant)
    used = orders_used(folder, loaded.protocol.study.name) if folder.is_dir() else {}
    if participant in used and not again:
        raise StudyError(
            f'participant "{participant}" already has a recording in {folder}',
            "Give another id, or say --again if this person really takes part once more.",
        )
    names = {condition.name for condition in loaded.protocol.conditions}
    chosen = tuple(part.strip() for part in order.split(",") if part.strip())
    if chosen and (set(chosen) != names or len(chosen) != len(names)):
        raise StudyError(
            f'"{order}" is no order of these conditions',
            f"Name each condition once: {','.join(sorted(names))}.",
        )
    return Assignment(
        participant=participant,
        seed=seed if seed is not None else seed_from(f"{loaded.sha256} {participant}"),
        order=chosen or next_order(loaded, list(used.values())),
        planned_index=len(used),
        operator_kind="person",
    )


def run_session(
    loaded: LoadedProtocol,
    assignment: Assignment,
    folder: Path,
    *,
    size: tuple[int, int] | None,
    fullscreen: bool,
) -> tuple[Path, bool]:
    """Run a session in a window.

    Returns:
        The recording, and whether every stage was passed.
    """
    opened = session_opened(loaded, assignment)
    with ExitStack() as stack:
        # The writer starts before anything that could take the study down, and ends last.
        recorder = start_recorder(folder, loaded, opened)
        stack.callback(_close, recorder)
        task = loaded.protocol.task
        fleet = stack.enter_context(closing(open_fleet(task.name, task.parameters)))
        fitter = stack.enter_context(closing(ProcessFitter(loaded.description)))
        title = loaded.protocol.study.title
        window = stack.enter_context(closing(Window(size, fullscreen=fullscreen, caption=title)))
        session, clock = Session(), LiveClock()
        conductor = Conductor(
            session, recorder, fleet, fitter, epoch_ns=clock.epoch_ns, waits_for_disk=True
        )
        conductor.feed(opened)
        LiveLoop(conductor, window, recorder, clock).run()
    return recorder.close(), session.complete


def _close(recorder: Recorder) -> None:
    """Close a recording; remove it if the session never began, as when no window opens."""
    path = recorder.close()
    if recorder.sent_sequence == 0:
        path.unlink()
