"""What every recording begins with: identity, attachments, channels and a first record."""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from study.events.fields import record_types
from study.events.shell import Note
from study.recording.descriptors import descriptor_set, message_name
from study.recording.identity import (
    ATTACHMENT_DIGEST,
    CHANNELS,
    FORMAT_VERSION,
    PROFILE,
    SELF_DIGEST,
    metadata_digest,
)
from study.recording.wire import encode

LIBRARY = "scaled-autonomy"

_MEDIA_TYPES = {".json": "application/json", ".safetensors": "application/octet-stream"}


def channel_numbers() -> dict[str, int]:
    """Return the MCAP channel of every topic: numbered from 1 in order of topic."""
    return {topic: number for number, topic in enumerate(record_types(), start=1)}


def opening_payload(
    path: Path, attachments: Mapping[str, bytes], metadata: Mapping[str, str], log_time_ns: int
) -> bytes:
    """Return the OPEN frame's payload for a new recording, see `study.recording.writer`.

    Args:
        path: the final path.
        attachments: name to contents.
        metadata: what the caller wants known; the format's own entries are added.
        log_time_ns: now, nanoseconds since 1970, UTC.
    """
    known = {
        **metadata,
        "format_version": str(FORMAT_VERSION),
        CHANNELS: json.dumps(list(channel_numbers())),
        **{
            f"{ATTACHMENT_DIGEST}{name}": hashlib.sha256(data).hexdigest()
            for name, data in attachments.items()
        },
    }
    opening = {
        "path": str(path),
        "profile": PROFILE,
        "library": LIBRARY,
        "metadata_name": PROFILE,
        "metadata": {**known, SELF_DIGEST: metadata_digest(known)},
        "attachments": [
            {
                "name": name,
                "media_type": _MEDIA_TYPES.get(Path(name).suffix, "text/plain"),
                "data": base64.b64encode(data).decode(),
            }
            for name, data in attachments.items()
        ],
        "channels": [
            {
                "topic": topic,
                "schema": message_name(record_type),
                "descriptor": base64.b64encode(descriptor_set(topic)).decode(),
            }
            for topic, record_type in record_types().items()
        ],
        "start": {
            "channel": channel_numbers()[Note.topic],
            "log_time": log_time_ns,
            "data": base64.b64encode(encode(Note(t_ns=0, text="recording opened"))).decode(),
        },
    }
    return json.dumps(opening).encode()
