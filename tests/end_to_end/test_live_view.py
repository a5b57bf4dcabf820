"""`study run --live`: a client of Foxglove's protocol watches a session with a person."""

from __future__ import annotations

import base64
import json
import os
import re
import signal
import socket
import struct
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, message_factory

from children import child_of
from patience import PATIENCE_S
from protocols import variant
from study.events.shell import Note
from study.recording.reader import read_recording
from study.verification import verify
from x11_driver import Hands, x_server

pytest.importorskip("foxglove", reason="the extra live is not installed")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="live views need POSIX pipes")

from websockets.sync.client import ClientConnection, connect  # noqa: E402
from websockets.typing import Subprotocol  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
SUBPROTOCOL = Subprotocol("foxglove.sdk.v1")
MESSAGE_DATA = struct.Struct("<BIQ")
"""Opcode 1, subscription, log time in ns; the message follows."""


@contextmanager
def session(
    folder: Path, *options: str, **environment: str
) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a session with a live view; yield it and the view's address."""
    home = folder.parent / "protocol"
    home.mkdir()
    protocol = variant(home, ("[practice]\ntimesteps = 10", "[practice]\ntimesteps = 1000"))
    command = [sys.executable, "-m", "study.commands.main", "run", str(protocol), "-p", "P01"]
    study = subprocess.Popen(
        [*command, "-o", str(folder), "--live", "--live-port", "0", *options],
        cwd=ROOT,
        env={
            **os.environ,
            "PYTHONPATH": str(ROOT),
            "PYTHONUNBUFFERED": "1",
            "SDL_VIDEODRIVER": "dummy",
            "SDL_AUDIODRIVER": "dummy",
            **environment,
        },
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        assert study.stdout is not None
        for line in study.stdout:
            if found := re.search(r"ws://\S+", line):
                yield study, found[0]
                return
        assert study.stderr is not None
        raise AssertionError(study.stderr.read())
    finally:
        study.kill()
        study.wait(PATIENCE_S)
        for stream in (study.stdout, study.stderr):
            if stream:
                stream.close()


class Viewer:
    """Speaks Foxglove's protocol: reads the list of channels, subscribes, decodes."""

    def __init__(self, connection: ClientConnection) -> None:
        self._connection = connection
        self.channels: dict[str, dict[str, Any]] = {}
        self._subscribed: list[tuple[str, Any]] = []

    def wait_for_channels(self, *topics: str) -> None:
        """Read until these topics are offered."""
        while not set(topics) <= set(self.channels):
            text = self._connection.recv(PATIENCE_S)
            if isinstance(text, str) and (said := json.loads(text))["op"] == "advertise":
                self.channels |= {item["topic"]: item for item in said["channels"]}

    def subscribe(self, *topics: str) -> None:
        """Ask for the messages of topics."""
        asked = []
        for topic in topics:
            channel = self.channels[topic]
            assert channel["encoding"] == "protobuf"
            pool = descriptor_pool.DescriptorPool()
            data = base64.b64decode(channel["schema"])
            for file in descriptor_pb2.FileDescriptorSet.FromString(data).file:
                pool.Add(file)
            kind = pool.FindMessageTypeByName(channel["schemaName"])
            asked.append({"id": len(self._subscribed), "channelId": channel["id"]})
            self._subscribed.append((topic, message_factory.GetMessageClass(kind)))
        self._connection.send(json.dumps({"op": "subscribe", "subscriptions": asked}))

    def receive(self, *topics: str) -> dict[str, Any]:
        """Read until a message of each topic has come; return the last of each."""
        found: dict[str, Any] = {}
        deadline = time.monotonic() + PATIENCE_S
        while not set(topics) <= set(found):
            data = self._connection.recv(max(0.0, deadline - time.monotonic()))
            if isinstance(data, bytes) and data[0] == 1:
                _, subscription, _ = MESSAGE_DATA.unpack_from(data)
                topic, kind = self._subscribed[subscription]
                found[topic] = kind.FromString(data[MESSAGE_DATA.size :])
        return found


@contextmanager
def watching(url: str) -> Iterator[Viewer]:
    with connect(
        url, subprotocols=[SUBPROTOCOL], open_timeout=PATIENCE_S, max_size=None
    ) as connection:
        assert connection.subprotocol == SUBPROTOCOL
        yield Viewer(connection)


def note_of(folder: Path) -> str:
    """Return what the recording says of the live view."""
    (path,) = folder.glob("*.mcap")
    assert read_recording(path).complete
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    notes = [record for _, record in read_recording(path).records(Note.topic)]
    return next(n.text for n in notes if isinstance(n, Note) and n.text.startswith("live view"))


@pytest.mark.skipif(sys.platform != "linux", reason="finds processes as Linux does")
def test_a_viewer_sees_a_trial_and_a_lost_view_costs_nothing(tmp_path: Path) -> None:
    """Channels and decoded messages come; stopped, then killed: the session goes on."""
    folder = tmp_path / "recordings"
    with (
        x_server() as display,
        session(folder, DISPLAY=display, SDL_VIDEODRIVER="x11") as (study, url),
    ):
        hands = Hands(display)
        hands.wait_for_window()
        with watching(url) as viewer:
            viewer.wait_for_channels("event/timestep", "scene/robots", "scene/map")
            viewer.subscribe("input/session_opened", "scene/map", "event/stage_entered")
            early = viewer.receive("input/session_opened", "scene/map", "event/stage_entered")
            assert early["input/session_opened"].participant == "P01"
            assert {"goal_1", "wall_1"} <= {entity.id for entity in early["scene/map"].entities}
            viewer.subscribe("event/timestep", "scene/robots", "scene/poses")
            for _ in range(12):
                hands.tap("return")
                time.sleep(0.2)
            seen = viewer.receive("event/timestep", "scene/robots", "scene/poses")
            assert len(seen["scene/poses"].poses) == seen["event/timestep"].robots == 1
            assert seen["scene/robots"].entities[0].id == "robot_1"
        live = child_of(study, "study.foxglove.live_server")
        os.kill(live, signal.SIGSTOP)
        time.sleep(1.5)
        os.kill(live, signal.SIGKILL)
        time.sleep(1.5)
        assert study.poll() is None
        study.send_signal(signal.SIGTERM)
        assert study.wait(PATIENCE_S) == 3
        assert study.stderr is not None
        assert "The recording has them" in study.stderr.read()
        hands.close()
    passed, dropped = map(int, re.findall(r"\d+", note_of(folder)))
    assert passed > 0
    assert dropped > 0


def test_a_port_that_is_taken_is_said_before_the_session_begins(tmp_path: Path) -> None:
    """Status 2, one message, no recording."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        command = [sys.executable, "-m", "study.commands.main", "run", "smoke", "-p", "P01"]
        done = subprocess.run(
            [*command, "-o", str(tmp_path / "out"), "--live", "--live-port", str(port)],
            cwd=ROOT,
            env={**os.environ, "PYTHONPATH": str(ROOT), "SDL_VIDEODRIVER": "dummy"},
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    assert done.returncode == 2
    assert f"no live view at 127.0.0.1, port {port}" in done.stderr
    assert "Traceback" not in done.stderr
    assert not list((tmp_path / "out").glob("*.mcap*"))
