"""Fitting scorers anew to what a session's own were fitted to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from study.events.codes import Phase
from study.events.events import Timestep, TrialStarted
from study.families import load_member
from study.policies.base import Arrays
from study.scorers._threads import use_one_thread
from study.seeding import stream_seed
from study.training_sets import ChoiceSets, choice_sets
from study.whatif.sessions import AppliedFit, ChoiceSession

Array = npt.NDArray[Any]


class LazyChoices(Mapping[str, Array]):
    """The choices that a session's scorers were fitted to, read when first asked for.

    Attributes:
        used: whether they were asked for: a control that learns nothing never does.
    """

    _NAMES = ("states", "available", "chosen", "trials")

    def __init__(self, session: ChoiceSession) -> None:
        self._session = session
        self._arrays: dict[str, Array] = {}
        self.used = False

    def __getitem__(self, name: str) -> Array:
        """Return one of the arrays of `study.training_sets.ChoiceSets`."""
        self.used = True
        if not self._arrays:
            self._arrays = dict(training_choices(self._session).arrays())
        return self._arrays[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._NAMES)

    def __len__(self) -> int:
        return len(self._NAMES)


def training_choices(session: ChoiceSession) -> ChoiceSets:
    """Return the choices of phase two, and of a correction round, as the session fitted them."""
    part = session.protocol.get("phase_two", {})
    robots = int(part.get("robots", 4))
    round_ = session.protocol.get("correction_round")
    rows = list(_phase_two(session))
    width = len(session.task.state_fields)
    if not round_:
        return choice_sets(rows, robots, width)
    return choice_sets(rows, max(robots, int(round_["offered"])), width, of_larger=True)


def _phase_two(session: ChoiceSession) -> Iterator[Timestep]:
    phases: dict[int, int] = {}
    for _, record in session.source.records(TrialStarted.topic, Timestep.topic):
        if isinstance(record, TrialStarted):
            phases[record.trial_id] = record.phase
            if record.phase > Phase.TWO:
                return
        elif isinstance(record, Timestep) and phases.get(record.trial_id) == Phase.TWO:
            yield record


def parts_of_trials(trials: npt.NDArray[np.int32], parts: int) -> list[frozenset[int]]:
    """Return disjoint parts of the trials, each to be held out once: every so-many-th trial."""
    ids = sorted({int(trial) for trial in trials})
    count = min(parts, len(ids))
    return [frozenset(ids[part::count]) for part in range(count)]


def scorer_part(session: ChoiceSession, name: str) -> Mapping[str, Any]:
    """Return what the recorded protocol says of a scorer; empty if it does not name it."""
    part = session.protocol.get("scorers", {}).get(name, {})
    return part if isinstance(part, dict) and part.get("name") == name else {}


def refit(session: ChoiceSession, fit: AppliedFit, arrays: Arrays) -> bytes:
    """Fit a session's scorer anew, with its recorded parameters, to some of its choices.

    Returns:
        Its weights. Nothing is held out to measure the fit: whoever refits does that.
    """
    module = load_member("study.scorers", "scorer", fit.algorithm)
    use_one_thread()
    scorers = session.protocol.get("scorers", {})
    given = dict(scorers.get(fit.artefact_id.partition(":")[2], {}).get("parameters", {}))
    if "held_out_fraction" in module.Parameters.model_fields:
        given["held_out_fraction"] = 0.0
    seed = stream_seed(session.opened.seed, f"fit {fit.artefact_id}", 0)
    weights: bytes = module.fit(arrays, session.task, given, seed).weights
    return weights
