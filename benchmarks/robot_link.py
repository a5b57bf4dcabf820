"""How long a command takes to a robot over the link, and how fast the arena is simulated.

    python -m benchmarks.robot_link [--commands 100]

One robot's agent and body are the digital twin's, in a process of its own on this computer; the
link is the encrypted one of studies. Both processes read one clock. "Motors" is the time from
``send_action`` to the motors being told, "motion" that to the first pose in which the body has
moved by a tenth of a millimetre; poses come every 10 ms and the motors lag by 60 ms. "Echo" is
the same message over a bare ZeroMQ socket in one process, unencrypted: what there is at least.
Simulation speed is in seconds of arena a second of one core's time, without pictures.
"""

from __future__ import annotations

import argparse
import math
import queue
import statistics
import tempfile
import threading
import time
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from study.arena.course import TWO_BUCKETS
from study.arena.physics import ArenaPhysics, wheel_speeds
from study.robots.client import Action, RobotAddress, RobotClient
from study.robots.keys import OPERATOR, load_zmq, make_keys, read_pair
from study.robots.link import Command, decode, encode
from study.robots.poses import TwinPoses
from study.robots.twin import MOTION_CAPTURE, Twin, TwinSettings, robot_name

SPEED = 0.2
MOVED_M = 1e-4


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Latency of the robot link, speed of the arena.")
    parser.add_argument("--commands", type=int, default=100)
    commands = parser.parse_args().commands
    echo = echo_latencies(commands)
    with tempfile.TemporaryDirectory() as folder:
        motors, motion = link_latencies(Path(folder) / "keys", commands)
    print("command to           median      p99   (milliseconds)")
    for name, values in [("echo, bare socket", echo), ("motors", motors), ("motion", motion)]:
        median, p99 = statistics.median(values), float(np.quantile(values, 0.99))
        print(f"{name:18s} {1e3 * median:8.2f} {1e3 * p99:8.2f}")
    print()
    print("robots   simulated s a second of one core")
    for robots in (1, 3, 12):
        print(f"{robots:6d}   {simulation_speed(robots):8.1f}")


def echo_latencies(count: int) -> list[float]:
    """Return the times of one message one way over a bare socket, seconds."""
    zmq = load_zmq()
    with zmq.Context() as context:
        here, there = context.socket(zmq.PAIR), context.socket(zmq.PAIR)
        port = there.bind_to_random_port("tcp://127.0.0.1")
        here.connect(f"tcp://127.0.0.1:{port}")
        took = []
        for number in range(count):
            began = time.monotonic_ns()
            here.send_multipart(encode(Command(1, number, began, SPEED, 0.0)))
            decode(there.recv_multipart())
            took.append((time.monotonic_ns() - began) / 1e9)
        here.close()
        there.close()
    return took


def serve(keys: Path, pipe: Connection) -> None:
    """Run a twin of one robot until the pipe says so; answers when its motors were last told."""
    twin = Twin(TwinSettings(1, keys, noise=0.0, cameras=False))
    pipe.send(twin.describe())
    lines: queue.SimpleQueue[str] = queue.SimpleQueue()

    def wait() -> None:
        pipe.recv()
        lines.put("")

    threading.Thread(target=wait, daemon=True).start()
    twin.run(lines)
    twin.close()


def link_latencies(keys: Path, count: int) -> tuple[list[float], list[float]]:
    """Return the times from an action to the motors, and to the body's motion, seconds."""
    make_keys(keys, [OPERATOR, MOTION_CAPTURE, robot_name(0)])
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=serve, args=(keys, theirs))
    process.start()
    operator = read_pair(keys / f"{OPERATOR}.toml")
    try:
        where = ours.recv()
        client = RobotClient(RobotAddress(**where["robots"][0]), operator)
        client.connect(10.0)
        poses = TwinPoses(where["poses"]["address"], where["poses"]["public_key"], operator)
        poses.connect()
        while not poses.poses():
            time.sleep(0.01)
        motors, motion = [], []
        for number in range(count):
            action = Action(SPEED if number % 2 else -SPEED, 0.0)
            told, moved = one_command(client, poses, action)
            motors.append(told)
            motion.append(moved)
        client.disconnect()
        poses.close()
    finally:
        ours.send("quit")
        process.join(10)
        process.kill()
    return motors, motion


def one_command(client: RobotClient, poses: TwinPoses, action: Action) -> tuple[float, float]:
    """Drive a robot that stands; return seconds until its motors were told and it moved."""
    stand_still(client, poses)
    before = poses.poses()[0]
    began = time.monotonic()
    client.send_action(action)
    told = moved = math.nan
    while math.isnan(told) or math.isnan(moved):
        seen, pose = client.get_observation().status, poses.poses()[0]
        if math.isnan(told) and seen is not None and seen.linear == action.linear:
            # The agent's clock is ours: both processes are on this computer.
            told = (seen.at_ns - seen.command_age_ns) / 1e9 - began
        if math.isnan(moved) and math.dist((pose.x, pose.y), (before.x, before.y)) > MOVED_M:
            moved = pose.seen_at - began
        client.send_action(action)
        time.sleep(0.001)
    return told, moved


def stand_still(client: RobotClient, poses: TwinPoses) -> None:
    """Wait until the body has come to rest."""
    client.send_action(Action())
    still, last = 0, poses.poses()[0]
    while still < 10:
        time.sleep(0.015)
        pose = poses.poses()[0]
        still = still + 1 if math.dist((pose.x, pose.y), (last.x, last.y)) < 1e-6 else 0
        last = pose


def simulation_speed(robots: int) -> float:
    """Return simulated seconds a second of processor time."""
    physics = ArenaPhysics(TWO_BUCKETS, robots, motor_lag_s=0.06)
    start = TWO_BUCKETS.start
    for robot in range(robots):
        x = start.x + start.width * (robot % 4 + 0.5) / 4
        physics.put(robot, x, start.y + start.height * (robot // 4 + 0.5) / 3, 0.0)
        physics.set_wheels(robot, *wheel_speeds(0.25, 0.2))
    steps = round(20 / physics.step_s)
    began = time.process_time()
    physics.advance(steps, np.ones(robots, np.bool_))
    return 20 / (time.process_time() - began)


if __name__ == "__main__":
    main()
