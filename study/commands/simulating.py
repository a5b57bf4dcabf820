"""One simulated session, and a study of them on all cores."""

from __future__ import annotations

import dataclasses
import json
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

from joblib import Parallel, delayed

from study.commands.composing import (
    Assignment,
    clock_pair,
    picture_records,
    seed_from,
    session_opened,
    start_recorder,
)
from study.commands.deviations import FailedFits
from study.commands.recorded_scorers import recorded_weights
from study.families import load_member
from study.loading import LoadedProtocol, load_protocol
from study.orders import possible_orders
from study.seeding import stream_seed
from study.session.session import Session
from study.shell.conductor import Conductor, Watcher
from study.shell.fitting import InlineFitter
from study.shell.fleet import check_live, open_fleet
from study.shell.virtual_loop import VirtualClock, run_virtual
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import Driver, draw_parameters
from study.simulated.trained_user import TrainedUser

BATCH_BYTES = 1 << 16
"""A simulated session that is lost can be run again, so its records travel in batches."""


@dataclasses.dataclass(frozen=True, slots=True)
class Simulated:
    """What is left of a simulated session.

    Attributes:
        path: the finished recording.
        failed_fits: in words, each once.
    """

    path: Path
    failed_fits: frozenset[str]


def simulated_assignments(
    loaded: LoadedProtocol,
    participants: int,
    seed: int,
    driver: Driver = "planner",
    stated: Mapping[str, float] | None = None,
) -> list[Assignment]:
    """Return the assignments of a simulated study: orders in turn, so that they balance."""
    user = trained_user_of(loaded) if driver == "trained_user" else None
    names = [condition.name for condition in loaded.protocol.conditions]
    orders = possible_orders(names, loaded.protocol.phase_three.order)
    digits = max(2, len(str(participants)))
    return [
        Assignment(
            participant=f"S{index + 1:0{digits}d}",
            seed=stream_seed(seed, "session", index),
            order=orders[index % len(orders)],
            planned_index=index,
            operator_kind="simulated",
            operator_json=_operator_json(seed, index, driver, user, stated),
        )
        for index in range(participants)
    ]


def trained_user_of(loaded: LoadedProtocol) -> TrainedUser:
    """Return the synthetic user of a protocol's task.

    Raises:
        StudyError: none ships, or it was trained for other parameters.
    """
    task = loaded.protocol.task
    settings = load_member("study.tasks", "task", task.name).Parameters.model_validate(
        task.parameters
    )
    return TrainedUser.shipped(task.name, settings.model_dump(mode="json"))


def _operator_json(
    seed: int,
    index: int,
    driver: Driver,
    user: TrainedUser | None,
    stated: Mapping[str, float] | None,
) -> str:
    """Return what made a simulated operator: the study's seed and the parameters drawn from it."""
    drawn = draw_parameters(seed, index, driver, stated).model_dump(mode="json")
    made_of = {"study_seed": seed, **drawn}
    if user is not None:
        made_of["user_sha256"] = user.sha256
    return json.dumps(made_of)


def simulate_session(
    protocol: str,
    assignment: Assignment,
    study_seed: int,
    folder: Path,
    *,
    driver: Driver = "planner",
    stated: Mapping[str, float] | None = None,
    batch_bytes: int = BATCH_BYTES,
    watcher: Watcher | None = None,
) -> Path:
    """Run one simulated participant through the whole session.

    Args:
        protocol: path of the protocol file.
        assignment: who and how.
        study_seed: seed from which the operator's parameters were drawn.
        folder: where the recording goes.
        driver: who drives; the assignment says the same.
        stated: parameters that are not drawn; the assignment says the same.
        batch_bytes: bytes of records sent together; 0 sends each at once.
        watcher: sees all events.

    Returns:
        The finished recording.
    """
    loaded = load_protocol(protocol)
    opened = session_opened(loaded, assignment)
    recorder = start_recorder(folder, loaded, opened, batch_bytes=batch_bytes)
    epoch_ns = time.time_ns()
    fleet = open_fleet(loaded.protocol.task.name, loaded.protocol.task.parameters)
    fitter = InlineFitter(loaded.description, recorded_weights(loaded))
    clock = VirtualClock()
    try:
        conductor = Conductor(
            Session(),
            recorder,
            fleet,
            fitter,
            epoch_ns=epoch_ns,
            waits_for_disk=False,
            picture_records=picture_records(loaded, lambda: recorder.healthy),
        )
        if watcher is not None:
            conductor.watch(watcher)
        conductor.observe(clock_pair(0))
        conductor.feed(opened)
        operator = SimulatedOperator(
            draw_parameters(study_seed, assignment.planned_index, driver, stated),
            stream_seed(assignment.seed, "operator"),
            trained_user_of(loaded) if driver == "trained_user" else None,
        )
        run_virtual(conductor, operator, clock)
    finally:
        fleet.close()
        fitter.close()
        path = recorder.close()
    return path


def _simulated(
    protocol: str,
    assignment: Assignment,
    seed: int,
    folder: Path,
    driver: Driver,
    stated: Mapping[str, float] | None,
) -> Simulated:
    """Run one session of a study; called in a process of its own."""
    failed = FailedFits()
    path = simulate_session(
        protocol, assignment, seed, folder, driver=driver, stated=stated, watcher=failed
    )
    return Simulated(path, frozenset(failed.found))


def simulate_study(
    protocol: str,
    participants: int,
    seed: int,
    folder: Path,
    jobs: int,
    driver: Driver = "planner",
    stated: Mapping[str, float] | None = None,
) -> Iterator[Simulated]:
    """Simulate a study; yield each session as it is finished.

    Args:
        protocol: path of the protocol file.
        participants: how many.
        seed: of the study; everything is keyed from it.
        folder: where the recordings go.
        jobs: processes at once; -1 for all cores.
        driver: who drives.
        stated: parameters that all of them have; the others are drawn.
    """
    loaded = load_protocol(protocol)
    # Before a recording begins that could hold nothing.
    check_live(loaded.protocol.task.name, loaded.protocol.task.parameters)
    tasks = (
        delayed(_simulated)(protocol, assignment, seed, folder, driver, stated)
        for assignment in simulated_assignments(loaded, participants, seed, driver, stated)
    )
    yield from Parallel(n_jobs=jobs, return_as="generator_unordered", batch_size=1)(tasks)


def default_seed(loaded: LoadedProtocol) -> int:
    """Return the seed used when none is given: the same for the same protocol file."""
    return seed_from(f"simulate {loaded.sha256}") % 1_000_000
