"""Many records of one topic as arrays: one `numpy.frombuffer` for a run of equal layout.

A record of fixed-size scalars and packed arrays has a layout that depends on its array
lengths only. Two messages share it exactly if they are equally long and their tags and
lengths, all bytes that are no values, are equal; those are compared, thousands at a time.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

from study.errors import RecordingError
from study.events.fields import Kind, Record, Wire, wire_fields
from study.recording.growing import Growing, growing_fields
from study.recording.mcap_chunks import rows_at
from study.recording.protobuf_format import (
    ARRAY_DTYPES,
    VARINT,
    WIRE_TYPES,
    array_shape,
    scan_fields,
)
from study.recording.wire import decode, record_types_by_topic

_SCALAR_DTYPES: dict[Kind, np.dtype[Any]] = {
    "fixed64": np.dtype("<u8"),
    "sfixed32": np.dtype("<i4"),
    "double": np.dtype("<f8"),
    "bool": np.dtype("?"),
}

Columns = dict[str, npt.NDArray[Any]]


@dataclasses.dataclass(frozen=True, slots=True)
class _Layout:
    """Where the values of equally built messages are.

    Attributes:
        length: of one message, bytes.
        dtype: the fields present, at their places.
        shapes: the shape of each array field present.
        absent: the fields that are not there, zero by definition, with their shapes.
        fixed: places of the bytes that make the layout: tags, lengths, number of robots.
        pattern: the values of those bytes.
    """

    length: int
    dtype: np.dtype[Any]
    shapes: dict[str, tuple[int, ...]]
    absent: dict[str, tuple[np.dtype[Any], tuple[int, ...]]]
    fixed: npt.NDArray[np.intp]
    pattern: npt.NDArray[np.uint8]


@dataclasses.dataclass(slots=True)
class _Run:
    """Consecutive messages of one layout, or (without one) decoded records of one shape."""

    layout: _Layout | None
    shapes: tuple[tuple[int, ...], ...] = ()
    fields: dict[str, Growing] = dataclasses.field(default_factory=dict)
    records: list[Record] = dataclasses.field(default_factory=list)
    sequence: list[npt.NDArray[np.uint32]] = dataclasses.field(default_factory=list)
    log_time_ns: list[npt.NDArray[np.uint64]] = dataclasses.field(default_factory=list)


class ColumnBuilder:
    """Collects the messages of one topic and turns them into columns.

    Args:
        topic: a declared topic.
        expected: messages that will come, about; 0 if that is not known.
    """

    def __init__(self, topic: str, expected: int = 0) -> None:
        self._topic = topic
        self._expected = expected
        self._fields = wire_fields(record_types_by_topic()[topic])
        self._by_number = {wire.number: (name, wire) for name, wire in self._fields.items()}
        # A topic that holds text has no fixed layout, whatever its lengths.
        self._numbers_only = all(
            wire.kind in _SCALAR_DTYPES or wire.kind in ARRAY_DTYPES
            for wire in self._fields.values()
        )
        self._runs: list[_Run] = []

    def add(
        self,
        data: bytes | memoryview,
        sequence: npt.NDArray[np.uint32],
        log_time_ns: npt.NDArray[np.uint64],
        start: npt.NDArray[np.int64],
        length: npt.NDArray[np.int64],
    ) -> None:
        """Add messages, in order.

        Args:
            data: the uncompressed chunk.
            sequence: [m].
            log_time_ns: [m].
            start: place of each message in `data`, [m].
            length: of each message, [m].
        """
        changes = np.flatnonzero(np.diff(length)) + 1
        for first, last in zip(
            [0, *changes.tolist()], [*changes.tolist(), len(start)], strict=True
        ):
            rows = slice(first, last)
            gathered = _rows(data, start[rows], int(length[first]))
            self._add_rows(gathered, sequence[rows], log_time_ns[rows])

    def finish(self) -> list[Columns]:
        """Return one dictionary for each run."""
        return [
            {
                "sequence": np.concatenate(run.sequence),
                "log_time_ns": np.concatenate(run.log_time_ns),
                **(self._decoded(run) if run.layout is None else _gathered(run, run.layout)),
            }
            for run in self._runs
        ]

    def _add_rows(
        self,
        rows: npt.NDArray[np.uint8],
        sequence: npt.NDArray[np.uint32],
        log_time_ns: npt.NDArray[np.uint64],
    ) -> None:
        """Add equally long messages, [m, length], to the current run or to new ones."""
        while len(rows):
            run = self._runs[-1] if self._runs else None
            layout = None if run is None else run.layout
            if run is None or layout is None or not _fits(rows[0], layout):
                layout = self._layout(rows[0])
                run = self._new_run(layout)
            count = 1
            if layout is None:
                record = decode(self._topic, rows[0].tobytes())
                run = self._decoded_run(record)
                run.records.append(record)
            else:
                differs = (rows[:, layout.fixed] != layout.pattern).any(axis=1)
                count = int(differs.argmax()) if differs.any() else len(rows)
                table = rows[:count].view(layout.dtype).reshape(-1)
                for name, column in run.fields.items():
                    column.extend(table[name])
            if not self._runs or run is not self._runs[-1]:
                self._runs.append(run)
            run.sequence.append(sequence[:count])
            run.log_time_ns.append(log_time_ns[:count])
            rows, sequence, log_time_ns = rows[count:], sequence[count:], log_time_ns[count:]

    def _new_run(self, layout: _Layout | None) -> _Run:
        if layout is None:
            return _Run(None)
        left = self._expected - sum(len(part) for run in self._runs for part in run.sequence)
        return _Run(layout, fields=growing_fields(layout.dtype, left))

    def _decoded_run(self, record: Record) -> _Run:
        """Return the run of decoded records that a record continues, or a new one."""
        shapes = tuple(
            getattr(record, name).shape
            for name, wire in self._fields.items()
            if wire.kind in ARRAY_DTYPES
        )
        current = self._runs[-1] if self._runs else None
        if current is not None and current.layout is None and current.shapes == shapes:
            return current
        return _Run(None, shapes)

    def _layout(self, row: npt.NDArray[np.uint8]) -> _Layout | None:
        """Return the layout of a message; None if it has text, or fields that are unknown."""
        if not self._numbers_only:
            return None
        message = row.tobytes()
        places: dict[str, tuple[Wire, int, int]] = {}
        try:
            for number, wire_type, start, end in scan_fields(memoryview(message)):
                name, wire = self._by_number.get(number, ("", None))
                if wire is None or name in places or wire_type != WIRE_TYPES[wire.kind]:
                    return None
                if wire_type == VARINT and message[start:end] not in {b"\x00", b"\x01"}:
                    return None
                places[name] = (wire, start, end)
        except (ValueError, IndexError):
            return None
        return self._layout_of(message, places)

    def _layout_of(self, message: bytes, places: dict[str, tuple[Wire, int, int]]) -> _Layout:
        fixed = np.ones(len(message), bool)
        robots = 0
        if "robots" in places:
            _, start, end = places["robots"]
            robots = int.from_bytes(message[start:end], "little", signed=True)
        formats: dict[str, tuple[np.dtype[Any], tuple[int, ...]]] = {}
        shapes: dict[str, tuple[int, ...]] = {}
        absent: dict[str, tuple[np.dtype[Any], tuple[int, ...]]] = {}
        for name, wire in self._fields.items():
            _, start, end = places.get(name, (wire, 0, 0))
            scalar = _SCALAR_DTYPES.get(wire.kind)
            dtype = ARRAY_DTYPES[wire.kind] if scalar is None else scalar
            try:
                count, left_over = divmod(end - start, dtype.itemsize)
                if left_over:
                    raise ValueError(f"{end - start} bytes are no whole numbers")
                shape = () if scalar is not None else array_shape(wire, count, robots)
            except ValueError as error:
                raise RecordingError(f"a record of {self._topic}: {name}: {error}") from error
            if name not in places:
                absent[name] = (dtype, shape)
                continue
            formats[name] = (dtype, () if scalar is not None else (count,))
            shapes[name] = shape
            # The number of robots shapes the arrays, so it is part of the layout.
            fixed[start:end] = name == "robots"
        structured = np.dtype(
            {
                "names": list(formats),
                "formats": list(formats.values()),
                "offsets": [places[name][1] for name in formats],
                "itemsize": len(message),
            }
        )
        where = np.flatnonzero(fixed)
        pattern = np.frombuffer(message, np.uint8)[where]
        return _Layout(len(message), structured, shapes, absent, where, pattern)

    def _decoded(self, run: _Run) -> Columns:
        columns: Columns = {}
        for name, wire in self._fields.items():
            values = [getattr(record, name) for record in run.records]
            if wire.kind in ARRAY_DTYPES:
                columns[name] = np.stack(values)
            elif wire.kind in _SCALAR_DTYPES:
                columns[name] = np.array(values, _SCALAR_DTYPES[wire.kind])
            else:
                columns[name] = np.empty(len(values), object)
                columns[name][:] = values
        return columns


def _rows(
    data: bytes | memoryview, places: npt.NDArray[np.int64], size: int
) -> npt.NDArray[np.uint8]:
    """Return `size` bytes from each of the places, uint8 [m, size]; copied if need be."""
    steps = np.diff(places)
    if not steps.size or (steps != steps[0]).any() or steps[0] < size:
        return rows_at(data, places, size)
    # Equally far from one another, as messages of one topic mostly are.
    shape, strides = (len(places), size), (int(steps[0]), 1)
    return np.ndarray(shape, np.uint8, data, int(places[0]), strides)


def _fits(row: npt.NDArray[np.uint8], layout: _Layout) -> bool:
    return layout.length == len(row) and bool((row[layout.fixed] == layout.pattern).all())


def _gathered(run: _Run, layout: _Layout) -> Columns:
    rows = sum(map(len, run.sequence))
    columns: Columns = {
        name: run.fields[name].array().reshape(rows, *shape)
        for name, shape in layout.shapes.items()
    }
    for name, (dtype, shape) in layout.absent.items():
        columns[name] = np.zeros((rows, *shape), dtype)
    return columns
