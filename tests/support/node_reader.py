"""The independent reader: Node with the packages of MCAP and protobuf, and nothing of ours."""

from __future__ import annotations

import hashlib
import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np

from node_packages import install_packages
from patience import PATIENCE_S
from study.events.fields import Record, Wire, record_types, wire_fields
from study.recording.descriptors import message_name
from study.recording.protobuf_format import ARRAY_DTYPES
from study.recording.reader import Recording
from x11_driver import require_program

FOLDER = Path(__file__).resolve().parents[1] / "independent_reader"


def read_by_node(*paths: Path) -> list[dict[str, Any]]:
    """Return what Node finds in recordings; skip the test where Node is missing."""
    node = require_program("node")
    install_packages(FOLDER)
    command = [node, str(FOLDER / "read_recording.js"), *map(str, paths)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


def facts_of(recording: Recording) -> dict[str, Any]:
    """Return of each topic what Node says of it, by our own reader and from our declarations."""
    return {
        topic: _topic_facts(recording, topic, record_type)
        for topic, record_type in record_types().items()
    }


def _topic_facts(recording: Recording, topic: str, record_type: type[Record]) -> dict[str, Any]:
    rows = list(recording.records(topic))
    times = [raw.log_time_ns for raw in recording.raw() if raw.topic == topic]
    return {
        "schema": message_name(record_type),
        "count": len(rows),
        "sequence": _sha256(sequence.to_bytes(8, "little") for sequence, _ in rows),
        "log_time": _sha256(time_ns.to_bytes(8, "little") for time_ns in times),
        "fields": {
            name: {
                "number": wire.number,
                "sha256": _sha256(canonical(getattr(record, name), wire) for _, record in rows),
            }
            for name, wire in wire_fields(record_type).items()
        },
    }


def _sha256(parts: Any) -> str:
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


def canonical(value: Any, wire: Wire) -> bytes:
    """Return a value's bytes in the form that the program in Node hashes; it says which."""
    if wire.kind in ARRAY_DTYPES:
        numbers = np.ascontiguousarray(value).ravel().astype(ARRAY_DTYPES[wire.kind])
        if numbers.dtype.kind == "f":
            numbers[np.isnan(numbers)] = np.nan
        return _size(numbers.size) + numbers.tobytes()
    if wire.kind == "double":
        return np.array(np.nan if np.isnan(value) else value, "<f8").tobytes()
    if wire.kind == "fixed64":
        return int(value).to_bytes(8, "little")
    if wire.kind == "sfixed32":
        return int(value).to_bytes(4, "little", signed=True)
    if wire.kind == "bool":
        return bytes([bool(value)])
    if wire.kind == "strings":
        return _size(len(value)) + b"".join(_sized(text.encode()) for text in value)
    return _sized(value if wire.kind == "bytes" else value.encode())


def _size(count: int) -> bytes:
    return count.to_bytes(4, "little")


def _sized(data: bytes) -> bytes:
    return _size(len(data)) + data
