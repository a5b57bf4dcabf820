"""All robots of a study and their supervisor: the same for simulated and real ones."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence

from study.errors import StudyError
from study.robots.client import Action, Observation, RobotClient
from study.robots.poses import Pose, PoseSource
from study.robots.safety import (
    REASON_TEXTS,
    USUAL_BOUNDS,
    Bounds,
    Guard,
    SafetyChange,
    StopReason,
    reasons_to_stop,
)

SUPERVISION_PERIOD_S = 0.02
_READY_S = 5.0


class RobotFleet:
    """n robots, where they are, and a thread that stops those that must not drive.

    The supervisor looks whether or not anybody drives, so that a fault is known in pauses too.

    Args:
        clients: one a robot, in the order of their numbers.
        poses: tells where they are.
        bounds: when something counts as lost.
        on_change: called from the supervisor's thread with each change, if given.
    """

    def __init__(
        self,
        clients: Sequence[RobotClient],
        poses: PoseSource,
        bounds: Bounds = USUAL_BOUNDS,
        on_change: Callable[[SafetyChange], None] | None = None,
    ) -> None:
        self.clients = list(clients)
        self._source = poses
        self._bounds = bounds
        self._on_change = on_change
        self._guards = [Guard(robot, bounds) for robot in range(len(self.clients))]
        self._lock = threading.Lock()
        self._poses: dict[int, Pose] = {}
        self._changes: list[SafetyChange] = []
        self._thread: threading.Thread | None = None
        self._failure: BaseException | None = None
        self._stopping = threading.Event()

    def connect(self, timeout_s: float = _READY_S) -> None:
        """Get hold of every robot, and wait until all is live: robots, cameras and poses.

        Raises:
            StudyError: something is not; the message says what of which robot.
        """
        try:
            for client in self.clients:
                client.connect(timeout_s)
            self._source.connect()
            self._stopping.clear()
            self._thread = threading.Thread(
                target=self._supervise, name="robots' supervisor", daemon=True
            )
            self._thread.start()
            deadline = time.monotonic() + timeout_s
            while problems := self.not_ready():
                if time.monotonic() > deadline:
                    raise StudyError(
                        f"not every robot is ready: {'; '.join(problems)}",
                        "A study begins when every robot, camera and pose is live.",
                    )
                time.sleep(0.05)
        except StudyError:
            self.disconnect()
            raise
        with self._lock:
            # What was not there while all came up is no fault of the study's.
            self._changes.clear()

    def not_ready(self) -> list[str]:
        """Return what keeps a study from beginning, one text a robot and reason."""
        if self._failure is not None:
            return [f"the supervisor has failed: {self._failure}"]
        now, poses = time.monotonic(), self.poses()
        problems = []
        for robot, client in enumerate(self.clients):
            found = reasons_to_stop(client.get_observation(), poses.get(robot), now, self._bounds)
            problems += [
                f"{client.robot.name}: {REASON_TEXTS[reason]}"
                for reason in sorted(found | self._guards[robot].reasons)
            ]
        return problems

    def get_observation(self) -> list[Observation]:
        """Return the newest of each robot, at once."""
        return [client.get_observation() for client in self.clients]

    def poses(self) -> dict[int, Pose]:
        """Return the newest pose of each robot that was ever seen."""
        with self._lock:
            return dict(self._poses)

    def reasons(self) -> list[frozenset[StopReason]]:
        """Return why each robot is held; empty for those that may drive."""
        with self._lock:
            return [guard.reasons for guard in self._guards]

    def take_changes(self) -> list[SafetyChange]:
        """Return what began or ended since the last call, for operator and recording."""
        with self._lock:
            changes, self._changes = self._changes, []
        return changes

    def send_action(self, actions: Mapping[int, Action]) -> dict[int, Action]:
        """Drive some robots; call it at each timestep.

        Returns:
            What was sent: a robot that is held stands.
        """
        return {robot: self.clients[robot].send_action(action) for robot, action in actions.items()}

    def emergency_stop(self) -> None:
        """Stop every robot at once; they stay stopped until `release`."""
        for client in self.clients:
            client.emergency_stop()

    def release(self) -> None:
        """End an emergency."""
        for client in self.clients:
            client.release()

    def disconnect(self) -> None:
        """Stop all robots and let them go. Calling it twice is harmless."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
            self._thread = None
            self._source.close()
        for client in self.clients:
            client.disconnect()

    def _supervise(self) -> None:
        try:
            while not self._stopping.is_set():
                self._look(time.monotonic())
                self._stopping.wait(SUPERVISION_PERIOD_S)
        # Whatever it is: unsupervised robots do not drive.
        except BaseException as error:
            self._failure = error
            for client in self.clients:
                client.halt()
                client.emergency_stop()

    def _look(self, now: float) -> None:
        poses = self._source.poses()
        changes: list[SafetyChange] = []
        with self._lock:
            self._poses = poses
            for robot, (client, guard) in enumerate(zip(self.clients, self._guards, strict=True)):
                found = reasons_to_stop(
                    client.get_observation(), poses.get(robot), now, self._bounds
                )
                seen = guard.look(found, now)
                if any(change.began for change in seen):
                    client.halt()
                elif seen and not guard.reasons:
                    client.resume()
                changes += seen
            self._changes += changes
        if self._on_change is not None:
            for change in changes:
                self._on_change(change)
