"""`study robot-keys`, `robot-stop` and `robot-release` as they are typed."""

from __future__ import annotations

import os
import time
from pathlib import Path

from command_line import study
from extras import need
from protocols import ROOT
from robot_agent import RunningAgent
from study.robots.client import Action, RobotAddress, RobotClient
from study.robots.keys import OPERATOR, read_pair
from twin_process import wait_until

need("zmq")

ENVIRONMENT = {"PYTHONPATH": f"{ROOT}:{os.environ.get('PYTHONPATH', '')}"}


def test_keys_stop_and_release(tmp_path: Path) -> None:
    """Keys are made; a robot that is driven is stopped from another terminal, and released."""
    keys = tmp_path / "keys"
    made = study("robot-keys", keys, "--robots", "1", environment=ENVIRONMENT)
    assert made.returncode == 0, made.stderr
    again = study("robot-keys", keys, environment=ENVIRONMENT)
    assert again.returncode == 2
    assert "holds keys already" in again.stderr
    agent = RunningAgent(keys)
    robots = tmp_path / "robots.toml"
    robots.write_text(
        f'operator_key = "keys/operator.toml"\n\n[[robots]]\nname = "robot1"\n'
        f'address = "{agent.address}"\npublic_key = "{agent.public_key}"\n\n'
        f'[poses]\nkind = "twin"\naddress = "{agent.address}"\npublic_key = "{agent.public_key}"\n'
    )
    client = RobotClient(
        RobotAddress("robot1", agent.address, agent.public_key),
        read_pair(keys / f"{OPERATOR}.toml"),
    )
    try:
        client.connect()
        client.send_action(Action(0.2, 0.0))
        wait_until(lambda: agent.motors.now == (0.2, 0.0))
        stopped = study("robot-stop", robots, environment=ENVIRONMENT)
        assert stopped.returncode == 0, stopped.stderr
        for _ in range(3):
            client.send_action(Action(0.2, 0.0))
            time.sleep(0.1)
        assert agent.motors.now == (0.0, 0.0)
        released = study("robot-release", robots, environment=ENVIRONMENT)
        assert released.returncode == 0, released.stderr
        client.send_action(Action(0.2, 0.0))
        wait_until(lambda: agent.motors.now == (0.2, 0.0))
    finally:
        client.disconnect()
        agent.close()
    gone = study("robot-stop", robots, environment=ENVIRONMENT)
    assert gone.returncode == 2
    assert "do not answer: robot1" in gone.stderr
