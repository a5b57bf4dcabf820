"""Makes images for Foxglove of the pictures that a recording holds, as they are: compressed."""

from __future__ import annotations

from collections.abc import Iterator

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from study.errors import RecordingError
from study.events.shell import PicturesTaken
from study.foxglove.scene_builder import SceneMessage
from study.recording.pictures import pictures_in
from study.recording.wire import decode


def camera_topic(robot: int) -> str:
    """Return the topic of a robot's images; robots count from 0, topics as on the screen."""
    return f"camera/robot_{robot + 1}"


def images(log_time_ns: int, data: bytes) -> Iterator[SceneMessage]:
    """Yield an image of each robot that a record of pictures holds one of."""
    try:
        record = decode(PicturesTaken.topic, data)
    except RecordingError:
        return
    if not isinstance(record, PicturesTaken):
        return
    for robot, picture in (pictures_in(record) or {}).items():
        topic = camera_topic(robot)
        image = CompressedImage(frame_id=topic, data=picture, format=record.encoding)
        image.timestamp.FromNanoseconds(log_time_ns)
        yield SceneMessage(topic, log_time_ns, image.SerializeToString())
