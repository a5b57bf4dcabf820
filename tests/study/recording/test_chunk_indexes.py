"""The writer's memory of chunks is small, and the file is the same byte for byte."""

from __future__ import annotations

import io
import random
import sys
import tracemalloc
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from study.recording import chunk_indexes
from study.recording.chunk_indexes import ROOM_BYTES, ChunkIndexes, keep_small

CHANNELS = 12


def written(chunks: int, *, small: bool) -> tuple[bytes, int]:
    """Write as many chunks; return the file, and bytes of memory that were taken meanwhile."""
    chance, stream = random.Random(1), io.BytesIO()
    writer: Any = Writer(stream, enable_data_crcs=True)
    if small:
        keep_small(writer)
    writer.start()
    schema = writer.register_schema("s", "", b"")
    channels = [writer.register_channel(f"t{number}", "", schema) for number in range(CHANNELS)]
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0] - sys.getsizeof(stream)
    for number in range(chunks):
        for channel in chance.sample(channels, chance.randint(1, CHANNELS)):
            data = chance.randbytes(chance.randint(0, 60))
            writer.add_message(channel, number * 10**9, data, number * 10**9, number)
        writer.flush()
    taken = tracemalloc.get_traced_memory()[0] - sys.getsizeof(stream) - before
    tracemalloc.stop()
    writer.finish()
    return stream.getvalue(), taken


@pytest.mark.parametrize("chunks", [0, 1, 700])
def test_the_file_is_the_same_as_without(chunks: int) -> None:
    """Several compressed blocks, one open block, or none."""
    small, _ = written(chunks, small=True)
    assert small == written(chunks, small=False)[0]
    summary = make_reader(io.BytesIO(small)).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) == chunks


def test_an_hour_takes_less_than_a_mebibyte() -> None:
    """Two chunks a second; mcap's own list takes more than twice as much in twelve minutes."""
    taken = [written(1440, small=small)[1] for small in (True, False)]
    assert taken[0] < 1 << 16
    assert (taken[0] + ROOM_BYTES) * 2 < taken[1]


def test_more_than_there_is_room_for_takes_twice_as_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """A day in one recording loses nothing."""
    monkeypatch.setattr(chunk_indexes, "ROOM_BYTES", 1 << 10)
    small, _ = written(1200, small=True)
    assert small == written(1200, small=False)[0]


def test_another_version_of_mcap_is_noticed() -> None:
    """What is kept elsewhere, or has begun already, is not replaced in silence."""
    with pytest.raises(AttributeError):
        keep_small(object())
    begun: Any = Writer(io.BytesIO())
    begun._Writer__chunk_indices.append(ChunkIndexes())
    with pytest.raises(AttributeError):
        keep_small(begun)
