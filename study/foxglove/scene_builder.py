"""Makes scene messages of a session's records, one by one, in their order."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from foxglove_schemas_protobuf.Log_pb2 import Log
from google.protobuf.message import Message

from study.errors import RecordingError
from study.events.events import (
    Deviation,
    Paused,
    Resumed,
    SessionEnded,
    StageEntered,
    Timestep,
    TrialEnded,
    TrialStarted,
)
from study.events.fields import Record
from study.events.inputs import SessionOpened
from study.events.task_description import TaskDescription
from study.foxglove.map_scene import map_scene
from study.foxglove.robot_scene import RobotScene, has_position, no_robots
from study.foxglove.schemas import (
    LOG_TOPIC,
    MAP_TOPIC,
    POSES_TOPIC,
    ROBOTS_TOPIC,
    TRANSFORMS_TOPIC,
)
from study.recording.wire import decode

DEFAULT_RATE_HZ = 5.0
"""Scene messages a second: large fleets make large messages."""

_LOGGED = (StageEntered, TrialStarted, TrialEnded, Paused, Resumed, Deviation, SessionEnded)
_USED = {kind.topic for kind in (SessionOpened, Timestep, *_LOGGED)}


@dataclasses.dataclass(frozen=True, slots=True)
class SceneMessage:
    """One message for Foxglove: its topic (see `study.foxglove.schemas`), time and bytes."""

    topic: str
    log_time_ns: int
    data: bytes


class SceneBuilder:
    """Turns records into scene messages; keeps the task and the fleet run under way.

    Args:
        rate_hz: at most so many pictures of the fleet a second, by log time.
    """

    def __init__(self, rate_hz: float = DEFAULT_RATE_HZ) -> None:
        self._period_ns = round(1e9 / rate_hz)
        self._task: TaskDescription | None = None
        self._fleet: RobotScene | None = None
        self._next_ns = 0
        self.without_scene = ""

    def take(self, topic: str, log_time_ns: int, data: bytes) -> Iterator[SceneMessage]:
        """Yield what one record adds to the scene.

        `without_scene` says afterwards, in words, if the task cannot be drawn.

        Args:
            topic: the record's topic; those that the scene does not need are passed over.
            log_time_ns: nanoseconds since 1970, UTC.
            data: the encoded record.

        Raises:
            RecordingError: the record cannot be decoded.
        """
        if topic not in _USED or (topic == Timestep.topic and not self._due(log_time_ns)):
            return
        record = decode(topic, data)
        for made_for, message in self._messages(record, log_time_ns):
            yield SceneMessage(made_for, log_time_ns, message.SerializeToString())

    def map_again(self, log_time_ns: int) -> Iterator[SceneMessage]:
        """Yield the map once more, for those who came later."""
        if self._task is not None:
            update = map_scene(self._task.scene, log_time_ns)
            yield SceneMessage(MAP_TOPIC, log_time_ns, update.SerializeToString())

    def _due(self, log_time_ns: int) -> bool:
        return self._fleet is not None and log_time_ns >= self._next_ns

    def _messages(self, record: Record, log_time_ns: int) -> Iterator[tuple[str, Message]]:
        if isinstance(record, SessionOpened):
            self._open(record)
            if self._task is not None:
                yield MAP_TOPIC, map_scene(self._task.scene, log_time_ns)
        elif isinstance(record, TrialStarted):
            yield from self._start(record, log_time_ns)
        elif isinstance(record, Timestep):
            yield from self._step(record, log_time_ns)
        elif isinstance(record, TrialEnded) and self._fleet is not None:
            self._fleet = None
            yield ROBOTS_TOPIC, no_robots(log_time_ns)
        if isinstance(record, _LOGGED):
            yield LOG_TOPIC, _log(record, log_time_ns)

    def _open(self, opened: SessionOpened) -> None:
        try:
            task = TaskDescription.from_json(opened.task_json)
        except RecordingError as error:
            self.without_scene = error.message
            return
        self._task = task
        if not has_position(task):
            self.without_scene = f"the task {task.name} does not say where a robot is"

    def _start(self, started: TrialStarted, log_time_ns: int) -> Iterator[tuple[str, Message]]:
        if self._task is None or not has_position(self._task):
            return
        self._fleet = RobotScene(self._task, started.robots)
        self._next_ns = log_time_ns + self._period_ns
        # A larger fleet may have been drawn before; what is drawn next replaces the rest.
        yield ROBOTS_TOPIC, no_robots(log_time_ns)
        nobody = np.zeros(started.robots, np.int32)
        yield from self._draw(log_time_ns, started.states, nobody, nobody, -1)

    def _step(self, step: Timestep, log_time_ns: int) -> Iterator[tuple[str, Message]]:
        # On a grid, so that the rate is kept on average; a gap is not made up for.
        self._next_ns += self._period_ns * (1 + (log_time_ns - self._next_ns) // self._period_ns)
        yield from self._draw(
            log_time_ns, step.states, step.outcomes, step.action_sources, step.operated
        )

    def _draw(
        self,
        log_time_ns: int,
        states: np.typing.NDArray[np.float32],
        outcomes: np.typing.NDArray[np.int32],
        action_sources: np.typing.NDArray[np.int32],
        operated: int,
    ) -> Iterator[tuple[str, Message]]:
        fleet = self._fleet
        if fleet is None or len(states) != fleet.robots:
            return
        yield ROBOTS_TOPIC, fleet.scene(log_time_ns, states, outcomes, action_sources, operated)
        yield POSES_TOPIC, fleet.poses(log_time_ns, states)
        if operated >= 0:
            yield TRANSFORMS_TOPIC, fleet.transforms(log_time_ns, states, operated)


def _log(record: Record, log_time_ns: int) -> Log:
    """Return a line that says what happened, for Foxglove's Log panel."""
    level = Log.WARNING if isinstance(record, Deviation) else Log.INFO
    line = Log(level=level, name="session", message=_words(record))
    line.timestamp.FromNanoseconds(log_time_ns)
    return line


def _words(record: Record) -> str:
    if isinstance(record, StageEntered):
        where = f", {record.condition}" if record.condition else ""
        return f"Stage {record.stage}: {record.kind} {record.name}{where}"
    if isinstance(record, TrialStarted):
        condition = f", {record.condition}" if record.condition else ""
        place = f"phase {record.phase}, block {record.block}, trial {record.trial}{condition}"
        return f"Fleet run {record.trial_id} begins: {place}, {record.robots} robots"
    if isinstance(record, TrialEnded):
        broken = "" if record.complete else ", broken off"
        what = f"{record.timesteps} timesteps{broken}: team reward {record.team_reward:.1f}"
        return f"Fleet run {record.trial_id} ends after {what}"
    if isinstance(record, Paused):
        return f"Paused: {record.reason}"
    if isinstance(record, Resumed):
        return f"Goes on after {record.paused_ns / 1e9:.1f} s"
    if isinstance(record, Deviation):
        return f"Deviation {record.code}: {record.text}"
    assert isinstance(record, SessionEnded)  # noqa: S101 - the last of those that are logged
    return f"Session ended: {record.reason}"
