"""The operator's choices in a recording, as arrays, and the fits that took effect in it."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from study.events.codes import ChoiceFlag, ChoiceSource
from study.events.events import FitApplied, FitRequested, TrialStarted
from study.events.fields import Record
from study.events.inputs import FitCompleted, SessionOpened
from study.events.task_description import TaskDescription
from study.toml_text import parse_toml


class Source(Protocol):
    """Where records come from: a recording, or all parts of one."""

    def records(self, *topics: str) -> Iterator[tuple[int, Record]]:
        """Yield (sequence, record) of these topics in order."""
        ...

    def columns(self, topic: str) -> list[dict[str, npt.NDArray[Any]]]:
        """Return a topic's records as arrays."""
        ...


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class AppliedFit:
    """A fit that took effect.

    Attributes:
        artefact_id: "scorer:luce", "policy:1", ...
        kind: "scorer" or "policy".
        algorithm: name of the member.
        weights: safetensors.
        sha256: of the weights, hexadecimal.
        requested_ns: session time at which its data were complete.
        data_sha256: of the data that it was fitted to.
    """

    artefact_id: str
    kind: str
    algorithm: str
    weights: bytes
    sha256: str
    requested_ns: int
    data_sha256: str


@dataclasses.dataclass(frozen=True, eq=False)
class FleetRun:
    """One fleet run in which the operator chose.

    Attributes:
        started: how it began.
        states: float32 [T, n, d], before each timestep.
        available: bool [T, n].
        chosen: int64 [m], which robot was chosen at each choice.
        rows: int64 [m], at which of the T timesteps.
        timesteps: int64 [m], number of that timestep within the run.
        t_ns: int64 [m], session time of it.
        seconds: float64 [m], since the run's first timestep.
    """

    started: TrialStarted
    states: npt.NDArray[np.float32]
    available: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.int64]
    rows: npt.NDArray[np.int64]
    timesteps: npt.NDArray[np.int64]
    t_ns: npt.NDArray[np.int64]
    seconds: npt.NDArray[np.float64]

    @property
    def trial_id(self) -> int:
        """Number of the fleet run in the session, from 0."""
        return self.started.trial_id

    @cached_property
    def offered(self) -> npt.NDArray[np.bool_]:
        """Which robots could be chosen at each choice, bool [m, n]."""
        return self.available[self.rows]

    @cached_property
    def counts(self) -> npt.NDArray[np.int64]:
        """How many robots could be chosen at each choice, int64 [m]."""
        counts: npt.NDArray[np.int64] = self.offered.sum(axis=1)
        return counts


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class ChoiceSession:
    """One session with all that what-if needs of it.

    Attributes:
        opened: its first input.
        source: its records.
        files: name and SHA-256 of each of its files.
        protocol: as recorded, parsed.
        task: what the task said of itself.
        fits: those that took effect, in order.
        runs: fleet runs with at least one choice, in order.
        fitted_ns: until when its own scorers saw choices; -1 if none was fitted.
    """

    opened: SessionOpened
    source: Source
    files: tuple[tuple[str, str], ...]
    protocol: Mapping[str, Any]
    task: TaskDescription
    fits: tuple[AppliedFit, ...]
    runs: tuple[FleetRun, ...]
    fitted_ns: int

    @property
    def participant(self) -> str:
        """Pseudonymous id."""
        return self.opened.participant

    def fitted(self, run: FleetRun) -> npt.NDArray[np.bool_]:
        """Return which choices of a run were made before the own scorers were fitted, [m]."""
        return run.t_ns <= self.fitted_ns

    def fit(self, artefact_id: str) -> AppliedFit | None:
        """Return the last fit of that name that took effect."""
        return next((fit for fit in self.fits[::-1] if fit.artefact_id == artefact_id), None)


def open_choices(
    opened: SessionOpened,
    source: Source,
    files: tuple[tuple[str, str], ...],
    started: Mapping[int, TrialStarted],
) -> ChoiceSession:
    """Gather a session's choices: the operator's own, among two or more available robots.

    Left out, as from fits: choices of a scorer, accepted suggestions, what came before the first
    selection or while cycling. Practice is left out too.

    Args:
        opened: the session's first input.
        source: its records.
        files: name and SHA-256 of each file.
        started: how each fleet run began, by trial id.
    """
    fits = tuple(applied_fits(source))
    own = [fit.requested_ns for fit in fits if fit.kind == "scorer"]
    return ChoiceSession(
        opened=opened,
        source=source,
        files=files,
        protocol=parse_toml(opened.protocol_toml, "the recorded protocol"),
        task=TaskDescription.from_json(opened.task_json),
        fits=fits,
        runs=tuple(_runs(source, started)),
        fitted_ns=max(own, default=-1),
    )


def applied_fits(source: Source) -> Iterator[AppliedFit]:
    """Yield the fits of a recording that took effect, in order."""
    requested: dict[int, FitRequested] = {}
    completed: dict[int, FitCompleted] = {}
    for _, record in source.records(FitRequested.topic, FitCompleted.topic, FitApplied.topic):
        if isinstance(record, FitRequested):
            requested[record.request_id] = record
        elif isinstance(record, FitCompleted):
            completed[record.request_id] = record
        elif isinstance(record, FitApplied):
            asked, done = requested.get(record.request_id), completed.get(record.request_id)
            if asked is None or done is None:
                continue
            sha256 = hashlib.sha256(done.weights).hexdigest()
            if sha256 == record.weights_sha256:
                yield AppliedFit(
                    artefact_id=record.artefact_id,
                    kind=record.kind,
                    algorithm=asked.algorithm,
                    weights=done.weights,
                    sha256=sha256,
                    requested_ns=asked.t_ns,
                    data_sha256=asked.data_sha256,
                )


def _runs(source: Source, started: Mapping[int, TrialStarted]) -> Iterator[FleetRun]:
    found: dict[int, list[dict[str, npt.NDArray[Any]]]] = {}
    for block in source.columns("event/timestep"):
        ids = block["trial_id"].astype(np.int64)
        if not ids.size or block["states"].shape[1] < 2:
            continue
        for trial_id in np.unique(ids):
            if int(trial_id) in started and started[int(trial_id)].phase > 0:
                mask = ids == trial_id
                found.setdefault(int(trial_id), []).append(
                    {name: block[name][mask] for name in _NEEDED}
                )
    for trial_id in sorted(found):
        run = _run(started[trial_id], found[trial_id])
        if len(run.chosen):
            yield run


_NEEDED = (
    "timestep",
    "t_ns",
    "states",
    "available",
    "operated",
    "choice_source",
    "choice_flag",
)


def _run(started: TrialStarted, pieces: list[dict[str, npt.NDArray[Any]]]) -> FleetRun:
    joined = {name: np.concatenate([piece[name] for piece in pieces]) for name in _NEEDED}
    order = np.argsort(joined["timestep"], kind="stable")
    joined = {name: values[order] for name, values in joined.items()}
    available = joined["available"].astype(np.bool_)
    operated = joined["operated"].astype(np.int64)
    t_ns = joined["t_ns"].astype(np.int64)
    mine = (
        (joined["choice_source"] == ChoiceSource.OPERATOR)
        & (joined["choice_flag"] == ChoiceFlag.USABLE)
        & (operated >= 0)
        & available[np.arange(len(operated)), np.maximum(operated, 0)]
        & (available.sum(axis=1) > 1)
    )
    rows = np.flatnonzero(mine)
    return FleetRun(
        started=started,
        states=joined["states"],
        available=available,
        chosen=operated[rows],
        rows=rows,
        timesteps=joined["timestep"][rows].astype(np.int64),
        t_ns=t_ns[rows],
        seconds=(t_ns[rows] - t_ns[0]) / 1e9,
    )
