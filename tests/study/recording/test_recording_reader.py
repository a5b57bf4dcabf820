from __future__ import annotations

import hashlib
import random
import struct
import subprocess
import sys
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import zstandard
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mcap.writer import Writer

import study
from patience import PATIENCE_S
from record_strategies import any_record, records_of
from study.errors import RecordingError
from study.events.fields import Record, record_types
from study.events.inputs import FleetObserved
from study.recording.client import Recorder
from study.recording.identity import FORMAT_VERSION, PROFILE
from study.recording.mcap_chunks import MAX_CHUNK_MESSAGES, chunk_data, chunk_messages
from study.recording.mcap_records import MAX_CHUNK_BYTES, DamagedError
from study.recording.reader import RawRecord, Recording, read_recording
from study.recording.wire import encode

ROOT = Path(study.__file__ or "").parent.parent


def observed(number: int, robots: int) -> FleetObserved:
    generator = np.random.default_rng(number)
    return FleetObserved(
        t_ns=number,
        request_id=number,
        robots=robots,
        states=generator.random((robots, 4)).astype(np.float32),
        rewards=generator.random(robots).astype(np.float32),
        outcomes=np.zeros(robots, np.int32),
        policy_actions=np.zeros(robots, np.int32),
        scores=generator.random(robots),
    )


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of several chunks with two fleet sizes."""
    folder = tmp_path_factory.mktemp("recordings")
    recorder = Recorder.start(
        folder, "whole", {"protocol.toml": b"name = 'pilot'\n" * 20}, {"session_id": "s1"}
    )
    for batch in range(6):
        for number in range(30):
            recorder.write(observed(100 * batch + number, 4 if batch < 3 else 12), 1 + number)
        assert recorder.ensure_durable(PATIENCE_S)
    return recorder.close()


def raws(recording: Recording) -> list[RawRecord]:
    return list(recording.raw())


def test_every_record_type_survives_the_file(tmp_path: Path) -> None:
    """A record of each declared type comes back from a file with the same bytes."""

    @settings(
        max_examples=5,
        deadline=None,
        database=None,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.large_base_example],
    )
    @given(
        records=st.tuples(*[records_of(item) for item in record_types().values()]),
        extra=st.lists(any_record(), max_size=5),
        name=st.uuids(),
    )
    def check(records: tuple[Record, ...], extra: list[Record], name: Any) -> None:
        sent = [*records, *extra]
        folder = tmp_path / hashlib.sha256(b"".join(map(encode, sent))).hexdigest()
        recorder = Recorder.start(folder, str(name), {}, {})
        for record in sent:
            recorder.write(record, 7)
        found = [record for _, record in read_recording(recorder.close()).records()][1:]
        assert [type(record) for record in found] == [type(record) for record in sent]
        assert [encode(record) for record in found] == [encode(record) for record in sent]

    check()


def test_columns_of_a_file(whole: Path) -> None:
    """Two fleet sizes are two runs, each with shaped arrays that equal the records."""
    recording = read_recording(whole)
    small, large = recording.columns("input/fleet_observed")
    assert small["states"].shape == (90, 4, 4)
    assert large["states"].shape == (90, 12, 4)
    records = list(recording.records("input/fleet_observed"))
    assert [*small["sequence"], *large["sequence"]] == [sequence for sequence, _ in records]
    for row, (_, record) in enumerate(records[90:]):
        assert isinstance(record, FleetObserved)
        assert (large["states"][row] == record.states).all()
        assert (large["scores"][row] == record.scores).all()
        assert large["t_ns"][row] == record.t_ns


def test_what_a_recording_says_of_itself(whole: Path) -> None:
    """Hash, session, metadata and attachments are those of the file."""
    recording = read_recording(whole)
    assert recording.sha256 == hashlib.sha256(whole.read_bytes()).hexdigest()
    assert recording.session_id == "s1"
    assert recording.metadata["format_version"] == str(FORMAT_VERSION)
    assert set(recording.attachments) == {"protocol.toml"}
    assert recording.complete
    assert len(raws(recording)) == 181
    assert {raw.topic for raw in recording.raw("input")} == {"input/fleet_observed"}
    assert list(recording.raw("event")) == []
    with pytest.raises(RecordingError, match='no topic "event/nothing"'):
        list(recording.records("event/nothing"))


def test_torn_files_give_their_prefix(whole: Path, tmp_path: Path) -> None:
    """Cut anywhere, a file gives a prefix of its records and says that it is not complete."""
    data, full = whole.read_bytes(), raws(read_recording(whole))
    torn = tmp_path / "torn.mcap"
    counts = []
    for end in [*range(0, len(data), 997), len(data) - 1]:
        torn.write_bytes(data[:end])
        try:
            recording = read_recording(torn)
        except RecordingError:
            # The beginning that says whose file this is has to be there.
            assert end < 1_500
            continue
        found = raws(recording)
        assert found == full[: len(found)]
        assert not recording.complete
        assert recording.problems
        counts.append(len(found))
    assert counts == sorted(counts)
    assert len(set(counts)) >= 6
    assert counts[-1] == len(full)


def test_flipped_bits_are_never_silent(whole: Path, tmp_path: Path) -> None:
    """Any single flipped bit is noticed, and what is still read is unchanged."""
    data, recording = whole.read_bytes(), read_recording(whole)
    full = raws(recording)
    generator = random.Random(5)
    flipped = tmp_path / "flipped.mcap"
    for _ in range(400):
        place, bit = generator.randrange(len(data)), generator.randrange(8)
        spoiled = bytearray(data)
        spoiled[place] ^= 1 << bit
        flipped.write_bytes(spoiled)
        try:
            found = read_recording(flipped)
        except RecordingError:
            continue
        assert not found.complete, f"bit {bit} of byte {place} went unnoticed"
        assert found.problems
        assert_accounted_for(found, full)


def assert_accounted_for(found: Recording, full: list[RawRecord]) -> None:
    """Hold what is left of a recording against all of it: equal, or reported as lost."""
    left = {raw.sequence: raw for raw in found.raw()}
    for raw in full:
        if raw.sequence in left:
            assert left.pop(raw.sequence) == raw
        else:
            assert any(loss.overlaps(raw.sequence, raw.sequence) for loss in found.losses)
    assert not left


def chunk(data: bytes, *, size: int | None = None, packed: bytes | None = None) -> bytes:
    content = zstandard.compress(data) if packed is None else packed
    head = struct.pack("<QQQI", 0, 0, len(data) if size is None else size, zlib.crc32(data))
    return head + struct.pack("<I", 4) + b"zstd" + struct.pack("<Q", len(content)) + content


def test_a_chunk_comes_back() -> None:
    """The bombs below differ from this chunk in their sizes only."""
    assert chunk_data(chunk(b"abc" * 100)) == b"abc" * 100


@pytest.mark.parametrize(
    ("payload", "reason"),
    [
        (chunk(b"a", size=2**62), "more than"),
        (chunk(b"a", size=MAX_CHUNK_BYTES + 1), "more than"),
        (chunk(b"a", packed=zstandard.compress(bytes(2**20))), "contradict"),
        (chunk(b"a", packed=b"no frame"), "cannot be unpacked"),
        (chunk(b"a")[:-3], "length is wrong"),
        (b"", "cut off"),
    ],
)
def test_bombs_are_not_unpacked(payload: bytes, reason: str) -> None:
    """A chunk that claims or holds other sizes than it should is refused before unpacking."""
    with pytest.raises(DamagedError, match=reason):
        chunk_data(payload)


def test_too_many_tiny_messages_are_refused() -> None:
    """The number of messages in a chunk is bounded."""
    message = struct.pack("<BQHIQQ", 5, 22, 1, 0, 0, 0)
    with pytest.raises(DamagedError, match="messages"):
        chunk_messages(message * (MAX_CHUNK_MESSAGES + 1))


def other_file(path: Path, profile: str, version: str) -> Path:
    with path.open("wb") as stream:
        writer: Any = Writer(stream, enable_data_crcs=True)
        writer.start(profile, "test")
        writer.add_metadata(PROFILE, {"format_version": version})
        writer.finish()
    return path


def test_other_files_are_refused(tmp_path: Path) -> None:
    """Other MCAP files, other files, missing ones and newer formats get a clear error each."""
    text = tmp_path / "notes.txt"
    text.write_text("no recording")
    empty = tmp_path / "empty.mcap"
    empty.write_bytes(b"")
    for path, reason in [
        (other_file(tmp_path / "ros.mcap", "ros2", "1"), "another program"),
        (other_file(tmp_path / "new.mcap", PROFILE, "2"), "format version 2"),
        (other_file(tmp_path / "odd.mcap", PROFILE, "x"), "unknown format version"),
        (text, "does not begin as an MCAP file"),
        (empty, r"empty.mcap is empty: it has 0 bytes"),
        (tmp_path / "missing.mcap", "cannot be read"),
        (tmp_path, "cannot be read"),
    ]:
        with pytest.raises(RecordingError, match=reason):
            read_recording(path)


def test_the_reader_stays_light(whole: Path) -> None:
    """Reading loads neither the window's nor the fits' libraries, nor the session."""
    code = (
        "import sys, pathlib\n"
        "from study.recording.reader import read_recording\n"
        f"r = read_recording(pathlib.Path({str(whole)!r}))\n"
        "assert len(list(r.records())) == 181 and r.columns('input/fleet_observed')\n"
        "heavy = {'pygame', 'torch', 'pandas', 'study.session', 'study.tasks', 'study.shell'}\n"
        "print(sorted(heavy & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    assert done.stdout.strip() == "[]"


def test_a_recording_closed_while_its_folder_is_looked_at_is_read(whole: Path) -> None:
    """It was listed as unfinished, and has its final name by now."""
    listed = whole.with_name(f"{whole.name}.part")
    assert read_recording(listed).path == whole
    with pytest.raises(RecordingError, match="No such file"):
        read_recording(whole.with_name("nothing.mcap.part"))
