"""The program on a JetBot, with a library of ours in place of NVIDIA's."""

from __future__ import annotations

import sys
import threading
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import numpy.typing as npt
import pytest

from extras import need
from study.robots.client import Action, RobotAddress, RobotClient
from study.robots.keys import OPERATOR, PUBLIC_FILE, make_keys, read_pair
from study.robots.on_jetbot import ArrayCamera, WheelMotors, main
from twin_process import wait_until

need("zmq")


def test_wheels_get_powers() -> None:
    """Straight on both alike, on the spot opposite ones; too fast keeps the curve."""
    told: list[tuple[float, float]] = []
    motors = WheelMotors(lambda left, right: told.append((left, right)), full_speed=0.5)
    motors.set_velocity(0.25, 0.0)
    motors.set_velocity(0.0, 2.0)
    motors.set_velocity(1.0, 0.0)
    motors.set_velocity(0.0, 0.0)
    assert told[0] == (0.5, 0.5)
    assert told[1] == pytest.approx((-0.22, 0.22))
    assert told[2] == (1.0, 1.0)
    assert told[3] == (0.0, 0.0)


def test_pictures_are_turned_to_red_green_blue() -> None:
    """Each picture of the camera is sent once, no faster than 15 a second."""
    now, picture = [1.0], [np.array([[[1, 2, 3], [4, 5, 6]]], np.uint8)]
    camera = ArrayCamera(lambda: picture[0], lambda: now[0])
    first = camera.frame()
    assert first is not None
    assert (first.width, first.height, first.pixels) == (2, 1, bytes([3, 2, 1, 6, 5, 4]))
    now[0] = 2.0
    assert camera.frame() is None
    picture[0] = picture[0] + 1
    assert camera.frame() is not None
    picture[0] = picture[0] + 1
    assert camera.frame() is None


class ChangingCamera:
    """A new picture whenever one looks."""

    _looks = 0

    @property
    def value(self) -> npt.NDArray[np.uint8]:
        """The newest."""
        self._looks += 1
        return np.full((120, 160, 3), self._looks % 256, np.uint8)


def test_the_program_serves_an_operator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With the key of `study robot-keys` an operator drives the wheels, and leaves them at rest."""
    powers: list[tuple[float, float]] = []
    library = ModuleType("jetbot")
    robot = SimpleNamespace(set_motors=lambda left, right: powers.append((left, right)))
    camera = ChangingCamera()
    vars(library).update(
        Robot=lambda: robot, Camera=SimpleNamespace(instance=lambda width, height: camera)
    )
    monkeypatch.setitem(sys.modules, "jetbot", library)
    keys = tmp_path / "keys"
    make_keys(keys, [OPERATOR, "robot1"])
    ending = threading.Event()
    arguments = [str(keys / "robot1.toml"), "--operator", str(keys / PUBLIC_FILE), "--port", "0"]
    thread = threading.Thread(
        target=main, args=([*arguments, "--full-speed", "0.5"], lambda: not ending.is_set())
    )
    thread.start()
    said: list[str] = []

    def listening() -> bool:
        said.append(capsys.readouterr().out)
        return "Listening at" in "".join(said)

    try:
        wait_until(listening)
        where = "".join(said).split()[-1]
        address = RobotAddress("robot1", where, read_pair(keys / "robot1.toml").public)
        client = RobotClient(address, read_pair(keys / f"{OPERATOR}.toml"))
        client.connect()
        client.send_action(Action(0.25, 0.0))
        wait_until(lambda: (0.5, 0.5) in powers)
        wait_until(lambda: client.get_observation().frame is not None)
        client.disconnect()
        wait_until(lambda: powers[-1] == (0.0, 0.0))
    finally:
        ending.set()
        thread.join()
