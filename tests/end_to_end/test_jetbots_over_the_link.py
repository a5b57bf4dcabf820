"""A whole session with simulated robots in another process: faults are survived and recorded."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from command_line import study
from extras import need
from patience import until
from protocols import jetbots, lap_study
from study.events.events import Deviation, SessionEnded
from study.events.inputs import RobotReported
from study.recording.reader import read_recording
from tcp_proxy import Cable
from twin_process import TwinProcess, running_twin

need("mujoco", "zmq")


def begun(folder: Path) -> None:
    """Wait until a session is recorded there: a busy computer takes its time to begin."""
    until(lambda: any(folder.glob("*.mcap*")))


class Troubles(threading.Thread):
    """What goes wrong for a second each, over and over, once a session is recorded."""

    def __init__(
        self, folder: Path, *faults: tuple[Callable[[], None], Callable[[], None]]
    ) -> None:
        super().__init__(daemon=True)
        self._folder = folder
        self._faults = faults
        self.ending = threading.Event()

    def run(self) -> None:
        """Go on until told otherwise."""
        begun(self._folder)
        while not self.ending.is_set():
            for fault in self._faults:
                for change in fault:
                    if self.ending.wait(1.0):
                        return
                    change()


def told(twin: TwinProcess, fault: str, cure: str) -> tuple[Callable[[], None], Callable[[], None]]:
    """Return what makes the twin have a fault, and what ends it."""
    return lambda: twin.tell(fault), lambda: twin.tell(cure)


def stops_of(folder: Path) -> set[tuple[int, str]]:
    """Check that a session ended whole, says of each stop, and replays; return the stops."""
    path = next(folder.glob("*.mcap"))
    records = [record for _, record in read_recording(path).records()]
    ended = [record for record in records if isinstance(record, SessionEnded)]
    assert [record.complete for record in ended] == [True]
    reports = [record for record in records if isinstance(record, RobotReported)]
    deviations = [
        record
        for record in records
        if isinstance(record, Deviation) and record.code == "robot_stopped"
    ]
    assert len(deviations) == sum(report.stopped for report in reports)
    replayed = study("replay", "--verify", path)
    assert replayed.returncode == 0, replayed.stderr + replayed.stdout
    return {(report.robot, report.reason) for report in reports if report.stopped}


def simulated(protocol: Path, folder: Path) -> None:
    """Simulate one participant over the link."""
    arguments = ("simulate", protocol, "--participants", "1", "-o", folder)
    done = study(*arguments)
    assert done.returncode == 0, done.stderr


def test_a_session_survives_what_befalls_its_robots(tmp_path: Path) -> None:
    """Poses are lost, cameras freeze, a battery is flat; the session ends whole and says so."""
    with running_twin(tmp_path / "keys", 2) as twin:
        protocol = jetbots(tmp_path, twin.robots_file)
        troubles = Troubles(
            tmp_path / "out",
            told(twin, "pose_lost 2 on", "pose_lost 2 off"),
            told(twin, "camera_frozen 1 on", "camera_frozen 1 off"),
            told(twin, "battery 2 0.05", "battery 2 1"),
        )
        troubles.start()
        simulated(protocol, tmp_path / "out")
        troubles.ending.set()
    expected = {(1, "pose_lost"), (0, "camera_stale"), (1, "battery_flat")}
    assert expected <= stops_of(tmp_path / "out")


@pytest.mark.acceptance
def test_the_lap_study_survives_bad_cables(tmp_path: Path) -> None:
    """A cable is cut, held and slow by turns; its robot is stopped, and the recording says so."""
    with running_twin(tmp_path / "keys", 3) as twin:
        cable = Cable(twin.where["robots"][0]["address"])
        listed = twin.robots_file.read_text()
        twin.robots_file.write_text(listed.replace(cable.far, cable.address))
        assert twin.robots_file.read_text() != listed

        def slow(seconds: float) -> None:
            cable.delay_s = seconds

        troubles = Troubles(
            tmp_path / "out",
            (cable.held.set, cable.held.clear),
            (lambda: slow(0.2), lambda: slow(0.0)),
            (cable.sever, lambda: None),
        )
        troubles.start()
        simulated(lap_study(tmp_path, twin.robots_file), tmp_path / "out")
        troubles.ending.set()
        cable.close()
    stops = stops_of(tmp_path / "out")
    assert {(0, "link_lost"), (0, "link_slow")} <= stops


@pytest.mark.acceptance
def test_the_lap_study_survives_its_twin_killed(tmp_path: Path) -> None:
    """Everything is lost at once in the middle; the session goes on to its end without robots."""
    with running_twin(tmp_path / "keys", 3) as twin:

        def kill_in_the_middle() -> None:
            begun(tmp_path / "out")
            time.sleep(10.0)
            twin.process.kill()

        threading.Thread(target=kill_in_the_middle, daemon=True).start()
        simulated(lap_study(tmp_path, twin.robots_file), tmp_path / "out")
        assert twin.process.poll() is not None
    stops = stops_of(tmp_path / "out")
    assert {(robot, "link_lost") for robot in range(3)} <= stops


def test_a_session_does_not_begin_without_its_robots(tmp_path: Path) -> None:
    """With the twin gone, `study run` says which robot does not answer, and records nothing."""
    with running_twin(tmp_path / "keys", 2) as twin:
        protocol = jetbots(tmp_path, twin.robots_file)
    done = study("run", protocol, "-p", "P01", "-o", tmp_path / "out")
    assert done.returncode == 2
    assert "robot1 did not answer" in done.stderr + done.stdout
    assert not list((tmp_path / "out").glob("*.mcap"))
