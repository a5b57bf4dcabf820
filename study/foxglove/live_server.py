"""The live view's process: takes records on standard input, serves them to Foxglove.

Started by `study.foxglove.live_tap` as ``python -m study.foxglove.live_server HOST PORT``. It says
one line of JSON on standard output, ``{"port": ...}`` or ``{"error": ...}``, and ends when its
input ends.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sys
import time

import foxglove
from foxglove.websocket import ChannelView, Client, ServerListener

from study.errors import RecordingError
from study.events.events import SessionStarted, StageEntered, TrialStarted
from study.events.inputs import SessionOpened
from study.foxglove.scene_builder import SceneBuilder
from study.foxglove.schemas import MAP_TOPIC, every_schema
from study.recording.framing import FrameKind, FrameSplitter, split_messages
from study.recording.opening import channel_numbers

_READ_SIZE = 1 << 20
_LASTING = (SessionOpened.topic, SessionStarted.topic, StageEntered.topic, TrialStarted.topic)
"""Topics whose last message is still true: who comes later gets it too."""

_NICENESS = 10
_BACKLOG = 256
"""Messages that a viewer may be behind; older ones are dropped."""


class LiveServer(ServerListener):
    """Publishes records and their scene; remembers what those who come later need.

    Args:
        host: address to listen at.
        port: TCP port; 0 for any that is free.

    Raises:
        RuntimeError: it cannot listen there.
    """

    def __init__(self, host: str, port: int) -> None:
        # Kept: channels go with their context.
        self._context = context = foxglove.Context()
        self._channels: dict[str, foxglove.Channel] = {}
        for topic, name, descriptors in every_schema():
            schema = foxglove.Schema(name=name, encoding="protobuf", data=descriptors)
            self._channels[topic] = foxglove.Channel(
                topic, schema=schema, message_encoding="protobuf", context=context
            )
        self._topics = {number: topic for topic, number in channel_numbers().items()}
        self._builder = SceneBuilder()
        self._lasting: dict[str, tuple[int, bytes]] = {}
        self._wanted: set[str] = set()
        self._server = foxglove.start_server(
            name="Scaled Autonomy",
            host=host,
            port=port,
            context=context,
            server_listener=self,
            message_backlog_size=_BACKLOG,
        )

    @property
    def port(self) -> int:
        """TCP port that it listens at."""
        return self._server.port

    def on_subscribe(self, client: Client, channel: ChannelView) -> None:  # noqa: ARG002
        """Note that somebody new listens; called by another thread."""
        self._wanted.add(channel.topic)

    def take(self, payload: bytes) -> None:
        """Publish records, and what they add to the scene."""
        for number, _, log_time_ns, data in split_messages(payload):
            topic = self._topics[number]
            self._channels[topic].log(data, log_time=log_time_ns)
            if topic in _LASTING:
                self._lasting[topic] = (log_time_ns, data)
            with contextlib.suppress(RecordingError):
                for made in self._builder.take(topic, log_time_ns, data):
                    self._channels[made.topic].log(made.data, log_time=made.log_time_ns)

    def repeat(self) -> None:
        """Publish again what those who came meanwhile have missed."""
        while self._wanted:
            topic = self._wanted.pop()
            if topic == MAP_TOPIC:
                for made in self._builder.map_again(time.time_ns()):
                    self._channels[topic].log(made.data, log_time=made.log_time_ns)
            elif topic in self._lasting:
                log_time_ns, data = self._lasting[topic]
                self._channels[topic].log(data, log_time=log_time_ns)

    def stop(self) -> None:
        """Stop listening."""
        self._server.stop()


def say(answer: dict[str, object]) -> None:
    """Tell the session how the start went."""
    os.write(1, json.dumps(answer).encode() + b"\n")


def main(arguments: list[str]) -> int:
    """Serve until standard input ends; return the exit status."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with contextlib.suppress(OSError, AttributeError):
        # The participant's pictures come first.
        os.nice(_NICENESS)
    host, port = arguments
    try:
        server = LiveServer(host, int(port))
    except Exception as error:
        say({"error": str(error)})
        return 1
    say({"port": server.port})
    splitter = FrameSplitter()
    while data := os.read(0, _READ_SIZE):
        for kind, payload in splitter.feed(data):
            if kind is FrameKind.MESSAGES:
                server.take(payload)
        server.repeat()
    server.stop()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
