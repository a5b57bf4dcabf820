"""A stretch of cable on this computer that a test can hold, slow down or sever."""

from __future__ import annotations

import socket
import threading
import time
from urllib.parse import urlparse


class Cable:
    """Listens on a free port of this computer and passes bytes on to an address.

    Attributes:
        address: where to connect to.
        far: where it leads.
        held: while set, nothing passes, and nobody is told; what was sent comes later.
        delay_s: each way.
    """

    def __init__(self, address: str) -> None:
        there = urlparse(address)
        self.far = address
        self._there = (str(there.hostname), int(there.port or 0))
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self._listener.getsockname()[1]}"
        self.held = threading.Event()
        self.delay_s = 0.0
        self._ended = False
        self._sockets: list[socket.socket] = []
        threading.Thread(target=self._accept, daemon=True).start()

    def sever(self) -> None:
        """End the connections there are; new ones can be made."""
        for end in self._sockets:
            end.close()
        self._sockets.clear()

    def close(self) -> None:
        """End everything."""
        self._ended = True
        self._listener.close()
        self.sever()

    def _accept(self) -> None:
        while not self._ended:
            try:
                near, _ = self._listener.accept()
                far = socket.create_connection(self._there)
            except OSError:
                continue
            self._sockets += [near, far]
            for ends in ((near, far), (far, near)):
                threading.Thread(target=self._pass_on, args=ends, daemon=True).start()

    def _pass_on(self, source: socket.socket, sink: socket.socket) -> None:
        try:
            source.settimeout(0.05)
            while not self._ended:
                try:
                    data = source.recv(65536)
                except TimeoutError:
                    continue
                if not data:
                    break
                due = time.monotonic() + self.delay_s
                while self.held.is_set() or time.monotonic() < due:
                    time.sleep(0.002)
                sink.sendall(data)
        except OSError:
            pass
        finally:
            sink.close()
