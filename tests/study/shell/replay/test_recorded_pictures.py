"""Replays of recordings that hold pictures: they are shown without the task, and never wrong."""

from __future__ import annotations

import dataclasses
import random
import sys
from collections.abc import Callable, Iterator
from contextlib import closing
from itertools import pairwise
from pathlib import Path

import numpy as np
import pygame
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from mcap.reader import make_reader

from command_line import study
from pictured_session import pictured_session
from protocols import ROOT
from shown_pictures import draw_without_window
from study.events.inputs import FleetObserved
from study.events.shell import PicturesTaken
from study.foxglove.export import export
from study.protocol import parse_protocol
from study.recording.parts import SessionRecording, read_whole_session
from study.recording.pictures import pictures_in
from study.recording.reader import RawRecord, read_recording
from study.recording.salvage import salvage
from study.recording.wire import decode, encode
from study.screens import CountdownScreen, FleetScreen, Screen
from study.shell.drawing.pictures import Pictures
from study.shell.replay.camera import Camera, Stage
from study.shell.replay.head import Head
from study.shell.replay.marks import read_marks
from study.shell.replay.picture import Picture
from study.shell.replay.recorded_pictures import RecordedPictures
from study.shell.replay.strip import Shown
from study.shell.replay.tape import Tape
from study.verification import verify

pytest.importorskip("gymnasium")

CLOSE = 8.0
"""Mean difference of a colour, of 255, that compression may make."""


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with pictures."""
    return pictured_session(tmp_path_factory.mktemp("recorded"))


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same session, recorded without."""
    return pictured_session(tmp_path_factory.mktemp("plain"), "")


@pytest.fixture
def hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither the environments nor a process that could load them are there."""

    def refuse(*_: object) -> None:
        raise AssertionError("pictures were taken again")

    monkeypatch.setitem(sys.modules, "gymnasium", None)
    monkeypatch.setattr("study.shell.replay.camera.Worker", refuse)


def robots_of(screen: Screen | None) -> list[int]:
    """Return the robots that a screen shows."""
    fleet = screen.fleet if isinstance(screen, CountdownScreen) else screen
    return [tile.robot for tile in fleet.tiles] if isinstance(fleet, FleetScreen) else []


def heads(path: Path) -> Iterator[Head]:
    """Feed a session; yield where it stands after each answer of a fleet whose robots are seen."""
    head = Head()
    for raw in read_recording(path).raw("input"):
        given = decode(raw.topic, raw.data)
        head.feed(raw, given)  # type: ignore[arg-type]
        if isinstance(given, FleetObserved) and robots_of(head.screen):
            yield head


def events(path: Path) -> list[tuple[str, bytes]]:
    """Return the events of a recording, as they are in the file."""
    return [(raw.topic, raw.data) for raw in read_recording(path).raw("event")]


def test_what_was_seen_is_seen_again(recorded: Path, hidden: None) -> None:
    """Every robot of every tile has its picture, as it was but for the compression."""
    pictures, compared = Pictures(), 0
    different: set[bytes] = set()
    with closing(Camera(RecordedPictures(read_whole_session(recorded)))) as camera:
        for head in heads(recorded):
            camera.show(head.film, pictures)
            for robot in robots_of(head.screen):
                pixels = pictures.of(robot).pixels
                assert pixels is not None
                different.add(pixels.tobytes())
                compared += 1
    assert compared > 200
    assert len(different) > 8


def test_they_are_those_of_the_states(recorded: Path) -> None:
    """Held against the task stepped again: each is the picture of its robot's state then."""
    found = RecordedPictures(read_whole_session(recorded))
    stage, compared = Stage("gymnasium:FrozenLake-v1", parameters(recorded)), 0
    for head in heads(recorded):
        film = head.film
        again = stage.pictures(list(film.episodes), film.states)
        now = found.at(film.t_ns, len(film.episodes))
        assert now is not None
        for robot in robots_of(head.screen):
            pixels, expected = now[robot], again[robot]
            assert pixels is not None
            assert expected is not None
            assert np.abs(pixels.astype(int) - expected).mean() < CLOSE
            compared += 1
    assert compared > 150


def parameters(path: Path) -> dict[str, object]:
    """Return the parameters of a recording's task."""
    text = read_recording(path).attachments["protocol.toml"].decode()
    return parse_protocol(text, "recorded").task.parameters


def test_jumps_show_what_was_there(recorded: Path, hidden: None) -> None:
    """To and fro in any order the pictures are those of going through."""
    recording = read_whole_session(recorded)
    in_order = RecordedPictures(recording)
    there = []
    for head in heads(recorded):
        film = head.film
        there.append((film.t_ns, len(film.episodes), in_order.at(film.t_ns, len(film.episodes))))
    random.Random(1).shuffle(there)
    jumping = RecordedPictures(recording)
    for t_ns, robots, expected in there:
        found = jumping.at(t_ns, robots)
        assert found is not None
        assert expected is not None
        for one, other in zip(found, expected, strict=True):
            assert (one is None) == (other is None)
            assert one is None or other is None or one.tobytes() == other.tobytes()


def test_robots_out_of_sight_have_none(recorded: Path) -> None:
    """Where only the operated robot is seen, no picture of the others is recorded."""
    alone = 0
    for _, record in read_recording(recorded).records(PicturesTaken.topic):
        assert isinstance(record, PicturesTaken)
        assert set(record.changed.tolist()) <= set(record.shown.tolist())
        alone += record.robots > 1 and len(record.shown) == 1
    assert alone > 10


def test_no_picture_is_repeated(recorded: Path) -> None:
    """Within a fleet run, a robot's picture follows another one only."""
    last: dict[int, bytes] = {}
    trial, total = -2, 0
    for _, record in read_recording(recorded).records(PicturesTaken.topic):
        assert isinstance(record, PicturesTaken)
        if record.trial_id != trial or record.timestep == 0:
            trial, last = record.trial_id, {}
        ends = np.cumsum(record.lengths).tolist()
        for robot, end, length in zip(
            record.changed.tolist(), ends, record.lengths.tolist(), strict=True
        ):
            data = record.data[end - length : end]
            assert last.get(robot) != data
            last[robot] = data
            total += 1
    assert total > 50


def test_events_are_the_same_with_and_without(recorded: Path, plain: Path) -> None:
    """The session never hears of it: its events are equal byte for byte, and replay so."""
    ours, theirs = events(recorded), events(plain)
    assert len(ours) > 200
    assert ours == theirs
    assert not read_recording(plain).counts[PicturesTaken.topic]
    for path in (recorded, plain):
        verdict = verify(path)
        assert verdict.matches, verdict.difference
        assert not verdict.problems


def test_a_torn_recording_shows_what_is_left(recorded: Path, tmp_path: Path, hidden: None) -> None:
    """Killed in the midst of it, what is there is shown, and recovering loses none of it."""
    whole = recorded.read_bytes()
    torn = tmp_path / f"{recorded.name}.part"
    torn.write_bytes(whole[: len(whole) * 2 // 3])
    session = read_whole_session(torn)
    assert session.losses
    found = RecordedPictures(session)
    assert 50 < found.moments < RecordedPictures(read_whole_session(recorded)).moments
    mended = salvage(torn, tmp_path / "mended.mcap").path
    again = RecordedPictures(read_whole_session(mended))
    assert again.moments == found.moments
    pictures, tape = Pictures(), Tape(session)
    head = tape.go_to(10**15)
    with closing(Camera(again)) as camera:
        while not robots_of(head.screen):
            head = tape.go_to(head.t_ns - 1_000_000_000)
        camera.show(head.film, pictures)
    assert all(pictures.of(robot).pixels is not None for robot in robots_of(head.screen))


class Altered:
    """A session whose records of pictures are others than in the file."""

    def __init__(
        self, recording: SessionRecording, alter: Callable[[PicturesTaken], object]
    ) -> None:
        self._recording, self._alter = recording, alter
        self.parts, self.losses = recording.parts, recording.losses
        self.found = 0

    def raw(self, *families: str) -> Iterator[RawRecord]:
        """Yield records, altered."""
        yield from map(self._altered, self._recording.raw(*families))  # type: ignore[arg-type]

    def find(self, *where: int) -> RawRecord | None:
        """Return a record, altered."""
        self.found += 1
        raw = self._recording.find(*where)  # type: ignore[arg-type]
        return None if raw is None else self._altered(raw)

    def _altered(self, raw: RawRecord) -> RawRecord:
        if raw.topic != PicturesTaken.topic:
            return raw
        made = self._alter(decode(raw.topic, raw.data))  # type: ignore[arg-type]
        data = made if isinstance(made, bytes) else encode(made)  # type: ignore[arg-type]
        return dataclasses.replace(raw, data=data)


def altered(path: Path, alter: Callable[[PicturesTaken], object]) -> RecordedPictures:
    """Return the pictures of a recording whose records were altered by somebody."""
    return RecordedPictures(Altered(read_whole_session(path), alter))  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", range(3))
def test_mutated_pictures_are_missing_at_worst(recorded: Path, seed: int) -> None:
    """Whatever bytes are changed, nothing fails, and what is shown has its size."""
    chance = random.Random(seed)

    def mutate(record: PicturesTaken) -> bytes:
        data = bytearray(encode(record))
        for _ in range(chance.randrange(4)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        return bytes(data)

    found, missing = altered(recorded, mutate), 0
    for head in heads(recorded):
        for picture in found.at(head.film.t_ns, len(head.film.episodes)) or [None]:
            missing += picture is None
            assert picture is None or picture.dtype == np.uint8
    assert missing > 5


def test_an_emptied_picture_is_said_to_be_missing(recorded: Path, hidden: None) -> None:
    """A tile says that there is no picture of its robot; others show theirs."""

    def empty(record: PicturesTaken) -> PicturesTaken:
        # The first robot's data become nothing that is a picture.
        if not record.changed.size or record.changed[0]:
            return record
        length = int(record.lengths[0])
        return dataclasses.replace(record, data=bytes(length) + record.data[length:])

    pictures, seen = Pictures(), 0
    with closing(Camera(altered(recorded, empty))) as camera:
        for head in heads(recorded):
            camera.show(head.film, pictures)
            if len(robots := robots_of(head.screen)) > 1 and 0 in robots:
                assert pictures.of(0).pixels is None
                assert pictures.of(1).pixels is not None
                seen += 1
    assert seen > 10


def test_nothing_leans_on_a_record_that_cannot_be_used(recorded: Path) -> None:
    """After one, pictures recorded before it are not shown any more: it may have replaced them."""
    records = [each for _, each in read_recording(recorded).records(PicturesTaken.topic)]
    spoilt = {
        each.t_ns
        for each, after in pairwise(records)
        if isinstance(each, PicturesTaken)
        and isinstance(after, PicturesTaken)
        and each.changed.size
        and 0 < after.changed.size < after.shown.size
        and each.trial_id == after.trial_id
    }

    def spoil(record: PicturesTaken) -> PicturesTaken:
        return dataclasses.replace(record, encoding="other") if record.t_ns in spoilt else record

    found, whole = altered(recorded, spoil), RecordedPictures(read_whole_session(recorded))
    moments = robots = 0
    for head in heads(recorded):
        place = head.film.t_ns, len(head.film.episodes)
        ours, theirs = found.at(*place), whole.at(*place)
        assert theirs is not None
        assert (ours is None) == (head.film.t_ns in spoilt)
        moments += ours is None
        for one, other in zip(ours or [], theirs, strict=ours is not None):
            assert one is None or (other is not None and one.tobytes() == other.tobytes())
            robots += one is None and other is not None
    assert moments > 3
    assert robots > 3


def test_playing_reads_each_record_once(recorded: Path) -> None:
    """What did not change is not read again, and nothing is read ahead."""
    session = Altered(read_whole_session(recorded), lambda record: record)
    found, moments = RecordedPictures(session), 0  # type: ignore[arg-type]
    assert session.found == 0
    for head in heads(recorded):
        found.at(head.film.t_ns, len(head.film.episodes))
        moments += 1
    assert session.found == moments


def test_moments_without_pictures_are_taken_again(
    recorded: Path, plain: Path, hidden: None
) -> None:
    """A recording without pictures, or another time: the recording has none to show."""
    assert RecordedPictures(read_whole_session(plain)).moments == 0
    found = RecordedPictures(read_whole_session(recorded))
    head = next(heads(recorded))
    robots = len(head.film.episodes)
    assert found.at(head.film.t_ns, robots) is not None
    assert found.at(head.film.t_ns + 1, robots) is None
    assert found.at(head.film.t_ns, robots + 1) is None
    with (
        pytest.raises(AssertionError, match="taken again"),
        closing(Camera(RecordedPictures(read_whole_session(plain)))) as camera,
    ):
        camera.show(head.film, Pictures())


def test_the_replay_draws_them(recorded: Path, hidden: None) -> None:
    """A frame of a video shows the ice in its tiles, without the environment."""
    draw_without_window()
    recording = read_whole_session(recorded)
    marks, tape = read_marks(recording), Tape(recording)
    tiles = [head.film.t_ns for head in heads(recorded) if len(robots_of(head.screen)) > 3]
    t_ns, colours = tiles[len(tiles) // 2], []
    for source in (RecordedPictures(recording), None):
        with closing(Camera(source)) as camera:
            camera.unusable = "a test"
            picture = Picture((1280, 960), marks, "participant", camera=camera)
            surface = pygame.Surface((1280, 960))
            picture.draw(surface, Shown(tape.go_to(t_ns), t_ns, playing=True, speed=1.0))
            colours.append(len(np.unique(pygame.surfarray.array2d(surface))))
    assert colours[0] > colours[1] + 200


def test_it_is_said_that_others_are_shown(plain: Path, tmp_path: Path) -> None:
    """Whoever watches a recording without pictures where they cannot be taken is told so."""
    (tmp_path / "sitecustomize.py").write_text('import sys\nsys.modules["gymnasium"] = None\n')
    without = {"PYTHONPATH": f"{tmp_path}:{ROOT}"}
    done = study(
        "replay", plain, "--video", tmp_path / "x.webm", "--trial", "1", "--rate", "2",
        environment=without,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "could not be taken again here" in done.stderr
    assert "gymnasium" in done.stderr


def test_foxglove_gets_them_as_images(recorded: Path, plain: Path, tmp_path: Path) -> None:
    """The export has every record, and each picture as an image of its robot, as it is."""
    done = export(recorded, tmp_path / "x.mcap", 5.0, lambda *_: None)
    recording = read_recording(recorded)
    assert done.records == sum(recording.counts.values())
    expected: dict[str, list[bytes]] = {}
    for _, record in recording.records(PicturesTaken.topic):
        assert isinstance(record, PicturesTaken)
        for robot, data in (pictures_in(record) or {}).items():
            expected.setdefault(f"camera/robot_{robot + 1}", []).append(data)
    assert len(expected) >= 4
    found: dict[str, list[bytes]] = {}
    with (tmp_path / "x.mcap").open("rb") as stream:
        for schema, channel, message in make_reader(stream, validate_crcs=True).iter_messages():
            if channel.topic.startswith("camera/"):
                assert schema is not None
                assert schema.name == "foxglove.CompressedImage"
                image = CompressedImage.FromString(message.data)
                assert image.format == "jpeg"
                found.setdefault(channel.topic, []).append(image.data)
    assert found == expected
    export(plain, tmp_path / "y.mcap", 5.0, lambda *_: None)
    with (tmp_path / "y.mcap").open("rb") as stream:
        summary = make_reader(stream).get_summary()
    assert summary is not None
    assert not [c for c in summary.channels.values() if c.topic.startswith("camera/")]
