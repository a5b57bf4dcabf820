"""Finds the pictures of a replay: in the recording, or a task is stepped again to where it is.

The task is stepped in a process of its own, as at the session. What it shows is only shown if its
states are those that were recorded: on another machine, or with another version of what the task is
made of, they may differ, and a wrong picture would be worse than none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.families import load_member
from study.protocol import parse_protocol
from study.shell.drawing.pictures import Pictures
from study.shell.replay.film import Episode, Film
from study.shell.replay.recorded_pictures import RecordedPictures
from study.shell.workers import Worker, WorkerFailure
from study.tasks.base import PicturedTask

PATIENCE_S = 20.0
"""How long is waited for pictures; the first time the task has to be loaded."""
TOLERANCE = 1e-4
"""Difference of a state, as part of its size or of 1, up to which it counts as the same."""

Request = tuple[tuple[tuple[int, tuple[int, ...]], ...], npt.NDArray[np.float32]]


class Camera:
    """Shows a film as pictures. Its process begins with the first that is not in the recording.

    Args:
        recorded: the pictures that the recording holds; None for none.

    Attributes:
        unusable: why pictures cannot be taken again here, in words; empty as long as they can.
    """

    def __init__(self, recorded: RecordedPictures | None = None) -> None:
        self._recorded = recorded
        self._worker: Worker | None = None
        self._shown: tuple[int, Pictures] | None = None
        self.unusable = ""

    def show(self, film: Film, pictures: Pictures) -> None:
        """Bring pictures to where a film is: those of robots that cannot be shown are missing."""
        if (film.number, pictures) == self._shown:
            return
        self._shown = (film.number, pictures)
        found = self._recorded.at(film.t_ns, len(film.episodes)) if self._recorded else None
        if found is None and not self.unusable and film.episodes:
            found = self._found(film)
        pictures.take(found if found is not None else [None] * len(film.episodes))

    def _found(self, film: Film) -> list[npt.NDArray[np.uint8] | None] | None:
        request: Request = (
            tuple((episode.seed, episode.actions) for episode in film.episodes),
            film.states,
        )
        try:
            if self._worker is None:
                task = parse_protocol(film.protocol_toml, "the recorded protocol").task
                _refuse_modules(task.name)
                self._worker = Worker(serve_pictures, task.name, task.parameters)
            self._worker.send(request)
            answer = self._worker.poll(PATIENCE_S)
            if isinstance(answer, list):
                return answer
            late = f"no answer for {PATIENCE_S:g} s"
            self.unusable = answer.reason if isinstance(answer, WorkerFailure) else late
        except StudyError as error:
            self.unusable = str(error)
        # It cannot be drawn here, and will not be the next time.
        self.close()
        return None

    def close(self) -> None:
        """End the process."""
        if self._worker is not None:
            self._worker.close()
            self._worker = None


def _refuse_modules(task: str) -> None:
    """Refuse a task whose name has a module imported: no recording may do so."""
    if ":" in task.partition(":")[2]:
        raise StudyError(f'the recorded task "{task}" would import a module')


def serve_pictures(task: str, parameters: dict[str, object]) -> Callable[[Any], Any]:
    """Make the serving function of the camera's process."""
    stage = Stage(task, parameters)

    def serve(request: Request) -> list[npt.NDArray[np.uint8] | None]:
        episodes, states = request
        return stage.pictures([Episode(*episode) for episode in episodes], states)

    return serve


class Stage:
    """A fleet that is brought to wherever a film is.

    Args:
        task: its name.
        parameters: its parameters.

    Raises:
        StudyError: there is no such task, or it takes no pictures, or never the same twice.
    """

    def __init__(self, task: str, parameters: Mapping[str, object]) -> None:
        self._module = load_member("study.tasks", "task", task)
        self._parameters = dict(parameters)
        if self._module.describe(self._parameters).resimulable == "no":
            raise StudyError(f'the task "{task}" gives other states when stepped again')
        self._tasks: dict[int, PicturedTask] = {}
        self._at: dict[int, list[Episode | None]] = {}

    def pictures(
        self, episodes: list[Episode], states: npt.NDArray[np.float32]
    ) -> list[npt.NDArray[np.uint8] | None]:
        """Return a picture of each robot at the end of its episode so far.

        Args:
            episodes: one a robot, n.
            states: that these led to when they were recorded, float32 [n, d].

        Returns:
            uint8 [height, width, 3] a robot; None where the states are others.
        """
        now = self._bring(episodes)
        close = np.abs(now - states) <= TOLERANCE * np.maximum(1.0, np.abs(states))
        taken = self._tasks[len(episodes)].pictures()
        return [
            picture if same else None
            for picture, same in zip(taken, close.all(axis=1), strict=True)
        ]

    def _bring(self, episodes: list[Episode]) -> npt.NDArray[np.float32]:
        """Step every robot to the end of its episode; begin anew where it lies behind."""
        robots = len(episodes)
        if robots not in self._tasks:
            self._tasks[robots] = self._module.create(robots, self._parameters)
            self._at[robots] = [None] * robots
        task, at = self._tasks[robots], self._at[robots]
        anew = np.array([not _continues(*pair) for pair in zip(at, episodes, strict=True)])
        seeds = np.array([episode.seed for episode in episodes], np.uint64)
        now = task.reset(anew, seeds)
        done = [
            0 if new or was is None else len(was.actions) for new, was in zip(anew, at, strict=True)
        ]
        left = [len(e.actions) - k for e, k in zip(episodes, done, strict=True)]
        for step in range(max(left, default=0)):
            active = np.array([step < many for many in left])
            actions = np.array(
                [
                    e.actions[k + step] if acts else 0
                    for e, k, acts in zip(episodes, done, active, strict=True)
                ],
                np.int32,
            )
            now = task.step(actions, active).states
        self._at[robots] = list(episodes)
        return now


def _continues(before: Episode | None, now: Episode) -> bool:
    """Return whether one episode goes on from another."""
    return (
        before is not None
        and before.seed == now.seed
        and now.actions[: len(before.actions)] == before.actions
    )
