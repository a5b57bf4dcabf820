"""The file for Foxglove: the session's own messages, and a scene that agrees with them."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from typer.testing import CliRunner

from study.commands.main import app
from study.errors import RecordingError
from study.events.events import TrialStarted
from study.events.inputs import SessionOpened
from study.events.task_description import TaskDescription
from study.foxglove.export import export
from study.foxglove.schemas import MAP_TOPIC, POSES_TOPIC, ROBOTS_TOPIC, SCENE_TYPES
from study.recording.parts import read_session
from study.recording.reader import read_recording

GOLDEN = Path(__file__).parents[1] / "recording" / "golden" / "v1.mcap"


def decoded(path: Path, *topics: str) -> list[tuple[str, int, Any]]:
    """Return topic, log time and message, read by mcap's own reader, checksums checked."""
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
        return [
            (channel.topic, message.log_time, content)
            for _, channel, message, content in reader.iter_decoded_messages(topics or None)
        ]


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The golden recording, exported at a rate that leaves no timestep out."""
    target = tmp_path_factory.mktemp("export") / "all.mcap"
    done = export(GOLDEN, target, 1000.0)
    assert (done.problems, done.without_scene, done.unknown_records) == ((), "", 0)
    return target


def test_the_sessions_own_messages_are_kept_as_they_are(exported: Path) -> None:
    """Topic, number, time and bytes of every record; the original is not touched."""
    with exported.open("rb") as stream:
        found = sorted(
            (message.sequence, channel.topic, message.log_time, message.data)
            for _, channel, message in make_reader(stream, validate_crcs=True).iter_messages()
            if channel.topic not in SCENE_TYPES
        )
    session = read_session(GOLDEN)
    assert found == sorted((r.sequence, r.topic, r.log_time_ns, r.data) for r in session.raw())
    with exported.open("rb") as stream:
        attached = {item.name: item.data for item in make_reader(stream).iter_attachments()}
    assert attached == session.attachments
    assert exported.stat().st_mode & 0o777 == 0o600


def test_an_independent_reader_decodes_every_message(exported: Path) -> None:
    """Each through the descriptor in the file."""
    rows = decoded(exported)
    assert {topic for topic, _, _ in rows} >= {MAP_TOPIC, ROBOTS_TOPIC, POSES_TOPIC}
    assert len(rows) > 710


def test_robots_are_drawn_where_the_states_say(exported: Path) -> None:
    """Poses and bodies of each timestep agree with its states; headings with the quaternion."""
    step: Any = None
    compared = 0
    for topic, _, content in decoded(exported, "event/timestep", POSES_TOPIC, ROBOTS_TOPIC):
        if topic == "event/timestep":
            assert step is None
            step = content
        elif step is not None:
            # What a step adds follows it; the next fleet run may begin at the same time.
            states = np.array(step.states, np.float32).reshape(step.robots, -1)
            if topic == ROBOTS_TOPIC:
                bodies = [entity.cylinders[0].pose.position.x for entity in content.entities]
                assert bodies == states[:, 0].tolist()
                names = [entity.id for entity in content.entities]
                assert names == [f"robot_{number + 1}" for number in range(step.robots)]
                continue
            poses = content.poses
            assert [pose.position.x for pose in poses] == states[:, 0].tolist()
            assert [pose.position.y for pose in poses] == states[:, 1].tolist()
            turns = np.array([2 * np.arctan2(p.orientation.z, p.orientation.w) for p in poses])
            assert np.allclose(np.exp(1j * turns), np.exp(1j * states[:, 2]), atol=1e-6)
            step = None
            compared += 1
    assert compared == 161


def test_the_map_is_drawn_as_the_task_describes_it(exported: Path) -> None:
    """Every mark, each at its place."""
    ((_, _, update),) = decoded(exported, MAP_TOPIC)
    opened = next(r for _, r in read_recording(GOLDEN).records(SessionOpened.topic))
    assert isinstance(opened, SessionOpened)
    scene = TaskDescription.from_json(opened.task_json).scene
    assert len(update.entities) == len(scene.rectangles) + len(scene.discs)
    goal = next(mark for mark in scene.discs if mark.role == "goal")
    drawn = next(entity for entity in update.entities if entity.id == "goal_1").cylinders[0]
    assert (drawn.pose.position.x, drawn.pose.position.y) == (goal.x, goal.y)
    assert drawn.size.x == 2 * goal.radius
    room = next(mark for mark in scene.rectangles if mark.role == "room")
    cube = next(entity for entity in update.entities if entity.id == "room_1").cubes[0]
    assert (cube.size.x, cube.size.y) == (room.width, room.height)
    assert cube.pose.position.x == room.x + room.width / 2


def test_fewer_pictures_at_a_lower_rate(tmp_path: Path) -> None:
    """No two within the period, but for the first of a fleet run; all records are there."""
    done = export(GOLDEN, tmp_path / "slow.mcap", 0.5)
    assert done.records == 710
    times = [time_ns for _, time_ns, _ in decoded(tmp_path / "slow.mcap", POSES_TOPIC)]
    started = len(list(read_recording(GOLDEN).records(TrialStarted.topic)))
    steps = len(times) - started
    seconds = (times[-1] - times[0]) / 1e9
    assert 0 < steps <= seconds * 0.5 + 1


def test_foxglove_itself_gives_the_same_schema() -> None:
    """Messages of ours are what Foxglove's own SDK calls by these names."""
    messages = pytest.importorskip("foxglove.messages")
    for topic, kind in SCENE_TYPES.items():
        theirs = getattr(messages, kind.DESCRIPTOR.name).get_schema()
        assert theirs.name == kind.DESCRIPTOR.full_name, topic
        assert theirs.encoding == "protobuf"


def test_a_file_in_the_way_is_kept(tmp_path: Path) -> None:
    """Nothing is overwritten; the message names the file."""
    target = tmp_path / "here.mcap"
    target.write_bytes(b"mine")
    with pytest.raises(RecordingError, match="exists already"):
        export(GOLDEN, target, 5.0)
    assert [path.name for path in tmp_path.iterdir()] == ["here.mcap"]
    assert target.read_bytes() == b"mine"


def test_a_torn_recording_gives_what_is_left_and_status_3(tmp_path: Path) -> None:
    """The command says what is missing; the torn file stays as it is."""
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(GOLDEN.read_bytes()[:-2000])
    before = hashlib.sha256(torn.read_bytes()).hexdigest()
    target = tmp_path / "new" / "out.mcap"
    run = CliRunner().invoke(app, ["export-foxglove", str(torn), "-o", str(target)])
    assert run.exit_code == 3, run.output
    assert "Not whole" in run.output
    assert len(decoded(target, "event/timestep")) > 100
    assert hashlib.sha256(torn.read_bytes()).hexdigest() == before


def test_something_else_than_a_recording_is_refused(tmp_path: Path) -> None:
    """One message, and no file is left behind; an export is no recording either."""
    other = tmp_path / "other.mcap"
    other.write_bytes(b"no recording")
    with pytest.raises(RecordingError):
        export(other, tmp_path / "out.mcap", 5.0)
    export(GOLDEN, tmp_path / "first.mcap", 5.0)
    with pytest.raises(RecordingError):
        export(tmp_path / "first.mcap", tmp_path / "out.mcap", 5.0)
    assert not list(tmp_path.glob("out*"))
