"""The chunk index of an MCAP file: where each chunk is, and the message index of each channel."""

from __future__ import annotations

import dataclasses
from typing import Final

import numpy as np
import numpy.typing as npt

from study.recording.mcap_chunks import rows_at
from study.recording.mcap_records import MAX_CHUNK_BYTES, RECORD, DamagedError, ExceedsError

_HEAD: Final = np.dtype(
    [
        ("first_ns", "<u8"),
        ("last_ns", "<u8"),
        ("start", "<u8"),
        ("length", "<u8"),
        ("places_bytes", "<u4"),
    ]
)
_PLACE: Final = np.dtype([("channel", "<u2"), ("place", "<u8")])
_MIDDLE: Final = np.dtype([("index_length", "<u8"), ("name_bytes", "<u4")])
_SIZES: Final = np.dtype([("packed", "<u8"), ("size", "<u8")])

Places = npt.NDArray[np.int64]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class ChunkTable:
    """Chunks, in order of sequence; an array each, since a session has thousands.

    Attributes:
        start: place of each one's payload in the file, bytes [c].
        length: of the payload, bytes [c].
        size: of its records once unpacked, bytes [c].
        end: place of the first byte after the chunk and its message indexes [c].
        places: channel to where in the file its message index for each chunk begins [c]; 0 where
            the chunk has no message of it.
        indexed: whether the message indexes can be trusted; if not, `places` says only whether
            there are messages.
    """

    start: Places
    length: Places
    size: Places
    end: Places
    places: dict[int, Places]
    indexed: bool

    def __len__(self) -> int:
        return len(self.start)

    def rows(self, which: slice | npt.NDArray[np.bool_] | npt.NDArray[np.intp]) -> ChunkTable:
        """Return some of the chunks."""
        return ChunkTable(
            self.start[which],
            self.length[which],
            self.size[which],
            self.end[which],
            {channel: places[which] for channel, places in self.places.items()},
            self.indexed,
        )

    def each(self, which: slice) -> list[ChunkTable]:
        """Return some of the chunks, one by one."""
        numbers = range(*which.indices(len(self)))
        return [self.rows(slice(number, number + 1)) for number in numbers]

    def holding(self, channels: frozenset[int]) -> ChunkTable:
        """Return the chunks that have messages of any of the channels."""
        held = np.zeros(len(self), bool)
        for channel in channels & self.places.keys():
            held |= self.places[channel] > 0
        return self.rows(held)


def index_table(summary: bytes, at: list[int], lengths: list[int], end: int) -> ChunkTable:
    """Return what the chunk index says.

    Args:
        summary: the summary.
        at: where in it each chunk index record begins, without opcode and length [c].
        lengths: of the records, bytes [c].
        end: where in the file the data end.

    Raises:
        DamagedError: a record is malformed or points beyond the data.
        ExceedsError: a chunk is larger than any.
    """
    begins, sizes = np.array(at, np.int64), np.array(lengths, np.int64)
    if sizes.size and int(sizes.min()) < _HEAD.itemsize + _MIDDLE.itemsize + _SIZES.itemsize:
        raise DamagedError("a chunk index is cut off")
    columns = np.zeros((4, len(begins)), np.int64)
    places: dict[int, Places] = {}
    heads = rows_at(summary, begins, _HEAD.itemsize).view(_HEAD).reshape(-1)
    # Records of one form at a time: chunks with messages of as many channels.
    forms = np.stack([sizes, heads["places_bytes"].astype(np.int64)], axis=1)
    for form in np.unique(forms, axis=0):
        which = np.flatnonzero((forms == form).all(axis=1))
        _take(
            rows_at(summary, begins[which], int(form[0])), int(form[1]), end, which, columns, places
        )
    order = np.argsort(columns[0], kind="stable")
    start, length, size, after = columns
    return ChunkTable(start, length, size, after, places, indexed=True).rows(order)


def _take(
    rows: npt.NDArray[np.uint8],
    places_bytes: int,
    data_end: int,
    which: npt.NDArray[np.intp],
    columns: Places,
    places: dict[int, Places],
) -> None:
    """Note what records of one form say.

    Args:
        rows: the records [m, length].
        places_bytes: bytes of the map from channels to places in each of them.
        data_end: where in the file the data end.
        which: numbers of the records among all [m].
        columns: start, length, size and end are written there [4, c].
        places: as those of `ChunkTable`; written to.
    """
    name_bytes = rows.shape[1] - _HEAD.itemsize - places_bytes - _MIDDLE.itemsize - _SIZES.itemsize
    if places_bytes % _PLACE.itemsize or name_bytes < 0:
        raise DamagedError("a chunk index is malformed")
    after = _HEAD.itemsize + places_bytes
    head = _part(rows, 0, _HEAD)
    middle = _part(rows, after, _MIDDLE)
    size = _part(rows, rows.shape[1] - _SIZES.itemsize, _SIZES)["size"]
    if (middle["name_bytes"] != name_bytes).any():
        raise DamagedError("a chunk index is malformed")
    if (size > MAX_CHUNK_BYTES).any():
        where = int(head["start"][(size > MAX_CHUNK_BYTES).argmax()])
        raise ExceedsError(
            f"the chunk at byte {where} would have more than {MAX_CHUNK_BYTES} bytes"
        )
    # Each alone first, so that no sum is beyond 64 bits.
    parts = (head["start"], head["length"], middle["index_length"])
    if any((part > data_end).any() for part in parts) or (head["length"] < RECORD.size).any():
        raise DamagedError("the index points beyond the data")
    start, length, index_length = (part.astype(np.int64) for part in parts)
    chunk_end = start + length
    if (chunk_end + index_length > data_end).any():
        raise DamagedError("the index points beyond the data")
    columns[:, which] = (
        start + RECORD.size,
        length - RECORD.size,
        size.astype(np.int64),
        chunk_end + index_length,
    )
    for number in range(places_bytes // _PLACE.itemsize):
        pair = _part(rows, _HEAD.itemsize + number * _PLACE.itemsize, _PLACE)
        if (pair["place"] >= data_end).any() or (pair["place"] < chunk_end).any():
            raise DamagedError("the index points beyond the data")
        for channel in np.unique(pair["channel"]).tolist():
            of_it = pair["channel"] == channel
            column = places.setdefault(channel, np.zeros(columns.shape[1], np.int64))
            column[which[of_it]] = pair["place"][of_it].astype(np.int64)


def _part(rows: npt.NDArray[np.uint8], at: int, dtype: np.dtype[np.void]) -> npt.NDArray[np.void]:
    """Return one part of each record [m]."""
    return np.ascontiguousarray(rows[:, at : at + dtype.itemsize]).view(dtype).reshape(-1)
