"""The fleet as the shell sees it: asked now, answering now or later."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Protocol

from study.errors import StudyError
from study.families import load_member
from study.session.effects import StartFleet, StepFleet
from study.shell.fleet_host import FleetAnswer, FleetHost, FleetNews
from study.shell.picture_packing import Packed, Packer
from study.shell.shared_pictures import Laid, PictureShelf, PictureTaker, can_share
from study.shell.workers import Worker, WorkerFailure

EMERGENCY_KEY = "f12"
"""Stops all robots that are not simulated within the study, in any stage of a session."""


class Emergency(Protocol):
    """Stops robots without asking the fleet."""

    def press(self) -> None:
        """Stop all at once, without waiting; they stay stopped."""
        ...

    def close(self) -> None:
        """Free everything; robots stay as they are."""
        ...


class Fleet(Protocol):
    """Answers each request once, in order."""

    def request(
        self, effect: StartFleet | StepFleet, *, pictures: bool = False, keep: bool = False
    ) -> None:
        """Ask for an effect to be carried out.

        Args:
            effect: what the session asks for.
            pictures: whether the answer comes with pictures, if the task takes some.
            keep: whether they are kept until the next request, for `pack`.
        """
        ...

    def pack(self, robots: tuple[int, ...], *, anew: bool) -> None:
        """Ask for the pictures kept of some robots to be packed for the recording.

        Args:
            robots: from 0, ascending.
            anew: whether pictures are packed, too, that were packed before.
        """
        ...

    def add_artefact(self, artefact_id: str, kind: str, algorithm: str, weights: bytes) -> None:
        """Make a fit usable."""
        ...

    def poll(self, seconds: float = 0.0) -> FleetAnswer | FleetNews | Packed | None:
        """Return an answer, or what precedes it, if there is one within ``seconds``."""
        ...

    def close(self) -> None:
        """Free everything."""
        ...


@dataclasses.dataclass(frozen=True, slots=True)
class LookedAt:
    """An effect at which pictures are taken.

    Attributes:
        effect: what the session asks for.
        pictures: whether they come with the answer.
        keep: whether they are kept, to be packed.
        share: whether they are to be laid where the other process can take them.
    """

    effect: StartFleet | StepFleet
    pictures: bool
    keep: bool
    share: bool = False


@dataclasses.dataclass(frozen=True, slots=True)
class AnswerWithLaid:
    """An answer whose pictures lie in shared memory."""

    answer: FleetAnswer
    laid: Laid


@dataclasses.dataclass(frozen=True, slots=True)
class Pack:
    """Pictures that are to be packed; see `Fleet.pack`."""

    robots: tuple[int, ...]
    anew: bool


class InlineFleet:
    """Steps the task in this process: for tasks that take well under a millisecond."""

    def __init__(self, task: str, parameters: Mapping[str, object]) -> None:
        self._host = FleetHost(task, parameters)
        self._packer = Packer()
        self._answers: deque[FleetAnswer | Packed] = deque()

    def request(
        self, effect: StartFleet | StepFleet, *, pictures: bool = False, keep: bool = False
    ) -> None:
        """Carry out the effect at once; an answer that nobody took is let go."""
        self._answers = deque(each for each in self._answers if isinstance(each, Packed))
        asked = LookedAt(effect, pictures, keep)
        looked_at = pictures or keep
        self._answers.append(
            _looked_at(self._host, self._packer, asked) if looked_at else self._host.answer(effect)
        )

    def pack(self, robots: tuple[int, ...], *, anew: bool) -> None:
        """Pack at once."""
        self._answers.append(self._packer.pack(robots, anew=anew))

    def add_artefact(self, artefact_id: str, kind: str, algorithm: str, weights: bytes) -> None:
        """Make a fit usable."""
        self._host.add_artefact(artefact_id, kind, algorithm, weights)

    def poll(self, seconds: float = 0.0) -> FleetAnswer | Packed | None:  # noqa: ARG002 - never waits
        """Return an answer, once."""
        return self._answers.popleft() if self._answers else None

    def close(self) -> None:
        """Free the task."""
        self._host.close()


class ProcessFleet:
    """Steps the task in a process of its own: for tasks that are slow or may hang."""

    def __init__(self, task: str, parameters: Mapping[str, object]) -> None:
        self._worker = Worker(serve_fleet, task, dict(parameters), tells=True)
        self._taker = PictureTaker()
        self._shares = can_share()

    def request(
        self, effect: StartFleet | StepFleet, *, pictures: bool = False, keep: bool = False
    ) -> None:
        """Send the effect; the answer comes when it comes."""
        asked = LookedAt(effect, pictures, keep, self._shares)
        self._worker.send(asked if pictures or keep else effect)

    def pack(self, robots: tuple[int, ...], *, anew: bool) -> None:
        """Send the wish; it is met while nothing else is asked for."""
        self._worker.send(Pack(robots, anew))

    def add_artefact(self, artefact_id: str, kind: str, algorithm: str, weights: bytes) -> None:
        """Make a fit usable; requests are served in order, so no answer is needed."""
        self._worker.send((artefact_id, kind, algorithm, weights))

    def poll(self, seconds: float = 0.0) -> FleetAnswer | FleetNews | Packed | None:
        """Return an answer, or what precedes it, if there is one within ``seconds``."""
        answer: Any = self._worker.poll(seconds)
        if isinstance(answer, WorkerFailure):
            raise StudyError(f"the fleet failed: {answer.reason}")
        if answer == "artefact added":
            return None
        if isinstance(answer, AnswerWithLaid):
            return self._with_pictures(answer)
        return answer if isinstance(answer, FleetAnswer | FleetNews | Packed) else None

    def _with_pictures(self, given: AnswerWithLaid) -> FleetAnswer:
        try:
            return dataclasses.replace(given.answer, pictures=self._taker.take(given.laid))
        except OSError:
            # Some systems keep processes from each other's memory. The next ones come by the pipe.
            self._shares = False
            return given.answer

    def close(self) -> None:
        """End the process."""
        self._worker.close()


def serve_fleet(
    task: str, parameters: dict[str, object], tell: Callable[[FleetNews], None]
) -> Callable[[Any], Any]:
    """Make the serving function of the fleet's process."""
    host, packer, shelf = FleetHost(task, parameters, tell), Packer(), PictureShelf()

    def serve(request: Any) -> Any:  # noqa: ANN401 - effects and artefacts
        if isinstance(request, StartFleet | StepFleet):
            return host.answer(request)
        if isinstance(request, LookedAt):
            answer = _looked_at(host, packer, request)
            if not request.share or answer.pictures is None:
                return answer
            laid = shelf.lay(answer.pictures)
            return AnswerWithLaid(dataclasses.replace(answer, pictures=None), laid)
        if isinstance(request, Pack):
            return packer.pack(request.robots, anew=request.anew)
        host.add_artefact(*request)
        return "artefact added"

    return serve


def _looked_at(host: FleetHost, packer: Packer, asked: LookedAt) -> FleetAnswer:
    """Carry out an effect at which pictures are taken."""
    answer = host.answer(asked.effect, pictures=True)
    packer.keep(answer.request_id, answer.pictures if asked.keep else None)
    return answer if asked.pictures else dataclasses.replace(answer, pictures=None)


def open_fleet(task: str, parameters: Mapping[str, object]) -> Fleet:
    """Return the fleet that the task asks for: inline, or in a process of its own."""
    module = load_member("study.tasks", "task", task)
    if module.OUT_OF_PROCESS:
        return ProcessFleet(task, parameters)
    return InlineFleet(task, parameters)


def open_emergency(task: str, parameters: Mapping[str, object]) -> Emergency | None:
    """Return what stops the task's robots, or None where nothing can move that must be stopped.

    Raises:
        StudyError: the task has robots to stop, and cannot reach them.
    """
    module = load_member("study.tasks", "task", task)
    opener = getattr(module, "open_emergency", None)
    button: Emergency | None = opener(parameters) if opener is not None else None
    return button


def check_installed(task: str, parameters: Mapping[str, object]) -> None:
    """See that what the task is made of is installed; nothing of it is started.

    Raises:
        StudyError: it is not; the message says what to install.
    """
    missing_extra = getattr(load_member("study.tasks", "task", task), "missing_extra", None)
    if missing_extra is not None and (missing := missing_extra(parameters)):
        raise StudyError(f"the task {task} cannot run here", missing)


def check_live(task: str, parameters: Mapping[str, object]) -> None:
    """See that whatever the task needs outside of this computer's memory is there and lives.

    Raises:
        StudyError: it is not; the message says what.
    """
    check_installed(task, parameters)
    module = load_member("study.tasks", "task", task)
    check = getattr(module, "check_live", None)
    if check is not None:
        check(parameters)
