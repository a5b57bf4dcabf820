"""Salvaging: what is kept, what is said to be lost, and bombs that are refused."""

from __future__ import annotations

import hashlib
import json
import struct
import zlib
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pytest
import zstandard
from mcap.reader import make_reader
from typer.testing import CliRunner

from patience import PATIENCE_S
from study.commands.main import app
from study.errors import RecordingError
from study.events.inputs import FleetObserved
from study.events.shell import Note
from study.recording import batches
from study.recording.client import Recorder
from study.recording.identity import PROFILE, SELF_DIGEST, metadata_digest
from study.recording.losses import Loss
from study.recording.mcap_index import ChunkTable
from study.recording.mcap_records import MAGIC, text
from study.recording.reader import Recording, read_recording
from study.recording.salvage import salvage


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording of several chunks, notes only in the first ones."""
    folder = tmp_path_factory.mktemp("salvage")
    recorder = Recorder.start(folder, "whole", {"protocol.toml": b"a = 1\n"}, {"session_id": "s1"})
    for batch in range(6):
        for number in range(10):
            if batch < 2:
                recorder.write(Note(t_ns=number, text=f"note {number}"), 10**9 * batch)
            zeros = np.zeros(2, np.int32)
            robots = FleetObserved(
                t_ns=number,
                request_id=number,
                robots=2,
                states=np.full((2, 4), batch, np.float32),
                rewards=np.zeros(2, np.float32),
                outcomes=zeros,
                policy_actions=zeros,
                scores=np.zeros(0),
            )
            recorder.write(robots, 10**9 * batch)
        assert recorder.ensure_durable(PATIENCE_S)
    return recorder.close()


def spoil(source: Path, target: Path, place: int) -> Path:
    """Write a copy with eight bytes overwritten."""
    data = bytearray(source.read_bytes())
    data[place : place + 8] = b"\xff" * 8
    target.write_bytes(data)
    return target


def stock_count(path: Path) -> int:
    """Count the messages that the MCAP project's own reader finds."""
    with path.open("rb") as stream:
        return sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())


def test_chunks_after_the_damage_are_found(whole: Path, tmp_path: Path) -> None:
    """Of a file damaged in the middle only that chunk is lost; numbers and topics are told."""
    original = read_recording(whole)
    full = list(original.raw())
    damaged = spoil(whole, tmp_path / "damaged.mcap", original.chunks.start[4] + 60)
    lost = read_recording(damaged)
    held = {raw.sequence for raw in lost.raw()}
    assert [raw for raw in full if raw.sequence in held] == list(lost.raw())
    (loss,) = lost.losses
    missing = {raw.sequence for raw in full} - held
    assert missing == set(range(loss.first, (loss.last or 0) + 1))
    assert max(held) > max(missing)
    assert lost.lost_by_topic == {"input/fleet_observed": len(missing)}
    assert any(f"({len(missing)})" in problem for problem in lost.problems)
    assert not lost.complete


def test_a_salvaged_file_says_so(whole: Path, tmp_path: Path) -> None:
    """It is whole for any reader, and states its origin's hash and what is missing."""
    damaged = spoil(whole, tmp_path / "damaged.mcap", read_recording(whole).chunks.start[3] + 60)
    before = damaged.read_bytes()
    done = salvage(damaged, tmp_path / "new.mcap")
    lost, new = read_recording(damaged), read_recording(done.path)
    assert damaged.read_bytes() == before
    assert list(new.raw()) == list(lost.raw())
    assert new.salvaged_from == done.sha256 == hashlib.sha256(before).hexdigest()
    assert new.losses == lost.losses == done.losses
    assert (new.session_id, new.attachments) == ("s1", {"protocol.toml": b"a = 1\n"})
    assert json.loads(new.metadata["salvaged_lost_by_topic"]) == lost.lost_by_topic
    assert not new.complete
    assert stock_count(done.path) == done.records == len(new.sequences)
    assert salvage(done.path, tmp_path / "again.mcap").losses == new.losses


@pytest.mark.parametrize("torn", [False, True])
def test_a_lost_beginning_loses_no_channel(whole: Path, tmp_path: Path, torn: bool) -> None:
    """Without the chunk that declares the channels, summary or metadata still tell them."""
    first = read_recording(whole).chunks.start[0]
    damaged = spoil(whole, tmp_path / "damaged.mcap", first + 60)
    if torn:
        data = damaged.read_bytes()
        damaged.write_bytes(data[: read_recording(whole).chunks.start[-1]])
    lost = read_recording(damaged)
    assert lost.losses[0] == Loss(0, 0, None, lost.losses[0].before_ns)
    assert len(list(lost.records())) == len(lost.sequences) > 50
    assert stock_count(salvage(damaged, tmp_path / "new.mcap").path) == len(lost.sequences)


def run(*arguments: object) -> tuple[int, str]:
    """Run `study recover`; return its exit status and what it said."""
    done = CliRunner().invoke(app, ["recover", *map(str, arguments)])
    return done.exit_code, done.output


def test_exit_statuses(whole: Path, tmp_path: Path) -> None:
    """0 when nothing is lost, 3 when something is; the new file takes nobody's name."""
    data = whole.read_bytes()
    unfinished = tmp_path / "P01.mcap.part"
    unfinished.write_bytes(data[:-20])
    status, said = run(unfinished)
    assert (status, "Nothing is lost" in said) == (0, True)
    assert read_recording(tmp_path / "P01_salvaged.mcap").complete
    with pytest.raises(RecordingError, match="exists already"):
        salvage(unfinished, tmp_path / "P01_salvaged.mcap")
    torn = data[: read_recording(whole).chunks.start[-1]]
    unfinished.write_bytes(torn)
    status, said = run(unfinished, "-o", tmp_path / "new.mcap")
    assert (status, "Lost" in said) == (3, True)
    assert "The end is missing" in said
    assert unfinished.read_bytes() == torn


def test_what_is_wrong_does_not_name_the_file_again(whole: Path, tmp_path: Path) -> None:
    """Whoever tells it names the file; two damaged places, and the lost end, are sentences."""
    recording = read_recording(whole)
    damaged = spoil(whole, tmp_path / "P01.mcap.part", recording.chunks.start[2] + 60)
    damaged.write_bytes(damaged.read_bytes()[: recording.chunks.start[-1] + 20])
    problems = read_recording(damaged).problems
    assert len(problems) >= 3
    assert not any("P01" in problem for problem in problems)
    assert all(problem[0].isupper() for problem in problems)
    status, said = run(damaged)
    assert status == 3
    assert all(f"\n  {problem}" in f"\n{said}" for problem in problems)


def test_files_of_others_are_refused(tmp_path: Path) -> None:
    """Nothing is written for a file that is none of ours, or is not there."""
    other = tmp_path / "other.mcap"
    other.write_bytes(b"something else" * 100)
    for path in (other, tmp_path / "missing.mcap"):
        with pytest.raises(RecordingError):
            salvage(path, tmp_path / "new.mcap")
    assert not list(tmp_path.glob("new*"))


def test_a_file_without_a_record_is_refused(whole: Path, tmp_path: Path) -> None:
    """A session that broke off as it began left a beginning: no empty recording is made of it."""
    torn = tmp_path / "P01.mcap.part"
    beginnings = [bomb(torn).read_bytes(), whole.read_bytes()[: first_chunk(whole)]]
    for beginning in beginnings:
        torn.write_bytes(beginning)
        done = CliRunner().invoke(app, ["recover", str(torn)])
        assert isinstance(done.exception, RecordingError)
        assert f"{torn} holds no record that can be read" in str(done.exception)
        assert "Its summary and index are missing." in str(done.exception)
        assert list(tmp_path.iterdir()) == [torn]
        assert torn.read_bytes() == beginning


def first_chunk(path: Path) -> int:
    """Return where the chunk with the first records begins, bytes; the opening note's counts."""
    return int(read_recording(path).chunks.start[0])


def bomb(path: Path, *parts: bytes) -> Path:
    """Write a file that says that it is ours, with further records."""
    entries = {"format_version": "1"}
    entries[SELF_DIGEST] = metadata_digest(entries)
    packed = b"".join(text(key) + text(value) for key, value in entries.items())
    metadata = text(PROFILE) + struct.pack("<I", len(packed)) + packed
    header = text(PROFILE) + text("test")
    path.write_bytes(MAGIC + framed(1, header) + framed(0x0C, metadata) + b"".join(parts))
    return path


def framed(opcode: int, payload: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(payload)) + payload


def packed_chunk(data: bytes, size: int | None = None) -> bytes:
    content = zstandard.compress(data)
    head = struct.pack("<QQQI", 0, 0, len(data) if size is None else size, zlib.crc32(data))
    return framed(6, head + text("zstd") + struct.pack("<Q", len(content)) + content)


ATTACHMENT = bytes(16) + text("a") + text("b") + struct.pack("<Q", 2**62)


@pytest.mark.parametrize(
    ("parts", "reason"),
    [
        ([packed_chunk(bytes(2**26))], "more than 50331648"),
        ([packed_chunk(b"a", 2**60)], "more than 50331648"),
        ([packed_chunk(struct.pack("<BQHIQQ", 5, 22, 1, 0, 0, 0) * 100_001)], "100000 messages"),
        ([struct.pack("<BQ", 9, 2**62) + ATTACHMENT], "more than 67108864"),
    ],
    ids=["decompression", "stated size", "tiny messages", "attachment"],
)
def test_bombs_are_refused(tmp_path: Path, parts: list[bytes], reason: str) -> None:
    """Each bomb is one clear error, for reading and for salvaging."""
    path = bomb(tmp_path / "bomb.mcap", *parts)
    for attempt in (read_recording, lambda file: salvage(file, tmp_path / "new.mcap")):
        with pytest.raises(RecordingError, match=reason):
            attempt(path)
    assert not list(tmp_path.glob("new*"))


def test_an_attachment_that_lies_is_left_out(tmp_path: Path) -> None:
    """An attachment that states 2**62 bytes in a short record is damage, and said so."""
    found = read_recording(bomb(tmp_path / "bomb.mcap", framed(9, ATTACHMENT)))
    assert found.attachments == {}
    assert any("the length is wrong" in problem for problem in found.problems)


def test_blocks_are_the_columns_in_pieces(whole: Path) -> None:
    """Blocks one after another hold what `columns` holds, damaged file or not."""
    recording: Recording = read_recording(whole)
    blocks = list(recording.blocks("input/fleet_observed"))
    columns = recording.columns("input/fleet_observed")
    for name in columns[0]:
        pieces = [block[name] for block in blocks]
        assert np.array_equal(np.concatenate(pieces), columns[0][name])


def test_rare_topics_leave_other_chunks_alone(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of an indexed file only the chunks that hold the topic are unpacked."""
    recording = read_recording(whole)
    unpacked: list[int] = []
    real = batches._load

    def counted(stream: BinaryIO, chunks: ChunkTable, *others: Any) -> batches.Batch:
        unpacked.extend(chunks.start.tolist())
        return real(stream, chunks, *others)

    monkeypatch.setattr(batches, "_load", counted)
    assert len(list(recording.records("shell/note"))) == 21
    assert 0 < len(unpacked) < len(recording.chunks)
    unpacked.clear()
    assert list(recording.records("event/trial_started")) == []
    assert unpacked == []
