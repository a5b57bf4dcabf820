"""Descriptors of Foxglove's own message types, as MCAP files and its live protocol carry them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf import descriptor_pb2
from google.protobuf.message import Message

from study.events.fields import record_types
from study.recording.descriptors import descriptor_set, message_name

MAP_TOPIC = "scene/map"
ROBOTS_TOPIC = "scene/robots"
POSES_TOPIC = "scene/poses"
TRANSFORMS_TOPIC = "scene/transforms"
LOG_TOPIC = "scene/log"

SCENE_TYPES: dict[str, type[Message]] = {
    MAP_TOPIC: SceneUpdate,
    ROBOTS_TOPIC: SceneUpdate,
    POSES_TOPIC: PosesInFrame,
    TRANSFORMS_TOPIC: FrameTransforms,
    LOG_TOPIC: Log,
}
"""What is made of a recording for Foxglove: topic to message type."""


def schema_name(topic: str) -> str:
    """Return the full protobuf name of a scene topic's messages: ``foxglove.SceneUpdate``."""
    return SCENE_TYPES[topic].DESCRIPTOR.full_name


@cache
def schema_descriptors(topic: str) -> bytes:
    """Return the serialized ``FileDescriptorSet`` of a scene topic, what it imports first."""
    return descriptors_of(SCENE_TYPES[topic])


def descriptors_of(message_type: type[Message]) -> bytes:
    """Return the serialized ``FileDescriptorSet`` of a message type, what it imports first."""
    files: dict[str, Any] = {}

    # Any: the classes of protobuf's compiled and pure implementations have no common name.
    def add(file: Any) -> None:  # noqa: ANN401
        for imported in file.dependencies:
            if imported.name not in files:
                add(imported)
        files[file.name] = file

    add(message_type.DESCRIPTOR.file)
    found = descriptor_pb2.FileDescriptorSet()
    for file in files.values():
        file.CopyToProto(found.file.add())
    return found.SerializeToString(deterministic=True)


def every_schema() -> Iterator[tuple[str, str, bytes]]:
    """Yield topic, schema name and descriptors: those of recordings, then those made of them.

    Schemas are those of this program. A recording's own may lack fields added since, and have no
    others: numbers are never reused.
    """
    for topic, record_type in record_types().items():
        yield topic, message_name(record_type), descriptor_set(topic)
    for topic in SCENE_TYPES:
        yield topic, schema_name(topic), schema_descriptors(topic)
