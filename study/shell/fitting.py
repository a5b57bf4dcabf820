"""Fits: single-threaded, in one spawned process, or inline where nobody waits."""

from __future__ import annotations

import dataclasses
import json
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.events.task_description import TaskDescription
from study.families import load_member
from study.map_grid import score_grid
from study.policies.base import FitResult
from study.scorers._threads import use_one_thread, warm_up
from study.session.effects import RequestFit
from study.shell.workers import Worker, WorkerFailure


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class FitAnswer:
    """The answer to a fit request.

    Attributes:
        reason: why it failed; empty if it did not.
        timed_out: whether it was given up.
    """

    request: RequestFit
    weights: bytes = b""
    preparation: bytes = b""
    seconds: float = 0.0
    metrics: dict[str, float] = dataclasses.field(default_factory=dict)
    score_grid: npt.NDArray[np.float64] = dataclasses.field(default_factory=lambda: np.empty(0))
    reason: str = ""
    timed_out: bool = False


def fit(request: RequestFit, description: TaskDescription) -> FitAnswer:
    """Carry out one fit on one thread; never raises for what data can cause."""
    began = time.perf_counter()
    package = "study.policies" if request.kind == "policy" else "study.scorers"
    try:
        if request.kind == "scorer":
            use_one_thread()
        module = load_member(package, request.kind, request.algorithm)
        parameters = module.Parameters.model_validate(json.loads(request.parameters_json))
        result = _fitted(module, request, description, parameters)
        grid = np.empty(0)
        controls = getattr(module, "IS_CONTROL", False)
        if request.kind == "scorer" and not controls and not request.background:
            grid = score_grid(module.load(result.weights, description), description)
    except (StudyError, ValueError, ArithmeticError, MemoryError) as error:
        said = error.sentence if isinstance(error, StudyError) else str(error)
        return FitAnswer(request, reason=said or type(error).__name__)
    return FitAnswer(
        request,
        weights=result.weights,
        preparation=result.preparation,
        seconds=time.perf_counter() - began,
        metrics=result.metrics,
        score_grid=grid,
    )


def _fitted(
    module: Any,  # noqa: ANN401 - a member of a family
    request: RequestFit,
    description: TaskDescription,
    parameters: Any,  # noqa: ANN401 - the member's own
) -> FitResult:
    """Let a policy or scorer be fitted; one that can goes on from what it is given."""
    if getattr(module, "WARM_STARTS", False):
        result: FitResult = module.fit(
            request.arrays, description, parameters, request.seed, request.start
        )
        return result
    cold: FitResult = module.fit(request.arrays, description, parameters, request.seed)
    return cold


class Fitter(Protocol):
    """Answers fit requests, one at a time, in their order."""

    def request(self, effect: RequestFit) -> None:
        """Ask for a fit."""
        ...

    def poll(self, seconds: float = 0.0) -> FitAnswer | None:
        """Return the answer if there is one within ``seconds``."""
        ...

    def close(self) -> None:
        """Free everything."""
        ...


def with_weights(effect: RequestFit, recorded: Mapping[str, bytes]) -> RequestFit:
    """Return the request with the weights that the shell read for it, if there are any."""
    weights = recorded.get(effect.artefact_id)
    if weights is None:
        return effect
    arrays = {**effect.arrays, "weights": np.frombuffer(weights, dtype=np.uint8)}
    return dataclasses.replace(effect, arrays=arrays)


class InlineFitter:
    """Fits at once, in this process: for simulated sessions. It cannot give up.

    Args:
        description: the task's.
        recorded: weights of other participants' scorers, by artefact id.
    """

    def __init__(
        self, description: TaskDescription, recorded: Mapping[str, bytes] | None = None
    ) -> None:
        self._description = description
        self._recorded = recorded or {}
        self._answers: deque[FitAnswer] = deque()

    def request(self, effect: RequestFit) -> None:
        """Fit at once."""
        self._answers.append(fit(with_weights(effect, self._recorded), self._description))

    def poll(self, seconds: float = 0.0) -> FitAnswer | None:  # noqa: ARG002 - never waits
        """Return each answer once."""
        return self._answers.popleft() if self._answers else None

    def close(self) -> None:
        """Nothing is held."""


class ProcessFitter:
    """Fits in a process of its own, so that the picture goes on; gives up over budget.

    Args:
        description: the task's.
        recorded: weights of other participants' scorers, by artefact id.
    """

    def __init__(
        self, description: TaskDescription, recorded: Mapping[str, bytes] | None = None
    ) -> None:
        self._description = description
        self._recorded = recorded or {}
        self._worker = Worker(serve_fits, description)
        self._pending: RequestFit | None = None
        self._waiting: deque[RequestFit] = deque()
        self._deadline = 0.0

    def request(self, effect: RequestFit) -> None:
        """Send the request, or keep it until those before it are answered."""
        self._waiting.append(with_weights(effect, self._recorded))
        self._send_next()

    def _send_next(self) -> None:
        """Send the request whose turn it is, and start its budget."""
        if self._pending is not None or not self._waiting:
            return
        effect = self._pending = self._waiting.popleft()
        self._deadline = time.monotonic() + effect.budget_seconds
        try:
            self._worker.send(effect)
        except StudyError:
            self._respawn()
            self._worker.send(effect)

    def poll(self, seconds: float = 0.0) -> FitAnswer | None:
        """Return the answer, or say that the process died or ran over its budget."""
        if self._pending is None:
            return None
        pending = self._pending
        try:
            answer: Any = self._worker.poll(seconds)
        except StudyError as error:
            answer = FitAnswer(pending, reason=error.sentence)
            self._respawn()
        if answer is None and time.monotonic() > self._deadline:
            answer = FitAnswer(pending, timed_out=True)
            self._respawn()
        if isinstance(answer, WorkerFailure):
            answer = FitAnswer(pending, reason=answer.reason)
        if not isinstance(answer, FitAnswer):
            return None
        self._pending = None
        self._send_next()
        return answer

    def _respawn(self) -> None:
        self._worker.close()
        self._worker = Worker(serve_fits, self._description)

    def close(self) -> None:
        """End the process."""
        self._worker.close()


def serve_fits(description: TaskDescription) -> Callable[[Any], Any]:
    """Make the serving function of the fitting process; load torch before it is needed."""
    warm_up()
    return lambda request: fit(request, description)
