from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from hypothesis import given, settings
from hypothesis import strategies as st

from record_strategies import any_record, records_of
from study.errors import RecordingError
from study.events.events import Timestep
from study.events.fields import Record, record_types, wire_fields
from study.events.inputs import KeyChanged
from study.recording.columns import ColumnBuilder
from study.recording.descriptors import descriptor_set, golden_schema, message_name
from study.recording.protobuf_format import ARRAY_DTYPES, varint
from study.recording.wire import decode, encode

GOLDEN = Path(__file__).parent / "golden" / "schema_v1.json"
TOPICS = list(record_types())


def protobuf_message(topic: str) -> Any:
    pool = descriptor_pool.DescriptorPool()
    for file in descriptor_pb2.FileDescriptorSet.FromString(descriptor_set(topic)).file:
        pool.Add(file)
    found = pool.FindMessageTypeByName(message_name(record_types()[topic]))
    return message_factory.GetMessageClass(found)()


def timestep(robots: int = 3, **changes: Any) -> Timestep:
    plain = Timestep(
        t_ns=5,
        due_ns=4,
        trial_id=1,
        timestep=2,
        robots=robots,
        operated=-1,
        choice_source=0,
        choice_flag=0,
        states=np.arange(robots * 4, dtype=np.float32).reshape(robots, 4),
        actions=np.zeros(robots, np.int32),
        action_sources=np.zeros(robots, np.int32),
        rewards=np.ones(robots, np.float32),
        outcomes=np.zeros(robots, np.int32),
        available=np.ones(robots, np.int32),
        scores=np.zeros(0),
    )
    return dataclasses.replace(plain, **changes)


@pytest.mark.parametrize("topic", TOPICS)
@settings(max_examples=25)
@given(data=st.data())
def test_bytes_are_those_of_protobuf(topic: str, data: st.DataObject) -> None:
    """Our encoder gives what protobuf's deterministic serialization gives."""
    record = data.draw(records_of(record_types()[topic]))
    message = protobuf_message(topic)
    for name, wire in wire_fields(type(record)).items():
        value = getattr(record, name)
        if wire.kind in ARRAY_DTYPES:
            getattr(message, name).extend(value.ravel().tolist())
        elif wire.kind == "strings":
            getattr(message, name).extend(value)
        else:
            setattr(message, name, value)
    assert encode(record) == message.SerializeToString(deterministic=True)


@settings(max_examples=200)
@given(record=any_record())
def test_round_trip(record: Record) -> None:
    """A decoded record has the fields, dtypes and shapes of the one encoded, bit for bit."""
    again = decode(record.topic, encode(record))
    assert type(again) is type(record)
    for name, wire in wire_fields(type(record)).items():
        given_value, value = getattr(record, name), getattr(again, name)
        if wire.kind in ARRAY_DTYPES:
            assert (value.dtype, value.shape) == (given_value.dtype, given_value.shape)
            assert value.tobytes() == given_value.tobytes()
        elif wire.kind == "double":
            assert np.float64(value).tobytes() == np.float64(given_value).tobytes()
        else:
            assert type(value) is type(given_value)
            assert value == given_value


@settings(max_examples=60)
@given(topic=st.sampled_from(TOPICS), data=st.data())
def test_columns_equal_decoded_records(topic: str, data: st.DataObject) -> None:
    """Columns hold, row by row, what decoding each record gives."""
    records = data.draw(st.lists(records_of(record_types()[topic]), max_size=6))
    # Repeats make runs of more than one row.
    encoded = [encode(record) for record in records for _ in range(2)]
    length = np.array([len(item) for item in encoded], np.int64)
    builder = ColumnBuilder(topic)
    if encoded:
        builder.add(
            b"".join(encoded),
            np.arange(len(encoded), dtype=np.uint32),
            np.arange(len(encoded), dtype=np.uint64),
            np.cumsum(length) - length,
            length,
        )
    rows = 0
    for columns in builder.finish():
        for row, number in enumerate(columns["sequence"].tolist()):
            assert number == rows
            expected = decode(topic, encoded[number])
            for name in wire_fields(type(expected)):
                value, wanted = columns[name][row], getattr(expected, name)
                if isinstance(wanted, np.ndarray | float):
                    np.testing.assert_array_equal(value, wanted)
                else:
                    assert value == wanted
            rows += 1
    assert rows == len(encoded)


def test_columns_of_equal_fleets_are_one_run() -> None:
    """Thousands of timesteps of one fleet become one dictionary with [rows, n, d] states."""
    encoded = [encode(timestep(12, t_ns=i, timestep=i)) for i in range(3000)]
    length = np.array([len(item) for item in encoded], np.int64)
    numbers = np.arange(3000)
    builder = ColumnBuilder("event/timestep")
    builder.add(
        b"".join(encoded),
        numbers.astype(np.uint32),
        numbers.astype(np.uint64),
        np.cumsum(length) - length,
        length,
    )
    (columns,) = builder.finish()
    assert columns["states"].shape == (3000, 12, 4)
    assert columns["scores"].shape == (3000, 0)
    assert columns["timestep"].tolist() == list(range(3000))


@pytest.mark.parametrize(
    ("changes", "error", "names"),
    [
        ({"t_ns": -1}, ValueError, "Timestep.t_ns"),
        ({"t_ns": 2**64}, ValueError, "Timestep.t_ns"),
        ({"t_ns": 1.0}, TypeError, "Timestep.t_ns"),
        ({"timestep": 2**31}, ValueError, "Timestep.timestep"),
        ({"timestep": True}, TypeError, "Timestep.timestep"),
        ({"states": np.zeros((3, 4))}, TypeError, "Timestep.states"),
        ({"states": np.zeros((2, 4), np.float32)}, ValueError, "Timestep.states"),
        ({"states": np.zeros(12, np.float32)}, ValueError, "Timestep.states"),
        ({"states": [[0.0] * 4] * 3}, TypeError, "Timestep.states"),
        ({"actions": np.zeros(2, np.int32)}, ValueError, "Timestep.actions"),
        ({"actions": np.zeros(3, np.int64)}, TypeError, "Timestep.actions"),
        ({"scores": np.zeros(2)}, ValueError, "Timestep.scores"),
    ],
)
def test_wrong_fields_are_refused(
    changes: dict[str, Any], error: type[Exception], names: str
) -> None:
    """A field of the wrong type, range or shape is refused, and the message names it."""
    with pytest.raises(error, match=names):
        encode(timestep(**changes))


def test_text_must_be_unicode() -> None:
    """A lone surrogate cannot be written, so it is refused before anything is."""
    with pytest.raises(ValueError, match=r"KeyChanged\.key"):
        encode(KeyChanged(t_ns=0, key="\ud800", down=True, poll_gap_ns=0))


def test_missing_fields_are_zero_and_unknown_ones_ignored() -> None:
    """Files of other versions within a format can be read."""
    record = decode("event/timestep", varint(100 << 3 | 2) + b"\x03abc")
    assert isinstance(record, Timestep)
    assert (record.t_ns, record.robots, record.states.shape) == (0, 0, (0, 0))


@settings(max_examples=300)
@given(topic=st.sampled_from(TOPICS), data=st.binary(max_size=80))
def test_noise_is_a_recording_error(topic: str, data: bytes) -> None:
    """Whatever the bytes are, decoding gives a record or a RecordingError."""
    try:
        record = decode(topic, data)
    except RecordingError:
        return
    assert type(record) is record_types()[topic]


def test_schema_is_the_golden_one() -> None:
    """Numbers and kinds are part of the format; add new fields to the golden file by hand."""
    assert golden_schema() == json.loads(GOLDEN.read_text())
