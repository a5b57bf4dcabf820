"""Replays of a session in DOOM: with the engine as it was seen, without it from above."""

from __future__ import annotations

import os
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from extras import need
from pictured_session import RECORDED
from protocols import in_doom
from seen_inputs import SeenInputs, seen_session
from study.commands.simulating import simulate_session, simulated_assignments
from study.events.inputs import FleetObserved
from study.loading import load_protocol
from study.recording.parts import read_whole_session
from study.recording.wire import decode
from study.screens import FleetScreen
from study.shell.drawing.pictures import Pictures
from study.shell.replay.camera import Camera
from study.shell.replay.head import Head
from study.shell.replay.recorded_pictures import RecordedPictures

pytestmark = pytest.mark.acceptance

SMALLER = (
    ("robots = 12", "robots = 2"),
    ("robots = 4", "robots = 2"),
    ("episodes = 2", "episodes = 1"),
    ("trials = 2\n", "trials = 1\n"),
    ("trial_timesteps = 40", "trial_timesteps = 20"),
    ("dwell = 15", "dwell = 5"),
)
QUARTERS = (0.0, 0.3, 0.6, 0.9)


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> SeenInputs:
    """A session in DOOM, and what the participant saw in it."""
    need("vizdoom")
    return seen_session(in_doom(tmp_path_factory.mktemp("doom"), *SMALLER))


def test_with_the_engine_every_tic_is_seen_again(seen: SeenInputs) -> None:
    """From seeds and actions alone each of the four pictures a timestep comes back, to the byte."""
    head, pictures, compared = Head(), Pictures(), 0
    with closing(Camera()) as camera:
        for given in seen.inputs:
            head.take_note(None, given, head.session.handle(given))  # type: ignore[arg-type]
            if not isinstance(given, FleetObserved) or given.request_id not in seen.pictures:
                continue
            camera.show(head.film, pictures)
            before = seen.pictures[given.request_id]
            assert before.shape[:2] == (given.robots, len(QUARTERS))
            for robot in range(given.robots):
                for tic, share in enumerate(QUARTERS):
                    pixels = pictures.of(robot, share).pixels
                    assert pixels is not None
                    assert pixels.tobytes() == before[robot, tic].tobytes()
            compared += 1
    assert compared > 60


def test_without_the_engine_all_pictures_are_missing(
    seen: SeenInputs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing fails: tiles are told that there is no picture, and draw the map."""
    (tmp_path / "sitecustomize.py").write_text('import sys\nsys.modules["vizdoom"] = None\n')
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    )
    head, pictures, asked = Head(), Pictures(), 0
    with closing(Camera()) as camera:
        for given in seen.inputs:
            head.take_note(None, given, head.session.handle(given))  # type: ignore[arg-type]
            if isinstance(given, FleetObserved) and given.request_id in seen.pictures:
                camera.show(head.film, pictures)
                assert [pictures.of(robot).pixels for robot in range(given.robots)] == [
                    None
                ] * given.robots
                asked += 1
        assert "make doom" in camera.unusable
    assert asked > 60


def test_without_the_engine_recorded_pictures_are_seen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of each timestep the last picture, of every robot on the screen; no process is started."""
    need("vizdoom")
    protocol = in_doom(tmp_path, *SMALLER)
    protocol.write_text(protocol.read_text() + RECORDED)
    (assignment,) = simulated_assignments(load_protocol(str(protocol)), 1, seed=3)
    path = simulate_session(str(protocol), assignment, 3, tmp_path)

    def refuse(*_: object) -> None:
        raise AssertionError("the engine was asked")

    monkeypatch.setattr("study.shell.replay.camera.Worker", refuse)
    head, pictures, compared = Head(), Pictures(), 0
    with closing(Camera(RecordedPictures(read_whole_session(path)))) as camera:
        for raw in read_whole_session(path).raw("input"):
            given = decode(raw.topic, raw.data)
            head.feed(raw, given)  # type: ignore[arg-type]
            if isinstance(given, FleetObserved) and isinstance(head.screen, FleetScreen):
                camera.show(head.film, pictures)
                for tile in head.screen.tiles:
                    pixels = pictures.of(tile.robot).pixels
                    assert pixels is not None
                    assert pixels.shape == (120, 160, 3)
                    assert len(np.unique(pixels)) > 30
                    compared += 1
    assert compared > 100
