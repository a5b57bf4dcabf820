"""The link cut, slowed, lossy, reordered: the robot stops within the bound and comes back."""

from __future__ import annotations

import random
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from extras import need
from robot_agent import RunningAgent, running_agent
from study.errors import StudyError
from study.robots.client import Action, RobotAddress, RobotClient
from study.robots.keys import OPERATOR, make_keys, read_pair
from study.robots.link import STOP_BOUND_S, EmergencyStop, RobotState, Wrap, encode
from tcp_proxy import Cable
from twin_process import Worse, wait_until

need("zmq")

FORWARD = Action(0.2, 0.0)
STANDING = (0.0, 0.0)


@pytest.fixture
def agent(tmp_path: Path) -> Iterator[RunningAgent]:
    """A robot without a body."""
    with running_agent(tmp_path / "keys") as running:
        yield running


@pytest.fixture
def cable(agent: RunningAgent) -> Iterator[Cable]:
    """What is between it and the operator."""
    made = Cable(agent.address)
    yield made
    made.close()


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    """Where the agent's keys are."""
    return tmp_path / "keys"


class Operator:
    """Gives the same action at each timestep, in a thread."""

    def __init__(self, client: RobotClient, action: Action = FORWARD) -> None:
        self._client = client
        self.action = action
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._drive)
        self._thread.start()

    def _drive(self) -> None:
        while not self._ending.is_set():
            self._client.send_action(self.action)
            time.sleep(0.1)

    def stop(self) -> None:
        """Give no more actions."""
        self._ending.set()
        self._thread.join()


@pytest.fixture
def connect(
    agent: RunningAgent, keys: Path
) -> Iterator[Callable[..., tuple[RobotClient, Operator]]]:
    """Connect to the agent, and drive."""
    opened: list[tuple[RobotClient, Operator]] = []

    def make(address: str = "", wrap: Wrap | None = None) -> tuple[RobotClient, Operator]:
        where = RobotAddress("robot1", address or agent.address, agent.public_key)
        operator_keys = read_pair(keys / f"{OPERATOR}.toml")
        client = RobotClient(where, operator_keys, *([wrap] if wrap else []))
        client.connect()
        operator = Operator(client)
        opened.append((client, operator))
        wait_until(lambda: agent.motors.now == (0.2, 0.0))
        return client, operator

    yield make
    for client, operator in opened:
        operator.stop()
        client.disconnect()


def drives(agent: RunningAgent) -> Callable[[], bool]:
    """Say whether the robot drives."""
    return lambda: agent.motors.now != STANDING


def stands(agent: RunningAgent) -> Callable[[], bool]:
    """Say whether the robot stands."""
    return lambda: agent.motors.now == STANDING


def test_a_key_that_is_not_known_is_refused(agent: RunningAgent, tmp_path: Path) -> None:
    """Another operator's key opens nothing, at once and in words; nor does no key."""
    make_keys(tmp_path / "other", [OPERATOR])
    where = RobotAddress("robot1", agent.address, agent.public_key)
    client = RobotClient(where, read_pair(tmp_path / "other" / f"{OPERATOR}.toml"))
    with pytest.raises(StudyError, match="refused the key"):
        client.connect()
    assert agent.motors.now == STANDING
    zmq = pytest.importorskip("zmq")
    with zmq.Context() as context, context.socket(zmq.DEALER) as socket:
        socket.setsockopt(zmq.LINGER, 0)
        socket.connect(agent.address)
        socket.send_multipart(encode(EmergencyStop(1)))
        assert not socket.poll(500)


def test_an_impostor_is_not_talked_to(agent: RunningAgent, keys: Path, tmp_path: Path) -> None:
    """A robot that does not hold its key hears nothing."""
    make_keys(tmp_path / "other", ["robot1"])
    where = RobotAddress("robot1", agent.address, read_pair(tmp_path / "other/robot1.toml").public)
    with pytest.raises(StudyError, match=r"refused the key|did not answer"):
        RobotClient(where, read_pair(keys / f"{OPERATOR}.toml")).connect(1.0)


def test_a_second_operator_waits(
    agent: RunningAgent, keys: Path, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """While one drives, another is told so and moves nothing."""
    connect()
    where = RobotAddress("robot1", agent.address, agent.public_key)
    with pytest.raises(StudyError, match="obeys another operator"):
        RobotClient(where, read_pair(keys / f"{OPERATOR}.toml")).connect(0.5)


def test_held_cable(
    agent: RunningAgent, cable: Cable, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """Nothing passes: it stops within the bound, does not jump at what was held up, goes on."""
    connect(cable.address)
    time.sleep(0.3)
    cable.held.set()
    began = time.monotonic()
    wait_until(stands(agent))
    assert agent.motors.since - began < STOP_BOUND_S
    time.sleep(0.8)
    before = len(agent.motors.notes)
    cable.held.clear()
    wait_until(drives(agent))
    time.sleep(0.5)
    assert agent.motors.now == (0.2, 0.0)
    assert len(agent.motors.notes) <= before + 2


def test_severed_cable(
    agent: RunningAgent, cable: Cable, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """A connection that breaks stops it within the bound; the client comes back by itself."""
    client, _ = connect(cable.address)
    began = time.monotonic()
    cable.held.set()
    cable.sever()
    wait_until(stands(agent))
    assert agent.motors.since - began < STOP_BOUND_S
    cable.held.clear()
    wait_until(drives(agent), 8.0)
    assert client.get_observation().status_age < 1.0


def test_delayed_cable(
    agent: RunningAgent, cable: Cable, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """A way that becomes much longer stops the robot; the operator sees how long it is."""
    client, _ = connect(cable.address)
    wait_until(lambda: client.get_observation().round_trip < 0.1)
    cable.delay_s = 0.4
    wait_until(stands(agent), 3.0)
    time.sleep(0.6)
    assert agent.motors.now == STANDING
    assert client.get_observation().status is not None
    cable.delay_s = 0.0
    wait_until(drives(agent), 5.0)


def test_dropped_and_reordered_commands(
    agent: RunningAgent, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """A third lost and the rest shuffled: it drives on, and old commands are ignored."""
    worse: list[Worse] = []

    def wrap(transport: object) -> Worse:
        worse.append(Worse(transport))  # type: ignore[arg-type]
        return worse[-1]

    client, operator = connect(wrap=wrap)
    chance = random.Random(1)
    kept: list[list[bytes]] = []

    def shuffle(sent: list[list[bytes]]) -> list[list[bytes]]:
        kept.extend(parts for parts in sent if chance.random() > 0.33)
        if len(kept) < 3:
            return []
        out = kept[:]
        chance.shuffle(out)
        kept.clear()
        return out

    worse[0].change = shuffle
    time.sleep(1.0)
    status = client.get_observation().status
    assert status is not None
    assert status.ignored > 3
    operator.action = Action(-0.1, 0.0)
    wait_until(lambda: agent.motors.now == (-0.1, 0.0))
    time.sleep(0.3)
    assert agent.motors.now in {(-0.1, 0.0), STANDING}
    worse[0].change = lambda _: []
    began = time.monotonic()
    wait_until(stands(agent))
    assert agent.motors.since - began < STOP_BOUND_S


def test_a_program_that_hangs_stops_its_robot(
    agent: RunningAgent, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """Without actions the robot stands, though its link lives."""
    client, operator = connect()
    operator.stop()
    began = time.monotonic()
    wait_until(stands(agent))
    assert agent.motors.since - began < STOP_BOUND_S
    time.sleep(0.2)
    status = client.get_observation().status
    assert status is not None
    assert status.state == RobotState.OBEYING


def test_speed_limits(
    agent: RunningAgent, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """The robot's own limits hold, and the operator is told what is sent."""
    client, operator = connect()
    operator.action = Action(9.0, -9.0)
    wait_until(lambda: agent.motors.now == (0.3, -2.0))
    assert client.send_action(Action(9.0, -9.0)) == Action(0.3, -2.0)


def test_emergency_stop_and_release(
    agent: RunningAgent, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """It stops at once, stays stopped under commands, and drives again when released."""
    client, _ = connect()
    began = time.monotonic()
    client.emergency_stop()
    wait_until(stands(agent))
    assert agent.motors.since - began < 0.1
    time.sleep(0.5)
    assert agent.motors.now == STANDING
    client.release()
    wait_until(drives(agent))


def test_leaving_stops_it(
    agent: RunningAgent, connect: Callable[..., tuple[RobotClient, Operator]]
) -> None:
    """An operator who disconnects leaves a robot that stands and is free."""
    client, operator = connect()
    operator.stop()
    client.send_action(FORWARD)
    client.disconnect()
    wait_until(stands(agent))
    client.connect()
    assert client.is_connected
