"""Writes a session anew for Foxglove: its own messages, and scene messages made of them."""

from __future__ import annotations

import dataclasses
import importlib.metadata
from collections.abc import Callable
from pathlib import Path

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from mcap.writer import Writer

from study.errors import RecordingError, StudyError
from study.events.shell import PicturesTaken
from study.foxglove.camera_images import images
from study.foxglove.scene_builder import SceneBuilder
from study.foxglove.schemas import descriptors_of, every_schema
from study.recording.durable_file import DurableFile
from study.recording.exported import EXPORT_PROFILE, EXPORTED_FROM, PARTICIPANT, STUDY
from study.recording.parts import SessionRecording, read_session
from study.toml_text import parse_toml

_CHUNK_BYTES = 1 << 20
_REPORT_EVERY = 1000


@dataclasses.dataclass(frozen=True, slots=True)
class Exported:
    """What an export gave.

    Attributes:
        path: the new file.
        records: number of the session's own messages in it.
        scene_messages: number of messages made for Foxglove.
        unknown_records: messages left out, since their topics are declared nowhere here.
        without_scene: in words, why there is no scene; empty if there is one.
        problems: in words, what of the session was missing or could not be read.
    """

    path: Path
    records: int
    scene_messages: int
    unknown_records: int
    without_scene: str
    problems: tuple[str, ...]


def export(
    source: Path,
    target: Path,
    rate_hz: float,
    progress: Callable[[int, int], object] | None = None,
) -> Exported:
    """Write a session, with all its parts, and its scene into a new file.

    Args:
        source: one of the session's files, whole or damaged; only read.
        target: the new file, ``*.mcap``; it must not exist. Readable by its owner only.
        rate_hz: scene messages a second, at most.
        progress: told now and then how many records are done, of how many.

    Raises:
        RecordingError: the source is no recording of ours, or the target cannot be written.
    """
    session = read_session(source)
    try:
        target.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        file = DurableFile(target)
    except FileExistsError as error:
        raise RecordingError(
            f"{error.filename} exists already", "Choose another name with --output."
        ) from error
    except OSError as error:
        raise _unwritable(target, error) from error
    try:
        done = _write(file, session, rate_hz, progress)
        return dataclasses.replace(done, path=file.publish())
    except OSError as error:
        file.discard()
        raise _unwritable(target, error) from error
    except BaseException:
        file.discard()
        raise


def _unwritable(target: Path, error: OSError) -> RecordingError:
    return RecordingError(f"{target} cannot be written: {error.strerror}", "Choose another place.")


def _whose(session: SessionRecording) -> dict[str, str]:
    """Return study and participant, by which withdrawal finds the export."""
    participant = session.metadata.get("participant", "")
    try:
        toml = session.attachments.get("protocol.toml", b"").decode()
        study = parse_toml(toml, session.path.name).get("study", {}).get("name", "")
    except (StudyError, UnicodeDecodeError, AttributeError):
        return {}
    return {STUDY: str(study), PARTICIPANT: participant}


def _write(
    file: DurableFile,
    session: SessionRecording,
    rate_hz: float,
    progress: Callable[[int, int], object] | None,
) -> Exported:
    writer = Writer(file, chunk_size=_CHUNK_BYTES, enable_data_crcs=True)  # type: ignore[arg-type]
    version = importlib.metadata.version("scaled-autonomy")
    writer.start(EXPORT_PROFILE, f"scaled-autonomy {version}")
    writer.add_metadata(
        EXPORT_PROFILE,
        {
            "session_id": session.session_id,
            **_whose(session),
            EXPORTED_FROM: ", ".join(part.path.name for part in session.parts),
            "exported_from_sha256": session.sha256,
            "scene_rate_hz": f"{rate_hz:g}",
        },
    )
    for name, data in session.attachments.items():
        writer.add_attachment(0, 0, name, "text/plain", data)
    channels = _register(writer)
    builder = SceneBuilder(rate_hz)
    total = sum(len(part.sequences) for part in session.parts)
    records = scenes = unknown = 0
    for place, raw in enumerate(session.raw()):
        if progress and place % _REPORT_EVERY == 0:
            progress(place, total)
        channel = channels.get(raw.topic)
        if channel is None:
            unknown += 1
            continue
        records += 1
        writer.add_message(channel, raw.log_time_ns, raw.data, raw.log_time_ns, raw.sequence)
        for made in builder.take(raw.topic, raw.log_time_ns, raw.data):
            scenes += 1
            time_ns = made.log_time_ns
            writer.add_message(channels[made.topic], time_ns, made.data, time_ns, scenes)
        if raw.topic != PicturesTaken.topic:
            continue
        for made in images(raw.log_time_ns, raw.data):
            # A topic for each robot that shows something, and none where there are no pictures.
            if made.topic not in channels:
                channels[made.topic] = _image_channel(writer, made.topic)
            scenes += 1
            time_ns = made.log_time_ns
            writer.add_message(channels[made.topic], time_ns, made.data, time_ns, scenes)
    writer.finish()  # type: ignore[no-untyped-call]
    if progress:
        progress(total, total)
    return Exported(
        path=file.final_path,
        records=records,
        scene_messages=scenes,
        unknown_records=unknown,
        without_scene=builder.without_scene if records else "",
        problems=session.problems,
    )


def _image_channel(writer: Writer, topic: str) -> int:
    """Declare a topic of images; return its channel."""
    name, descriptors = CompressedImage.DESCRIPTOR.full_name, descriptors_of(CompressedImage)
    schema = writer.register_schema(name, "protobuf", descriptors)
    return writer.register_channel(topic, "protobuf", schema)


def _register(writer: Writer) -> dict[str, int]:
    """Declare every topic; return its channel."""
    channels = {}
    for topic, name, descriptors in every_schema():
        schema = writer.register_schema(name, "protobuf", descriptors)
        channels[topic] = writer.register_channel(topic, "protobuf", schema)
    return channels
