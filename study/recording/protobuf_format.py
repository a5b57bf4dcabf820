"""Protobuf's wire format, as far as declared records need it."""

from __future__ import annotations

from typing import Any

import numpy as np

from study.events.fields import Kind, Wire

VARINT, FIXED64, LENGTH_DELIMITED, FIXED32 = 0, 1, 2, 5
WIRE_TYPES: dict[Kind, int] = {
    "fixed64": FIXED64,
    "sfixed32": FIXED32,
    "double": FIXED64,
    "bool": VARINT,
    "string": LENGTH_DELIMITED,
    "bytes": LENGTH_DELIMITED,
    "floats": LENGTH_DELIMITED,
    "doubles": LENGTH_DELIMITED,
    "ints": LENGTH_DELIMITED,
    "strings": LENGTH_DELIMITED,
}
ARRAY_DTYPES: dict[Kind, np.dtype[Any]] = {
    "floats": np.dtype("<f4"),
    "doubles": np.dtype("<f8"),
    "ints": np.dtype("<i4"),
}


def scan_fields(view: memoryview) -> list[tuple[int, int, int, int]]:
    """Split a message into fields: number, wire type, start and end of each value.

    Raises:
        ValueError: the bytes are no protobuf message.
    """
    found = []
    position, size = 0, len(view)
    while position < size:
        tag = view[position]
        position += 1
        if tag > 0x7F:
            tag, position = _read_varint(view, position - 1)
        wire_type = tag & 7
        if wire_type == LENGTH_DELIMITED:
            length, position = _read_varint(view, position)
            end = position + length
        elif wire_type == FIXED64:
            end = position + 8
        elif wire_type == FIXED32:
            end = position + 4
        elif wire_type == VARINT:
            _, end = _read_varint(view, position)
        else:
            raise ValueError(f"unknown wire type {wire_type}")
        if end > size:
            raise ValueError("a field reaches beyond the end")
        found.append((tag >> 3, wire_type, position, end))
        position = end
    return found


def varint(number: int) -> bytes:
    """Encode a non-negative whole number, seven bits a byte, lowest first."""
    encoded = bytearray()
    while number > 0x7F:
        encoded.append(number & 0x7F | 0x80)
        number >>= 7
    encoded.append(number)
    return bytes(encoded)


def field_tag(wire: Wire) -> bytes:
    """Return the bytes that stand before a field's value (and its length, if it has one)."""
    return varint(wire.number << 3 | WIRE_TYPES[wire.kind])


def array_shape(wire: Wire, size: int, robots: int) -> tuple[int, ...]:
    """Return the shape in which an array of `size` numbers is handed out.

    Args:
        wire: the array's declaration.
        size: how many numbers it holds.
        robots: the record's ``robots``; used where the declared shape speaks of n.

    Raises:
        ValueError: the size does not fit the declared shape.
    """
    if wire.shape == "n,d":
        if robots == 0 and size == 0:
            return (0, 0)
        if robots <= 0 or size % robots:
            raise ValueError(f"{size} numbers do not fit {robots} robots")
        return (robots, size // robots)
    fits = {"n": size == robots, "n or 0": size in (0, robots)}
    if not fits.get(wire.shape, True):
        raise ValueError(f"{size} numbers do not fit {robots} robots")
    return (size,)


def _read_varint(view: memoryview, position: int) -> tuple[int, int]:
    number = shift = 0
    while True:
        byte = view[position]
        position += 1
        number |= (byte & 0x7F) << shift
        if byte < 0x80:
            return number, position
        shift += 7
        if shift > 63:
            raise ValueError("a number of more than ten bytes")
