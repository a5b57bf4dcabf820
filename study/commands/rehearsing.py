"""A session before the participant comes: a simulated one takes their place, nothing is kept."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterator, Mapping, Sequence

from study.commands.composing import Assignment
from study.commands.recorded_scorers import recorded_weights
from study.commands.unrecorded import NoRecorder, run_unrecorded
from study.errors import StudyError
from study.events.fields import Record
from study.loading import LoadedProtocol
from study.messages import messages_for
from study.preflight_result import Check
from study.recording.wire import encode
from study.screens import FleetScreen, Screen
from study.session.effects import RequestFit
from study.shell.fitting import FitAnswer, InlineFitter
from study.shell.virtual_loop import VirtualClock

RECORDS_BESIDE = 1.5
"""Times what a session's records take: index, descriptors, and what only a window records."""


class _Scales(NoRecorder):
    """Weighs what a session would record."""

    def __init__(self) -> None:
        self.bytes = 0

    def write(self, record: Record, log_time_ns: int) -> int:  # noqa: ARG002
        """Weigh one record."""
        self.bytes += len(encode(record))
        return 0


class _WatchedFitter(InlineFitter):
    """Keeps what became of each fit."""

    def __init__(self, loaded: LoadedProtocol, recorded: Mapping[str, bytes]) -> None:
        super().__init__(loaded.description, recorded)
        self.fits: list[tuple[RequestFit, FitAnswer]] = []

    def poll(self, seconds: float = 0.0) -> FitAnswer | None:
        """Return the answer, once."""
        answer = super().poll(seconds)
        if answer is not None:
            self.fits.append((answer.request, answer))
        return answer


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Rehearsal:
    """What a rehearsed session was like.

    Attributes:
        checks: of the sequence and of the fits.
        fleet: the screen with the most robots; None if it came to none.
        texts: all that the participant read.
        bytes: that a session records at most.
    """

    checks: tuple[Check, ...]
    fleet: FleetScreen | None
    texts: frozenset[str]
    bytes: int


def rehearse(
    loaded: LoadedProtocol, assignment: Assignment, recorded: Mapping[str, bytes] | None = None
) -> Rehearsal:
    """Run a participant's sequence with a simulated participant in virtual time.

    Args:
        loaded: the protocol.
        assignment: seed and order as the participant will have them.
        recorded: weights of other participants' scorers, by artefact id; by default those of the
            recordings that the protocol names.
    """
    scales, clock = _Scales(), VirtualClock()
    fitter = _WatchedFitter(loaded, recorded_weights(loaded) if recorded is None else recorded)
    fleets: dict[int, FleetScreen] = {}
    texts: set[str] = set()

    def see(screen: Screen) -> None:
        if isinstance(screen, FleetScreen):
            fleets[len(screen.tiles)] = screen
        else:
            texts.update(_texts(screen))

    complete, failure, began = False, "", time.perf_counter()
    try:
        complete = run_unrecorded(
            loaded,
            assignment,
            messages_for(loaded.protocol.study.language),
            clock,
            fitter=fitter,
            on_show=see,
            recorder=scales,
        ).complete
    except StudyError as error:
        failure = str(error)
    order = " then ".join(assignment.order)
    if not complete:
        failure = failure or f"ended early ({order})"
    # Green all the same: whether paper is signed cannot be seen from here.
    consent = "" if loaded.protocol.consent else "; no consent page: ask on paper"
    took = f"{order}: {clock.now_ns / 60e9:.0f} simulated minutes in "
    sequence = _sequence(failure, f"{took}{time.perf_counter() - began:.1f} s{consent}")
    return Rehearsal(
        checks=(sequence, _fits(fitter.fits, complete=complete)),
        fleet=fleets[max(fleets)] if fleets else None,
        texts=frozenset(texts),
        bytes=round(scales.bytes * RECORDS_BESIDE),
    )


def _sequence(failure: str, course: str) -> Check:
    wanted = "every stage passed"
    if failure:
        return Check(name="rehearsal", state="red", found=failure, wanted=wanted,
                     advice="Look at the protocol with `study simulate`.")  # fmt: skip
    return Check(name="rehearsal", state="green", found=course, wanted=wanted)


def _fits(fits: Sequence[tuple[RequestFit, FitAnswer]], *, complete: bool) -> Check:
    wanted = "each within half of its budget"
    failed = [
        f"{request.artefact_id}: {answer.reason}" for request, answer in fits if answer.reason
    ]
    if failed:
        return Check(name="fits", state="red", found="; ".join(failed)[:300], wanted=wanted,
                     advice="Ask for more choices or episodes in the protocol.")  # fmt: skip
    if not fits and not complete:
        found = "not seen: the rehearsal did not get there"
        return Check(name="fits", state="amber", found=found, wanted=wanted)
    if not fits:
        return Check(name="fits", state="green", found="the protocol asks for none", wanted=wanted)
    request, slowest = max(fits, key=lambda fit: fit[1].seconds / fit[0].budget_seconds)
    share = slowest.seconds / request.budget_seconds
    state = "red" if share >= 1 else "amber" if share >= 0.5 else "green"
    return Check(
        name="fits", state=state,
        found=f"{len(fits)} fits; {request.artefact_id} took {slowest.seconds:.2f} s of "
        f"{request.budget_seconds:g} s",
        wanted=wanted,
        advice="" if state == "green" else "Use a faster computer, or a larger fit_budget_seconds.",
    )  # fmt: skip


def _texts(value: object) -> Iterator[str]:
    """Yield every text in a screen."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, tuple):
        for item in value:
            yield from _texts(item)
    elif dataclasses.is_dataclass(value):
        for field in dataclasses.fields(value):
            yield from _texts(getattr(value, field.name))
