"""A small NatNet 3.0 server on this computer: one UDP socket, rigid bodies as a test wants."""

from __future__ import annotations

import socket
import struct
import threading
from contextlib import suppress

_CONNECT, _SERVER_INFO, _FRAME = 0, 1, 7


class NatNetServer:
    """Streams to whoever connected, 100 times a second.

    Attributes:
        port: for commands and data.
        bodies: streaming id to position, quaternion (x, y, z, w) and whether it is tracked.
    """

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.settimeout(0.01)
        self.port: int = self._socket.getsockname()[1]
        self.bodies: dict[
            int, tuple[tuple[float, float, float], tuple[float, float, float, float], bool]
        ] = {}
        self._ending = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def close(self) -> None:
        """Fall silent."""
        self._ending.set()
        self._thread.join()
        self._socket.close()

    def _serve(self) -> None:
        client, number = None, 0
        while not self._ending.is_set():
            with suppress(TimeoutError):
                data, sender = self._socket.recvfrom(4096)
                if struct.unpack_from("<H", data)[0] == _CONNECT:
                    client = sender
                    name = b"test".ljust(256, b"\0")
                    self._say(client, _SERVER_INFO, name + bytes([2, 0, 0, 0, 3, 0, 0, 0]))
            if client:
                number += 1
                self._say(client, _FRAME, self._frame(number))

    def _say(self, client: tuple[str, int], kind: int, payload: bytes) -> None:
        self._socket.sendto(struct.pack("<HH", kind, len(payload)) + payload, client)

    def _frame(self, number: int) -> bytes:
        bodies = b"".join(
            struct.pack("<I3f4ffH", body, *place, *turn, 0.0, int(tracked))
            for body, (place, turn, tracked) in self.bodies.items()
        )
        nothing = struct.pack("<I", 0)
        # Frame, marker sets, markers; bodies; skeletons, labelled markers, plates, devices; suffix.
        return (
            struct.pack("<I", number)
            + 2 * nothing
            + struct.pack("<I", len(self.bodies))
            + bodies
            + 4 * nothing
            + struct.pack("<IIdQQQH", 0, 0, 0.0, 0, 0, 0, 0)
        )
