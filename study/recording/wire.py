"""Records to bytes and back, in protobuf's wire format.

The declarations need ten kinds of field only, so a record is written field by field in
order of number, without a protobuf object between: the bytes equal those of protobuf's
deterministic serialization (the tests hold that for every record type). A record made of
fixed-size scalars and packed arrays then has a layout that depends on its array lengths
alone, which `study.recording.columns` reads thousands at a time.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from study.errors import RecordingError
from study.events.fields import Kind, Record, Wire, record_types, wire_fields
from study.recording.protobuf_format import (
    ARRAY_DTYPES,
    WIRE_TYPES,
    array_shape,
    field_tag,
    scan_fields,
    varint,
)

_SCALARS = {"fixed64": struct.Struct("<Q"), "sfixed32": struct.Struct("<i")}
_DOUBLE = struct.Struct("<d")
_RANGES = {"fixed64": (0, 2**64 - 1), "sfixed32": (-(2**31), 2**31 - 1)}
_ZEROS: dict[Kind, Any] = {
    "fixed64": 0,
    "sfixed32": 0,
    "double": 0.0,
    "bool": False,
    "string": "",
    "bytes": b"",
    "strings": (),
}

_Packer = Callable[[Record], bytes]
_SHORT = [bytes([length]) for length in range(128)]
# Tuples rather than unions: a union is built anew at each call of isinstance.
_WHOLE_NUMBERS = (int, np.integer)
_NUMBERS = (float, int, np.floating)
_TRUTHS = (bool, np.bool_)


def encode(record: Record) -> bytes:
    """Encode a record.

    Raises:
        TypeError: a field holds the wrong type or dtype; the message names both.
        ValueError: a number is out of range, or an array has the wrong shape.
    """
    return b"".join([pack(record) for pack in _packers(record.topic)])


def decode(topic: str, data: bytes | memoryview) -> Record:
    """Decode one message of a topic; arrays are read-only views of `data`.

    Fields that `data` lacks are zero, empty or false; fields unknown here are ignored.

    Args:
        topic: one of ``record_types()``.
        data: what `encode` gave.

    Raises:
        RecordingError: the topic is unknown, or the bytes are no such record.
    """
    record_type = record_types_by_topic().get(topic)
    if record_type is None:
        raise RecordingError(f'no record is declared for the topic "{topic}"')
    fields, values = _fields_by_number(topic), dict(_zero_values(topic))
    view = memoryview(data)
    try:
        for number, wire_type, start, end in scan_fields(view):
            known = fields.get(number)
            if known is None:
                continue
            name, kind, expected = known
            if wire_type != expected:
                raise ValueError(f"field {name} has wire type {wire_type}")
            value = _unpack(kind, view[start:end])
            values[name] = values[name] + value if kind == "strings" else value
        for name, wire in _array_fields(topic):
            flat = values[name]
            values[name] = flat.reshape(array_shape(wire, flat.size, values.get("robots", 0)))
    except (ValueError, struct.error, IndexError) as error:
        raise RecordingError(f"a record of {topic} cannot be decoded: {error}") from error
    make: Callable[..., Record] = record_type
    return make(**values)


@cache
def record_types_by_topic() -> dict[str, type[Record]]:
    """Return ``record_types()``, looked up once."""
    return record_types()


@cache
def _packers(topic: str) -> list[_Packer]:
    record_type = record_types_by_topic()[topic]
    return [_packer(record_type, name, wire) for name, wire in wire_fields(record_type).items()]


@cache
def _fields_by_number(topic: str) -> dict[int, tuple[str, Kind, int]]:
    fields = wire_fields(record_types_by_topic()[topic])
    return {wire.number: (name, wire.kind, WIRE_TYPES[wire.kind]) for name, wire in fields.items()}


@cache
def _array_fields(topic: str) -> list[tuple[str, Wire]]:
    fields = wire_fields(record_types_by_topic()[topic])
    return [(name, wire) for name, wire in fields.items() if wire.kind in ARRAY_DTYPES]


@cache
def _zero_values(topic: str) -> dict[str, Any]:
    """Return what a record holds whose bytes say nothing: the meaning of an absent field."""
    fields = wire_fields(record_types_by_topic()[topic])
    empty = {kind: np.frombuffer(b"", dtype) for kind, dtype in ARRAY_DTYPES.items()}
    return {name: (_ZEROS | empty)[wire.kind] for name, wire in fields.items()}


def _packer(record_type: type[Record], name: str, wire: Wire) -> _Packer:
    """Return the function that checks and encodes one field of a record."""
    where = f"{record_type.__name__}.{name}"
    tag = field_tag(wire)

    def integer(record: Record) -> bytes:
        value = getattr(record, name)
        if type(value) is not int and (
            not isinstance(value, _WHOLE_NUMBERS) or isinstance(value, bool)
        ):
            raise TypeError(f"{where}: a whole number is expected, not {value!r}")
        if not low <= value <= high:
            raise ValueError(f"{where}: {value} is not from {low} to {high}")
        return tag + pack_integer(value)

    def number(record: Record) -> bytes:
        value = getattr(record, name)
        if not isinstance(value, _NUMBERS) or isinstance(value, bool):
            raise TypeError(f"{where}: a number is expected, not {value!r}")
        try:
            return tag + _DOUBLE.pack(value)
        except OverflowError:
            raise ValueError(f"{where}: {value} is too large for a double") from None

    def truth(record: Record) -> bytes:
        value = getattr(record, name)
        if not isinstance(value, _TRUTHS):
            raise TypeError(f"{where}: true or false is expected, not {value!r}")
        return tag + (b"\x01" if value else b"\x00")

    def text(record: Record) -> bytes:
        return delimited(_utf8(where, getattr(record, name)))

    def texts(record: Record) -> bytes:
        value = getattr(record, name)
        if not isinstance(value, tuple):
            raise TypeError(f"{where}: a tuple of text is expected, not {value!r}")
        return b"".join([delimited(_utf8(where, item)) for item in value])

    def opaque(record: Record) -> bytes:
        value = getattr(record, name)
        if not isinstance(value, bytes):
            raise TypeError(f"{where}: bytes are expected, not {type(value).__name__}")
        return delimited(value)

    def array(record: Record) -> bytes:
        value = getattr(record, name)
        if not isinstance(value, np.ndarray):
            raise TypeError(f"{where}: an array is expected, not {type(value).__name__}")
        if value.dtype != dtype:
            raise TypeError(f"{where}: dtype {dtype.name} is expected, not {value.dtype}")
        robots = getattr(record, "robots", 0)
        if not (
            (value.ndim in ranks and (not per_robot or len(value) == robots))
            or (may_be_empty and value.size == 0)
        ):
            given = f" with {robots} robots" if per_robot else ""
            raise ValueError(
                f"{where}: shape [{wire.shape}] is expected{given}, not {list(value.shape)}"
            )
        return delimited(value.tobytes()) if value.size else b""

    def delimited(value: bytes) -> bytes:
        length = len(value)
        return tag + (_SHORT[length] if length < 128 else varint(length)) + value

    if wire.kind in _SCALARS:
        low, high = _RANGES[wire.kind]
        pack_integer = _SCALARS[wire.kind].pack
        return integer
    if wire.kind in ARRAY_DTYPES:
        dtype = ARRAY_DTYPES[wire.kind]
        axes = wire.shape.removesuffix(" or 0").split(",")
        may_be_empty = wire.shape.endswith(" or 0")
        per_robot = axes[0] == "n"
        # `decode` hands arrays of three and more axes out flat, so flat is accepted too.
        ranks = (1, len(axes)) if len(axes) > 2 else (len(axes),)
        return array
    packers: dict[str, _Packer] = {
        "double": number,
        "bool": truth,
        "string": text,
        "strings": texts,
        "bytes": opaque,
    }
    return packers[wire.kind]


def _utf8(where: str, value: object) -> bytes:
    if not isinstance(value, str):
        raise TypeError(f"{where}: text is expected, not {value!r}")
    try:
        return value.encode()
    except UnicodeEncodeError as error:
        raise ValueError(f"{where}: {value!r} is no Unicode text: {error.reason}") from None


def _unpack(kind: Kind, value: memoryview) -> Any:  # noqa: ANN401 - a value of its kind
    dtype = ARRAY_DTYPES.get(kind)
    if dtype is not None:
        return np.frombuffer(value, dtype)
    scalar = _SCALARS.get(kind)
    if scalar is not None:
        return scalar.unpack(value)[0]
    if kind == "double":
        return _DOUBLE.unpack(value)[0]
    if kind == "bool":
        return any(byte & 0x7F for byte in value)
    if kind == "bytes":
        return bytes(value)
    text = str(value, "utf-8")
    return text if kind == "string" else (text,)
