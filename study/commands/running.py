"""One session with a person at the keyboard."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Literal

from rich.markup import escape

from study.commands.composing import (
    Assignment,
    keeps_up,
    picture_records,
    session_opened,
    start_failover_recorder,
)
from study.commands.consenting import Given, ask_for_consent
from study.commands.deviations import tell_deviations, tell_gates
from study.commands.enrolling import Enrolled, Finished
from study.commands.listening import catch_up, open_link, tracker_of
from study.commands.resuming import (
    Boundary,
    RestoredFit,
    find_end,
)
from study.commands.terminal import errors
from study.errors import RecordingFailedError
from study.events.events import Event, SessionEnded
from study.events.experimenter_records import ExperimenterCommanded
from study.events.inputs import Input, SessionOpened
from study.events.shell import Note
from study.foxglove.live_tap import LiveTap
from study.loading import LoadedProtocol
from study.messages import messages_for
from study.protocol import StudyPart
from study.recording.failover import FailoverRecorder
from study.recording.parts import base_name
from study.recording.tapped import Tap, TappedRecorder
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.fitting import ProcessFitter
from study.shell.fleet import open_emergency, open_fleet
from study.shell.last_words import Ending, LastWords
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.lsl import LslOutlet
from study.shell.markers import MarkerPublisher
from study.shell.window import Window


@dataclasses.dataclass(frozen=True, slots=True)
class Seat:
    """The window that a participant gets, and who else sees the session.

    Attributes:
        size: of the window, pixels; None for the usual one, or the whole screen.
        fullscreen: whether it fills the screen.
        ui_scale: 1 to 2 times the size of text that suits the window.
        tap: a live view that gets the records too.
        lsl: whether markers are published to Lab Streaming Layer.
        remark: recorded when the session begins; empty for none.
        notes: the experimenter's first notes, taken when the session begins.
        last_words: keeps the window open where the session ends before its last screen; None
            closes it at once.
    """

    size: tuple[int, int] | None = None
    fullscreen: bool = False
    ui_scale: float = 1.0
    tap: LiveTap | None = None
    lsl: bool = False
    remark: str = ""
    notes: tuple[str, ...] = ()
    last_words: LastWords | None = None

    @contextmanager
    def holding(self, window: Window) -> Iterator[Window]:
        """Leave a window in the end; where the recording failed it says so."""
        try:
            yield window
        except RecordingFailedError:
            self.end_with(window, "failed")
            raise
        finally:
            self.leave(window)

    def leave(self, window: Window) -> None:
        """Close a window, unless last words keep it."""
        if self.last_words is None or not self.last_words.keeps(window):
            window.close()

    def end_with(self, window: Window, ending: Ending) -> None:
        """Let last words keep a window that is held, if there are any."""
        if self.last_words is not None:
            self.last_words.keep(window, ending)

    def open_window(self, study: StudyPart) -> Window:
        """Open the window under the study's title, in its language.

        Raises:
            StudyError: there is no display, or the size or scale cannot be had.
        """
        return Window(
            self.size,
            fullscreen=self.fullscreen,
            ui_factor=self.ui_scale,
            caption=study.title,
            messages=messages_for(study.language),
        )


def run_session(
    loaded: LoadedProtocol,
    assignment: Assignment,
    folder: Path,
    seat: Seat,
    enrolled: Enrolled,
    *,
    recorded: Mapping[str, bytes] | None = None,
) -> Finished:
    """Run a session in a window.

    Args:
        loaded: the protocol.
        assignment: who takes part, and in which order.
        folder: where the recording goes.
        seat: the window, and who else watches.
        enrolled: the participant's place in the register.
        recorded: weights of other participants' scorers, by artefact id.

    Returns:
        What it came to.

    Raises:
        RecordingFailedError: it could not be recorded to its end.
        StudyError: ``lsl`` is asked for and cannot be had; nothing was recorded then.
    """
    given, window = Given(), None
    if loaded.protocol.consent:
        # Nothing may be written before it, so the window opens before the writer starts.
        window = seat.open_window(loaded.protocol.study)
        answer = _asked(loaded, window, folder, seat)
        if answer is None:
            return Finished((), "declined")
        given = answer
    opened = session_opened(
        loaded, assignment, consent_sha256=given.sha256, consented_utc=given.utc
    )
    # The writer starts before anything that could take the study down, and ends last.
    recorder = start_failover_recorder(folder, loaded, opened, pilot=assignment.pilot)
    beginning = _Beginning(
        opened,
        lambda _: opened,
        recorded=recorded or {},
        window=window,
        folder=folder,
        enrolled=enrolled,
    )
    return _run(loaded, recorder, beginning, seat)


def _asked(loaded: LoadedProtocol, window: Window, folder: Path, seat: Seat) -> Given | None:
    """Ask for consent; the window stays open if it is given, or last words keep it."""
    answer: Given | Literal["declined", "closed"] = "closed"
    try:
        answer = ask_for_consent(loaded, window, folder)
        if answer == "declined":
            seat.end_with(window, "declined")
    finally:
        if not isinstance(answer, Given):
            seat.leave(window)
    return answer if isinstance(answer, Given) else None


def resume_session(
    loaded: LoadedProtocol,
    boundary: Boundary,
    folder: Path,
    seat: Seat,
    *,
    pilot: bool = False,
    recorded: Mapping[str, bytes] | None = None,
) -> Finished:
    """Go on with a session in a window, from a boundary; see `run_session`."""
    end = find_end(boundary.recording)
    recorder = start_failover_recorder(
        folder,
        loaded,
        boundary.opened,
        name=base_name(boundary.recording.path),
        part=end.part + 1,
        first_sequence=end.sequence + 1,
        pilot=pilot,
    )
    beginning = _Beginning(
        boundary.opened,
        lambda t_ns: end.resumed(boundary.after_sequence, t_ns, time.time_ns()),
        session=boundary.session,
        fits=boundary.fits,
        start_ns=end.t_ns + 1,
        recorded=recorded or {},
        folder=folder,
        earlier=tuple(part.path for part in boundary.recording.parts),
        boundary=boundary,
    )
    return _run(loaded, recorder, beginning, seat)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Beginning:
    """How a session starts in this process.

    Attributes:
        opened: the session's first input of all.
        first_input: given the session's time, what is fed first.
        session: as it is before that.
        fits: what the fleet must know already.
        start_ns: the session's time at the start.
        recorded: weights of other participants' scorers, by artefact id.
        window: open already, if consent was asked for in it.
        folder: where the recordings are.
        earlier: files of the session that were finished before.
        enrolled: told when the first input is recorded; None if the session is known to run.
        boundary: where a resumed session goes on; None if it begins.
    """

    opened: SessionOpened
    first_input: Callable[[int], Input]
    session: Session = dataclasses.field(default_factory=Session)
    fits: tuple[RestoredFit, ...] = ()
    start_ns: int = 0
    recorded: Mapping[str, bytes] = dataclasses.field(default_factory=dict)
    window: Window | None = None
    folder: Path = Path()
    earlier: tuple[Path, ...] = ()
    enrolled: Enrolled | None = None
    boundary: Boundary | None = None


def _run(
    loaded: LoadedProtocol,
    recorder: FailoverRecorder,
    beginning: _Beginning,
    seat: Seat,
) -> Finished:
    reasons: list[str] = []

    def note_end(numbered: Sequence[tuple[int, Event]]) -> None:
        reasons.extend(event.reason for _, event in numbered if isinstance(event, SessionEnded))

    with ExitStack() as stack:
        stack.callback(_close, recorder, recorder.sent_sequence)
        outlet = LslOutlet(beginning.opened) if seat.lsl else None
        if outlet:
            stack.callback(outlet.close)
        task = loaded.protocol.task
        fleet = stack.enter_context(closing(open_fleet(task.name, task.parameters)))
        emergency = open_emergency(task.name, task.parameters)
        if emergency:
            stack.callback(emergency.close)
        for fit in beginning.fits:
            fleet.add_artefact(fit.artefact_id, fit.kind, fit.algorithm, fit.weights)
        fitter = stack.enter_context(closing(ProcessFitter(loaded.description, beginning.recorded)))
        window = stack.enter_context(
            seat.holding(beginning.window or seat.open_window(loaded.protocol.study))
        )
        session, clock, tap = beginning.session, LiveClock(beginning.start_ns), seat.tap
        tracker = tracker_of(loaded, beginning.opened, recorder.path.name)
        if beginning.boundary:
            catch_up(tracker, beginning.boundary)
        taps: list[Tap] = [tracker] if tap is None else [tracker, tap]
        conductor = Conductor(
            session,
            TappedRecorder(recorder, *taps),
            fleet,
            fitter,
            epoch_ns=clock.epoch_ns,
            waits_for_disk=True,
            on_pictures=window.pictures.take,
            picture_records=picture_records(
                loaded, lambda: keeps_up(recorder, clock.epoch_ns + clock.now())
            ),
        )
        link = open_link(
            beginning.opened.session_id, tracker, recorder, lambda: clock.epoch_ns + clock.now()
        )
        if link:
            stack.callback(link.close)
        publisher = MarkerPublisher(outlet, clock.now, conductor.observe) if outlet else None
        if publisher:
            conductor.watch(publisher.publish)
        conductor.watch(tell_deviations)
        conductor.watch(tell_gates)
        conductor.watch(note_end)
        if beginning.enrolled:
            beginning.enrolled.begin()
        conductor.feed(beginning.first_input(clock.now()))
        if seat.remark:
            conductor.observe(Note(clock.now(), seat.remark))
        for note in seat.notes:
            # Like those taken at the console: they are in notes, tables and report.
            conductor.feed(ExperimenterCommanded(clock.now(), "annotate", note))
        loop = LiveLoop(conductor, window, recorder, clock, link, emergency)
        loop.run()
        if not (session.complete or loop.asked_to_close):
            seat.end_with(window, "ended")
        if tap is not None:
            remark = f"live view: {tap.passed} records passed on, {tap.dropped} dropped"
            conductor.observe(Note(clock.now(), remark))
    if publisher and publisher.failure:
        errors.print(
            f"[yellow]Markers for LSL stopped during the session: {escape(publisher.failure)}[/]"
        )
    paths = recorder.close()
    if conductor.erase_asked:
        return Finished((*beginning.earlier, *paths), "erased")
    outcome: Literal["complete", "ended_early"] = "complete" if session.complete else "ended_early"
    return Finished(tuple(paths), outcome, reasons[-1] if reasons else "")


def _close(recorder: FailoverRecorder, before: int) -> None:
    """Close a recording; remove it if nothing was recorded, as when no window opens."""
    paths = recorder.close()
    if recorder.sent_sequence == before:
        for path in paths:
            path.unlink()
