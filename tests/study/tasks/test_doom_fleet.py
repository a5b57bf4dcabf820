"""A fleet of engines: what is asked of any task, and what happens when engines or processes die."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
import uuid
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from extras import need
from patience import PATIENCE_S
from study.errors import StudyError
from study.session.effects import StartFleet, StepFleet
from study.shell.fleet import ProcessFleet
from study.shell.fleet_host import FleetAnswer, FleetNews
from study.tasks import doom, navigation
from study.tasks._doom.arena import Arena
from study.tasks.base import PlaceableTask, SnapshotTask
from study.tasks.doom import DoomTask

ROBOTS = 4
EVERY = np.ones(ROBOTS, np.bool_)
SEEDS = np.arange(20, 20 + ROBOTS, dtype=np.uint64)
MEMORY = Path("/dev/shm")  # noqa: S108 - where engines keep theirs


def test_without_the_extra_a_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    """No traceback: the command, and what the engine's licence forbids."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(StudyError) as caught:
        doom.create(1, {})
    assert "scaled-autonomy[doom]" in str(caught.value)
    assert "commercial" in str(caught.value)


def _actions(timestep: int) -> npt.NDArray[np.int32]:
    return np.random.default_rng(timestep).integers(0, 5, ROBOTS).astype(np.int32)


def _step(task: DoomTask, timestep: int) -> list[bytes]:
    """Take a timestep; return all that can be seen of it."""
    step = task.step(_actions(timestep), EVERY)
    arrays = (step.states, step.rewards, step.outcomes, *map(task.frames, range(4)))
    return [np.ascontiguousarray(array).tobytes() for array in arrays]


def test_starts_are_those_of_navigation() -> None:
    """Equal seeds start equally, but for the engine's grid."""
    need("vizdoom")
    task, other = doom.create(ROBOTS, {}), navigation.create(ROBOTS, {})
    assert np.abs(task.reset(EVERY, SEEDS) - other.reset(EVERY, SEEDS)).max() < 2e-5
    task.close()


@pytest.mark.parametrize("motion", ["exact", "stock"])
def test_cloned_futures_are_identical(motion: str) -> None:
    """A snapshot put into another fleet leads to the same states, rewards and pictures."""
    need("vizdoom")
    first, second = (doom.create(ROBOTS, {"motion": motion}) for _ in range(2))
    assert isinstance(first, SnapshotTask)
    first.reset(EVERY, SEEDS)
    for timestep in range(15):
        _step(first, timestep)
    second.restore(first.snapshot())
    for timestep in range(15, 40):
        assert _step(first, timestep) == _step(second, timestep)
    first.close()
    second.close()


def test_a_state_is_all_that_the_future_depends_on() -> None:
    """Put by its state alone, a robot sees and does what it did before."""
    need("vizdoom")
    first, second = (doom.create(ROBOTS, {}) for _ in range(2))
    assert isinstance(first, PlaceableTask)
    first.reset(EVERY, SEEDS)
    for timestep in range(15):
        before = first.step(_actions(timestep), EVERY).states
    second.reset(EVERY, SEEDS)
    assert second.place(EVERY, before).tobytes() == before.tobytes()
    assert (second.frames() == first.frames()).all()
    assert _step(first, 15) == _step(second, 15)
    with pytest.raises(ValueError, match="could be running"):
        first.place(EVERY, np.full((ROBOTS, 4), 0.2, np.float32))
    first.close()
    second.close()


def test_stock_motion_coasts_and_exact_motion_stops() -> None:
    """The option changes what it says it changes."""
    need("vizdoom")
    for motion, coasts in (("exact", False), ("stock", True)):
        task = doom.create(1, {"motion": motion})
        one = np.ones(1, np.bool_)
        task.reset(one, SEEDS[:1])
        start = np.array([[1.0, 1.0, 0.0, 80.0]], np.float32)
        begun = task.place(one, start)[0, 0]
        driven = task.step(np.array([0], np.int32), one).states[0, 0]
        idle = task.step(np.array([4], np.int32), one).states[0, 0]
        assert (idle > driven + 0.01) == coasts
        assert (driven == np.float32(begun + 0.5)) == (not coasts)
        task.close()


def _descendants(pid: int) -> list[tuple[int, str]]:
    """Return (id, command) of all processes below one."""
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in map(int, task.read_text().split()):
            with contextlib.suppress(OSError):
                found.append((child, Path(f"/proc/{child}/cmdline").read_text()))
                found += _descendants(child)
    return found


@pytest.mark.parametrize("seed", range(3))
def test_killed_and_hung_engines_are_replaced_and_nothing_is_lost(seed: int) -> None:
    """Whatever is killed or stopped, in mid-step or between: the fleet goes on to the last bit."""
    need("vizdoom")
    calm, disturbed = (doom.create(ROBOTS, {"patience": 1.0}) for _ in range(2))
    calm.reset(EVERY, SEEDS)
    disturbed.reset(EVERY, SEEDS)
    random = np.random.default_rng(seed)
    disturbances = 0
    for timestep in range(24):
        disturber = threading.Timer(random.uniform(0, 0.004), lambda: None)
        if timestep % 6 == 3:
            worker = int(random.choice(disturbed.worker_pids()))
            engines = [pid for pid, command in _descendants(worker) if "map.wad" in command]
            victim = int(random.choice([worker, *engines]))
            how = random.choice([signal.SIGKILL, signal.SIGSTOP])
            disturber = threading.Timer(random.uniform(0, 0.004), os.kill, (victim, how))
            disturbances += 1
        disturber.start()
        after = _step(disturbed, timestep)
        disturber.join()
        assert after == _step(calm, timestep), timestep
    after = _step(disturbed, 24)
    assert after == _step(calm, 24)
    incidents = disturbed.incidents()
    assert len(incidents) == disturbances
    assert all(incident.reason and incident.robots for incident in incidents)
    assert disturbed.incidents() == calm.incidents() == []
    calm.close()
    disturbed.close()


def test_tiles_are_marked_while_an_engine_is_replaced() -> None:
    """A window sees through the shared memory who waits, and the last pictures of all."""
    need("vizdoom")
    task = doom.create(ROBOTS, {"patience": 0.5})
    task.reset(EVERY, SEEDS)
    window = Arena.open(task.arena_place())
    _step(task, 0)
    shown = window.shown().copy()
    assert shown.any(axis=(1, 2, 3)).all()
    os.kill(task.worker_pids()[0], signal.SIGSTOP)
    stepping = threading.Thread(target=_step, args=(task, 1))
    seen = []
    stepping.start()
    while stepping.is_alive():
        seen.append(window.frozen.tolist())
        if not window.turn[0]:
            break
        assert (window.shown() == shown).all()
        time.sleep(0.02)
    stepping.join()
    assert [1, 1, 0, 0] in seen
    assert window.frozen.tolist() == [0, 0, 0, 0]
    (incident,) = task.incidents()
    assert incident.robots == (0, 1)
    window.close()
    task.close()


_FLEET = """
import sys, time
import numpy as np
from study.tasks import doom
task = doom.create(4, {})
every = np.ones(4, np.bool_)
print("starting", flush=True)
task.reset(every, np.arange(4, dtype=np.uint64))
print("running", flush=True)
begun = time.monotonic()
while time.monotonic() - begun < float(sys.argv[2]):
    task.step(np.zeros(4, np.int32), every)
if sys.argv[1] == "close":
    task.close()
if sys.argv[1] == "raise":
    raise RuntimeError
"""


def _marked(mark: str) -> list[str]:
    """Return the commands of all processes that have a mark in their environment."""
    found = []
    for environment in Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if mark.encode() in environment.read_bytes():
                found.append((environment.parent / "cmdline").read_text())
    # Python's own helper of multiprocessing belongs to this process and stays with it.
    return [command for command in found if "resource_tracker" not in command]


def _assert_nothing_is_left(mark: str, memory: set[Path], scratch: Path) -> None:
    deadline = time.monotonic() + 30
    while left := [*_marked(mark), *({*MEMORY.glob("ViZDoom*")} - memory), *scratch.glob("doom_*")]:
        assert time.monotonic() < deadline, left
        time.sleep(0.1)


@pytest.mark.parametrize(
    ("ending", "after"),
    [
        ("close", 0.5),
        ("return", 0.5),
        ("raise", 0.5),
        *((how, after) for how in ("SIGKILL", "SIGTERM", "SIGINT") for after in (0.2, 0.6, 3.0)),
    ],
)
def test_however_it_ends_nothing_is_left(ending: str, after: float, tmp_path: Path) -> None:
    """No process, no shared memory and no folder, whether it starts or runs when it ends."""
    need("vizdoom")
    mark, memory = uuid.uuid4().hex, {*MEMORY.glob("ViZDoom*")}
    process = subprocess.Popen(
        [sys.executable, "-c", _FLEET, ending, "60" if ending.startswith("SIG") else str(after)],
        env={**os.environ, "DOOM_MARK": mark, "TMPDIR": str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "starting\n"
    if ending.startswith("SIG"):
        time.sleep(after)
        process.send_signal(getattr(signal, ending))
    process.wait(PATIENCE_S)
    process.stdout.close()
    _assert_nothing_is_left(mark, memory, tmp_path)


def test_in_a_fleets_own_process_it_steps_and_ends_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As sessions use it; when that process is killed its engines end too."""
    need("vizdoom")
    mark, memory = uuid.uuid4().hex, {*MEMORY.glob("ViZDoom*")}
    monkeypatch.setenv("DOOM_MARK", mark)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    fleet = ProcessFleet("doom", {})
    fleet.request(
        StartFleet(
            request_id=1,
            trial_id=1,
            robots=ROBOTS,
            seeds=SEEDS,
            policy_id="uniform_random",
            policy_seed=1,
            scorer_id="",
        )
    )
    started = fleet.poll(PATIENCE_S)
    assert isinstance(started, FleetAnswer)
    none = np.zeros(ROBOTS, np.bool_)
    fleet.request(
        StepFleet(request_id=2, actions=_actions(0), active=EVERY, reset=none, seeds=SEEDS)
    )
    stepped = fleet.poll(PATIENCE_S)
    assert isinstance(stepped, FleetAnswer)
    assert (stepped.states != started.states).any()
    (child,) = [pid for pid, command in _descendants(os.getpid()) if "spawn_main" in command]
    # Who lost an engine is told before the answer comes.
    workers = [pid for pid, command in _descendants(child) if "_doom.worker" in command]
    os.kill(workers[0], signal.SIGKILL)
    fleet.request(
        StepFleet(request_id=3, actions=_actions(1), active=EVERY, reset=none, seeds=SEEDS)
    )
    lost, back, stepped = (fleet.poll(PATIENCE_S) for _ in range(3))
    for news, stopped in ((lost, True), (back, False)):
        assert isinstance(news, FleetNews)
        assert [report.robot for report in news.reports] == [0, 1]
        assert {report.stopped for report in news.reports} == {stopped}
    assert isinstance(stepped, FleetAnswer)
    assert stepped.reports == ()
    os.kill(child, signal.SIGKILL)
    fleet.close()
    _assert_nothing_is_left(mark, memory, tmp_path)
