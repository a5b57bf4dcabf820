"""Effects: what the session asks the shell to do. The answers come back as inputs."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.screens import Screen


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class StartFleet:
    """Make a fleet, start every robot and say what policy and scorer think of the states.

    Answered by ``FleetObserved`` with zero rewards.

    Attributes:
        request_id: repeated in the answer.
        trial_id: number of the fleet run.
        robots: n.
        seeds: uint64 [n], one per robot: start state and motion noise of its first episode.
        policy_id: "uniform_random" or an artefact id that a fit returned.
        policy_seed: key of the policy's own random stream.
        scorer_id: an artefact id or the name of a scorer that needs no fit; empty for none.
    """

    request_id: int
    trial_id: int
    robots: int
    seeds: npt.NDArray[np.uint64]
    policy_id: str
    policy_seed: int
    scorer_id: str


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class StepFleet:
    """Step the robots in ``active`` and start those in ``reset`` anew; none is in both.

    Answered by ``FleetObserved``.

    Attributes:
        request_id: repeated in the answer.
        actions: int32 [n].
        active: bool [n]; robots to step.
        reset: bool [n]; robots to start anew. Their state in the answer is the start state,
            their reward 0 and their outcome RUNNING.
        seeds: uint64 [n]; used where ``reset``.
    """

    request_id: int
    actions: npt.NDArray[np.int32]
    active: npt.NDArray[np.bool_]
    reset: npt.NDArray[np.bool_]
    seeds: npt.NDArray[np.uint64]


@dataclasses.dataclass(frozen=True, slots=True)
class StopFleet:
    """The fleet run is over; the fleet may be put away."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class RequestFit:
    """Fit a policy or a scorer. Answered by FitCompleted, FitFailed or FitTimedOut.

    Attributes:
        request_id: repeated in the answer.
        artefact_id: name under which later effects refer to the result.
        kind: "policy" or "scorer".
        algorithm: file stem of the policy or scorer.
        parameters_json: its hyper-parameters, JSON object.
        arrays: training data. Policy: ``states`` float32 [m, d], ``actions`` int32 [m].
            Scorer: ``states`` float32 [m, n, d], ``available`` bool [m, n],
            ``chosen`` int32 [m], ``trials`` int32 [m] (to hold out whole trials).
        seed: seed of the fit.
        budget_seconds: when to give up.
        start: preparation of an earlier fit to go on from, if the algorithm can; empty for none.
        background: whether it only prepares a later fit: the answer takes effect nowhere, and
            the session goes on meanwhile.
    """

    request_id: int
    artefact_id: str
    kind: str
    algorithm: str
    parameters_json: str
    arrays: dict[str, npt.NDArray[np.generic]]
    seed: int
    budget_seconds: float
    start: bytes = b""
    background: bool = False


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Show:
    """Show this screen until the next one."""

    screen: Screen


@dataclasses.dataclass(frozen=True, slots=True)
class SetPace:
    """Say how fast timesteps come.

    Attributes:
        timesteps_per_second: the rate; 0 stops the clock.
        unhurried: false for phase four: as fast as the fleet answers.
    """

    timesteps_per_second: float
    unhurried: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class EnsureDurable:
    """Feed no further input and show no further screen until all records are on disk."""


@dataclasses.dataclass(frozen=True, slots=True)
class EraseRecording:
    """Once the session is over, remove its recording and leave a count of such sessions."""


@dataclasses.dataclass(frozen=True, slots=True)
class Finish:
    """The session is over."""


Effect = (
    StartFleet
    | StepFleet
    | StopFleet
    | RequestFit
    | Show
    | SetPace
    | EnsureDurable
    | EraseRecording
    | Finish
)
