"""Episodes and demonstrations as Minari data sets, the format of Farama's offline data.

Two data sets: of whole episodes, one for each robot's way from its start to its end, and of
demonstrations alone, one for each run of consecutive timesteps in which the participant drove a
robot. Numbers are those of the recording: states and rewards float32, actions by number. Stored as
HDF5 and JSON (https://minari.farama.org/content/dataset_standards/); nothing is pickled.
"""

from __future__ import annotations

import dataclasses
import os
import shutil
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from analysis.files import make_folder
from analysis.recordings import Session, StudyRecordings, timestep_blocks
from study.errors import StudyError
from study.events.codes import ActionSource, Outcome, Phase
from study.events.inputs import FleetObserved
from study.events.task_description import TaskDescription

FOLDER = "minari"
NOBODY = -1
"""Who acts in an episode's last state, from which nothing is done."""
Array = npt.NDArray[Any]
_ENDED = (int(Outcome.GOAL), int(Outcome.LOST))


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Consecutive timesteps of one robot within one episode, T of them.

    Attributes:
        states: float32 [T + 1, d]; the last is that after the last action.
        actions: int64 [T].
        rewards: float32 [T].
        sources: int32 [T], codes.ActionSource.
        timesteps: int32 [T], numbers within the trial.
        times: int64 [T], session times of the steps, ns.
        outcome: codes.Outcome after the last step.
        trial_id, robot, episode: whose; robots and episodes count from 0 and 1.
    """

    states: npt.NDArray[np.float32]
    actions: npt.NDArray[np.int64]
    rewards: npt.NDArray[np.float32]
    sources: npt.NDArray[np.int32]
    timesteps: npt.NDArray[np.int32]
    times: npt.NDArray[np.int64]
    outcome: int
    trial_id: int
    robot: int
    episode: int

    def slice(self, first: int, last: int, outcomes: Array) -> Part:
        """Return the steps from ``first`` up to but not ``last``."""
        return dataclasses.replace(
            self,
            states=self.states[first : last + 1],
            actions=self.actions[first:last],
            rewards=self.rewards[first:last],
            sources=self.sources[first:last],
            timesteps=self.timesteps[first:last],
            times=self.times[first:last],
            outcome=int(outcomes[last - 1]),
        )


@dataclasses.dataclass(frozen=True, slots=True)
class Written:
    """What was written.

    Attributes:
        data_set: its id.
        episodes: how many.
        steps: in all of them.
    """

    data_set: str
    episodes: int
    steps: int


def export(study: StudyRecordings, folder: Path) -> tuple[Written, ...]:
    """Write both data sets under ``folder/minari``; what is there already is made anew.

    Load them with ``MINARI_DATASETS_PATH`` set to that folder.

    Args:
        study: the recordings.
        folder: of the export.

    Raises:
        StudyError: minari or h5py is missing, tasks differ, or the folder cannot be written.
    """
    require_minari()
    tasks = {session.opened.task_json for session in study.sessions}
    if len(tasks) > 1:
        raise StudyError(
            f"the recordings are of {len(tasks)} different tasks, or settings of one",
            "A Minari data set has one space of states and actions: export them one by one.",
        )
    # Minari takes a relative path for one below its own folder.
    folder = folder.absolute()
    made, target = folder / f".{FOLDER}.part", folder / FOLDER
    name = str(study.first.protocol.get("study", {}).get("name", "study"))
    make_folder(folder)
    try:
        shutil.rmtree(made, ignore_errors=True)
        with _private():
            written = tuple(
                _write(study, made, f"{name}/{kind}-v0", kind)
                for kind in ("episodes", "demonstrations")
            )
        shutil.rmtree(target, ignore_errors=True)
        made.rename(target)
    except OSError as error:
        raise StudyError(
            f"{target} cannot be written: {error.strerror or error}", "Choose another with -o."
        ) from error
    finally:
        shutil.rmtree(made, ignore_errors=True)
    return written


def episodes_of(session: Session) -> Iterator[tuple[Part, Array]]:
    """Yield each robot's episodes with the outcomes after each of their steps, int32 [T].

    In the order of trials, robots and time. An episode that the end of a trial, or a missing
    record, cuts short ends there.
    """
    after = _answers(session)
    for block in timestep_blocks(session):
        trials, robots = np.asarray(block["trial_id"]), np.asarray(block["actions"]).shape[1]
        cuts = np.flatnonzero(np.diff(trials)) + 1
        for rows in np.split(np.arange(len(trials)), cuts):
            known = np.array([(int(t), robots) in after for t in block["t_ns"][rows]])
            for robot in range(robots):
                yield from _of_robot(block, rows, known, robot, after)


def demonstrations_of(session: Session) -> Iterator[Part]:
    """Yield runs of consecutive timesteps of an episode in which the participant acted."""
    for part, outcomes in episodes_of(session):
        shown = np.concatenate([[False], part.sources == ActionSource.OPERATOR, [False]])
        edges = np.flatnonzero(np.diff(shown.astype(np.int8)))
        for first, last in zip(edges[::2], edges[1::2], strict=True):
            yield part.slice(int(first), int(last), outcomes)


def _answers(session: Session) -> dict[tuple[int, int], Array]:
    """Return the states after each step, [n, d], by its time and the fleet's size."""
    found: dict[tuple[int, int], Array] = {}
    for block in session.recording.columns(FleetObserved.topic):
        for t_ns, states in zip(block["t_ns"], np.asarray(block["states"]), strict=True):
            # In virtual time the next trial may start in the same moment, after the last step.
            found.setdefault((int(t_ns), states.shape[0]), states)
    return found


def _of_robot(
    block: dict[str, Array],
    rows: Array,
    known: Array,
    robot: int,
    after: dict[tuple[int, int], Array],
) -> Iterator[tuple[Part, Array]]:
    """Yield the episodes of one robot of a trial."""
    robots = block["actions"].shape[1]
    sources = block["action_sources"][rows, robot]
    outcomes = block["outcomes"][rows, robot]
    acts = (sources != ActionSource.INACTIVE) & known
    # A step goes on from the one before if that did not end the episode and none is missing.
    on = np.zeros(len(rows), np.bool_)
    on[1:] = (
        acts[1:]
        & acts[:-1]
        & (outcomes[:-1] == Outcome.RUNNING)
        & (np.diff(block["timestep"][rows]) == 1)
    )
    starts = np.flatnonzero(acts & ~on)
    for number, start in enumerate(starts, start=1):
        end = start + 1
        while end < len(rows) and on[end]:
            end += 1
        taken = rows[start:end]
        last = after[int(block["t_ns"][taken[-1]]), robots][robot]
        states = np.concatenate([block["states"][taken, robot], last[None]]).astype(np.float32)
        part = Part(
            states=states,
            actions=block["actions"][taken, robot].astype(np.int64),
            rewards=block["rewards"][taken, robot].astype(np.float32),
            sources=block["action_sources"][taken, robot].astype(np.int32),
            timesteps=block["timestep"][taken].astype(np.int32),
            times=block["t_ns"][taken].astype(np.int64),
            outcome=int(outcomes[end - 1]),
            trial_id=int(block["trial_id"][taken[0]]),
            robot=robot,
            episode=number,
        )
        yield part, outcomes[start:end]


def require_minari() -> None:
    """Raise a StudyError that says what to install, if something is missing."""
    try:
        import h5py  # noqa: F401, PLC0415 - an extra
        import minari  # noqa: F401, PLC0415 - an extra
    except ImportError as error:
        raise StudyError(
            f"Minari data sets need the packages minari and h5py: {error}",
            'Install the extra "minari": pip install "scaled-autonomy[minari]", in a clone '
            "pip install -e '.[minari]'.",
        ) from error


@contextmanager
def _private() -> Iterator[None]:
    """Make what others' code writes meanwhile readable by its owner alone."""
    before = os.umask(0o077)
    try:
        yield
    finally:
        os.umask(before)


def _write(study: StudyRecordings, root: Path, data_set: str, kind: str) -> Written:
    from minari.dataset.minari_storage import MinariStorage  # noqa: PLC0415 - an extra

    place = root / data_set / "data"
    place.mkdir(parents=True)
    task = study.first.task
    with warnings.catch_warnings():
        # It advises to name authors and a permalink: that is for whoever publishes.
        warnings.simplefilter("ignore")
        storage: Any = MinariStorage.new(
            place, observation_space=_states_space(task), action_space=_actions_space(task)
        )
        storage.update_metadata(_about(study, data_set, kind))
        notes: list[dict[str, Any]] = []
        storage.update_episodes(_buffers(study, kind, notes))
        storage.update_episode_metadata(notes)
    return Written(data_set, storage.total_episodes, storage.total_steps)


def _buffers(study: StudyRecordings, kind: str, notes: list[dict[str, Any]]) -> Iterator[Any]:
    """Yield episodes as Minari takes them; note beside them whose they are."""
    from minari.data_collector.episode_buffer import EpisodeBuffer  # noqa: PLC0415 - an extra

    for session in study.sessions:
        parts = (
            (part for part, _ in episodes_of(session))
            if kind == "episodes"
            else demonstrations_of(session)
        )
        for part in parts:
            notes.append(_note(session, part))
            steps = len(part.actions)
            last = np.arange(steps) == steps - 1
            ended = part.outcome in _ENDED
            yield EpisodeBuffer(
                observations=part.states,  # type: ignore[arg-type, unused-ignore]
                actions=part.actions,  # type: ignore[arg-type, unused-ignore]
                rewards=part.rewards,  # type: ignore[arg-type, unused-ignore]
                terminations=last & ended,
                truncations=last & (not ended),
                infos={
                    # Beside each observation, who acts from it; there is one more than actions.
                    "action_source": np.append(part.sources, np.int32(NOBODY)),
                    "timestep": np.append(part.timesteps, np.int32(part.timesteps[-1] + 1)),
                    "t_ns": np.append(part.times, np.int64(NOBODY)),
                },
            )


def _note(session: Session, part: Part) -> dict[str, Any]:
    """Return whose an episode is, and where in the study."""
    trial = session.trials[part.trial_id]
    return {
        "participant": session.opened.participant,
        "session_id": session.opened.session_id,
        "phase": int(trial.phase),
        "block": int(trial.block),
        "condition": trial.condition,
        "allocation": trial.allocation,
        "trial": int(trial.trial),
        "trial_id": part.trial_id,
        "scored": bool(trial.scored),
        "policy_id": trial.policy_id,
        "robot": part.robot + 1,
        "episode": part.episode,
        "outcome": Outcome(part.outcome).name.lower(),
    }


def _about(study: StudyRecordings, data_set: str, kind: str) -> dict[str, Any]:
    """Return what is said of a data set as a whole."""
    import minari  # noqa: PLC0415 - an extra

    first = study.first
    kinds = sorted({session.opened.operator_kind for session in study.sessions})
    what = {
        "episodes": "Every robot's episodes, whoever acted.",
        "demonstrations": "Runs of timesteps in which the participant drove a robot.",
    }[kind]
    title = first.protocol.get("study", {}).get("title", "")
    return {
        "dataset_id": data_set,
        "minari_version": minari.__version__,
        "description": f"{what} Study: {title} Operators: {', '.join(kinds)}.",
        "algorithm_name": "participants and what policies learned from them",
        "protocol_sha256": list(study.protocol_hashes),
        "task": first.task.name,
        "state_names": [field.name for field in first.task.state_fields],
        "state_units": [field.unit for field in first.task.state_fields],
        "action_names": list(first.task.action_names),
        "idle_action": first.task.idle_action,
        "action_sources": {source.name.lower(): int(source) for source in ActionSource},
        "phases": {phase.name.lower(): int(phase) for phase in Phase},
        "operator_kinds": kinds,
        "participants": [session.opened.participant for session in study.sessions],
        "recordings_sha256": {
            name: sha256 for session in study.sessions for name, sha256 in session.files
        },
    }


def _states_space(task: TaskDescription) -> Any:  # noqa: ANN401 - an extra
    from gymnasium.spaces import Box  # noqa: PLC0415 - an extra

    low = [field.low if field.bounded else -np.inf for field in task.state_fields]
    high = [field.high if field.bounded else np.inf for field in task.state_fields]
    return Box(np.array(low, np.float32), np.array(high, np.float32), dtype=np.float32)


def _actions_space(task: TaskDescription) -> Any:  # noqa: ANN401 - an extra
    from gymnasium.spaces import Discrete  # noqa: PLC0415 - an extra

    return Discrete(len(task.action_names))
