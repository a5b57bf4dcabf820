"""The digital twin: robots of the simulation that speak to us exactly as real ones would.

Run as a process of its own. It serves one agent a robot and the poses that motion capture would
see, all on this computer. One line of JSON on standard output says where; lines of words on
standard input make faults, robots counted from 1:

    camera_frozen ROBOT on|off     the camera repeats its last picture
    camera_dead ROBOT on|off       the camera takes no pictures
    pose_lost ROBOT on|off         motion capture does not see the robot
    battery ROBOT LEVEL            0 (flat) to 1 (full)
    put ROBOT X Y HEADING          metres and radians
    quit
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import queue
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from study.arena.cameras import open_cameras
from study.arena.course import TWO_BUCKETS
from study.arena.physics import STEP_S, ArenaPhysics
from study.errors import StudyError
from study.robots.agent import Agent, Door
from study.robots.keys import OPERATOR, PUBLIC_FILE, load_zmq, read_pair, read_public
from study.robots.link import PoseReading, Poses, encode
from study.robots.robots_file import read_robots_file
from study.robots.simulated_robot import SimulatedCamera, SimulatedMotors
from study.robots.staged_faults import StagedFaults
from study.robots.watchdog import Watchdog
from study.whole_file import replace_text

MOTION_CAPTURE = "motion_capture"
POSE_PERIOD_S = 0.01
_LOOP_S = 0.002
_MOST_STEPS = 20
"""Physics steps between two looks at the network: the watchdogs come first."""


def robot_name(robot: int) -> str:
    """Return what robot number ``robot`` is called in key files."""
    return f"robot{robot + 1}"


@dataclasses.dataclass(frozen=True, slots=True)
class TwinSettings:
    """How a twin is made.

    Attributes:
        robots: number of robots, n.
        keys: folder with the private files of robots and motion capture, and the public keys.
        seed: of starts and noise.
        speed: simulated seconds a second; watchdogs and cameras go by the real clock.
        port: of the first robot, the next have the next, motion capture the last; 0 for free ones.
        noise: of a wheel's speed, part of it.
        motor_lag_s: time constant of the motors, seconds.
        cameras: whether there are any.
    """

    robots: int
    keys: Path
    seed: int = 0
    speed: float = 1.0
    port: int = 0
    noise: float = 0.03
    motor_lag_s: float = 0.06
    cameras: bool = True


class Twin:
    """Everything of the twin; for one thread.

    Args:
        settings: how it is made.

    Raises:
        StudyError: MuJoCo, pyzmq or a key file is missing, or a port is taken.
    """

    def __init__(self, settings: TwinSettings) -> None:
        self.settings = settings
        self._zmq = load_zmq()
        seeds = np.random.SeedSequence(settings.seed).spawn(settings.robots + 1)
        streams = [np.random.Generator(np.random.PCG64(seed)) for seed in seeds]
        self.physics = ArenaPhysics(TWO_BUCKETS, settings.robots, motor_lag_s=settings.motor_lag_s)
        for robot in range(settings.robots):
            self._put_at_start(robot)
        self._moving = np.ones(settings.robots, np.bool_)
        self.faults = StagedFaults(self.physics, settings.robots)
        self._cameras = open_cameras(self.physics)
        public = read_public(settings.keys / PUBLIC_FILE)
        if OPERATOR not in public:
            raise StudyError(f"{settings.keys / PUBLIC_FILE}: no key of the operator")
        operators = frozenset({public[OPERATOR]})
        self.agents: list[Agent] = []
        for robot in range(settings.robots):
            motors = SimulatedMotors(self.physics, robot, streams[robot], settings.noise)
            camera = SimulatedCamera(
                self._cameras, robot, streams[robot], self.faults.frozen, self.faults.dead
            )
            self.agents.append(
                Agent(
                    Watchdog(motors, lambda robot=robot: self.faults.batteries[robot]),  # type: ignore[misc]
                    camera if settings.cameras else None,
                    keys=read_pair(settings.keys / f"{robot_name(robot)}.toml"),
                    operators=operators,
                    address=self._address(robot),
                )
            )
        keys = read_pair(settings.keys / f"{MOTION_CAPTURE}.toml")
        self._context = self._zmq.Context()
        self._door = Door(self._context, operators)
        self._poses: Any = self._context.socket(self._zmq.PUB)
        self._poses.setsockopt(self._zmq.LINGER, 0)
        self._poses.setsockopt(self._zmq.SNDHWM, 20)
        self._poses.curve_server = True
        self._poses.curve_publickey = keys.public.encode()
        self._poses.curve_secretkey = keys.secret.encode()
        self._poses.bind(self._address(settings.robots))
        self._sequence = 0

    def _address(self, place: int) -> str:
        port = self.settings.port
        return f"tcp://127.0.0.1:{port + place if port else '*'}"

    def _put_at_start(self, robot: int) -> None:
        """Put a robot on its place behind the finish line: four in a row."""
        start = self.physics.course.start
        column, row = robot % 4, robot // 4
        x = start.x + start.width * (column + 0.5) / 4
        y = start.y + start.height * (row + 0.5) / 3
        self.physics.put(robot, x, y, start.heading)

    def describe(self) -> dict[str, Any]:
        """Return where everything is, as its first line says it."""
        public = read_public(self.settings.keys / PUBLIC_FILE)
        return {
            "robots": [
                {
                    "name": robot_name(robot),
                    "address": agent.address,
                    "public_key": public[robot_name(robot)],
                }
                for robot, agent in enumerate(self.agents)
            ],
            "poses": {
                "address": self._poses.last_endpoint.decode(),
                "public_key": public[MOTION_CAPTURE],
            },
        }

    def run(self, commands: queue.SimpleQueue[str]) -> None:
        """Serve until told to quit.

        Args:
            commands: lines as of standard input; an empty string is its end.
        """
        began, steps = time.monotonic(), 0
        next_poses = began
        while True:
            now = time.monotonic()
            due = int((now - began) * self.settings.speed / STEP_S) - steps
            if due > 0:
                self.physics.advance(min(due, _MOST_STEPS), self._moving)
                # What the machine does not manage is left out: the world then goes slower.
                steps += due
            for agent in self.agents:
                agent.step()
            if now >= next_poses:
                next_poses = max(next_poses + POSE_PERIOD_S, now)
                self._publish()
            while not commands.empty():
                line = commands.get()
                try:
                    if not line or not self.faults.command(line):
                        return
                except StudyError as error:
                    print(error, file=sys.stderr, flush=True)  # noqa: T201 - a program's answer
            time.sleep(_LOOP_S)

    def _publish(self) -> None:
        self._sequence += 1
        readings = tuple(
            PoseReading(robot, *map(float, pose))
            for robot, pose in enumerate(self.physics.poses())
            if robot not in self.faults.unseen
        )
        message = Poses(self._sequence, time.monotonic_ns(), readings)
        self._poses.send_multipart(encode(message))

    def close(self) -> None:
        """Stop all robots and leave the network."""
        for agent in self.agents:
            agent.close()
        self._poses.close()
        self._door.close()
        self._context.term()
        self._cameras.close()


def robots_file_text(twin: Twin) -> str:
    """Return the file by which a study finds the twin's robots; see `robots_file`."""
    operator = (twin.settings.keys / f"{OPERATOR}.toml").resolve()
    lines = [f"operator_key = {json.dumps(str(operator))}"]
    where = twin.describe()
    for robot in where["robots"]:
        lines += ["", "[[robots]]", *(f"{name} = {json.dumps(robot[name])}" for name in robot)]
    poses = where["poses"]
    lines += ["", "[poses]", 'kind = "twin"']
    lines += [f"{name} = {json.dumps(poses[name])}" for name in poses]
    return "\n".join(lines) + "\n"


def _leave_real_robots(path: Path) -> None:
    """Refuse to replace a file unless a twin wrote it: an emergency stop needs the real list."""
    if not path.exists():
        return
    try:
        ours = read_robots_file(path).poses.kind == "twin"
    except StudyError:
        ours = False
    if not ours:
        raise StudyError(
            f"{path}: there is such a file, and no twin wrote it",
            "Name another one: a list of real robots is not replaced.",
        )


def serve(settings: TwinSettings, robots_file: Path | None = None) -> None:
    """Run a twin on standard input and output until input ends.

    Args:
        settings: how it is made.
        robots_file: to be written once the robots can be reached; None for none.

    Raises:
        StudyError: it cannot be made, or the file cannot be written or lists real robots.
    """
    if robots_file is not None:
        _leave_real_robots(robots_file)
    twin = Twin(settings)
    try:
        if robots_file is not None:
            try:
                replace_text(robots_file, robots_file_text(twin))
            except OSError as error:
                raise StudyError(f"{robots_file}: cannot be written: {error.strerror}") from error
        print(json.dumps(twin.describe()), flush=True)  # noqa: T201 - whoever started it reads this
        commands: queue.SimpleQueue[str] = queue.SimpleQueue()

        def listen() -> None:
            for line in sys.stdin:
                commands.put(line)
            commands.put("")

        threading.Thread(target=listen, daemon=True).start()
        twin.run(commands)
    finally:
        twin.close()


def main() -> None:
    """Run as ``python -m study.robots.twin``."""
    parser = argparse.ArgumentParser(description="Serve simulated JetBots.")
    parser.add_argument("--robots", type=int, default=3)
    parser.add_argument("--keys", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", type=float, default=1.0)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--no-cameras", action="store_true")
    parser.add_argument("--write", type=Path)
    given = parser.parse_args()
    try:
        serve(
            TwinSettings(
                robots=given.robots,
                keys=given.keys,
                seed=given.seed,
                speed=given.speed,
                port=given.port,
                cameras=not given.no_cameras,
            ),
            given.write,
        )
    except StudyError as error:
        sys.exit(f"{error}")


if __name__ == "__main__":
    main()
