"""A session's link under consoles that behave badly: it goes on, and is never kept waiting."""

from __future__ import annotations

import contextlib
import json
import os
import random
import socket
import time
from collections.abc import Iterator

import pytest

from patience import PATIENCE_S, until
from study.console.link import MOST_CONSOLES, MOST_REFUSALS
from study.console.places import socket_path
from study.console.wire import Answer, Ended, Status, parse_said
from watched_session import WatchedSession, room

pytestmark = pytest.mark.skipif(os.name != "posix", reason="consoles need Unix sockets")


@pytest.fixture
def session(monkeypatch: pytest.MonkeyPatch) -> Iterator[WatchedSession]:
    with room(monkeypatch) as place, place.session() as running:
        yield running


class Caller:
    """A console without a screen."""

    def __init__(self) -> None:
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.settimeout(PATIENCE_S)
        until(self._connected)
        self._come = b""

    def _connected(self) -> bool:
        try:
            self.socket.connect(str(socket_path("abc0")))
        except BlockingIOError:
            return False  # Others are waited for.
        return True

    def send(self, line: bytes) -> None:
        """Send bytes, however much room there is."""
        self.socket.sendall(line)

    def hear(self) -> Status | Answer | Ended | None:
        """Return the next thing said; None once it is hung up on."""
        while b"\n" not in self._come:
            try:
                data = self.socket.recv(1 << 16)
            except ConnectionResetError:
                return None
            if not data:
                return None
            self._come += data
        line, _, self._come = self._come.partition(b"\n")
        return parse_said(line)

    def answer(self) -> Answer | None:
        """Return the next answer, past whatever states."""
        while (said := self.hear()) is not None:
            if isinstance(said, Answer):
                return said
        return None


def test_a_command_in_pieces_is_obeyed_once(session: WatchedSession) -> None:
    """A line arrives as bytes; the state that follows shows it."""
    caller = Caller()
    for byte in b'{"command": "annotate", "text": "coughs"}\n':
        caller.send(bytes([byte]))
        time.sleep(0.002)
    assert caller.answer() == Answer(command="annotate")
    until(lambda: bool(session.obeyed))
    assert [command.text for command in session.obeyed] == ["coughs"]
    said = caller.hear()
    assert isinstance(said, Status)
    assert said.notes[-1].text == "coughs"


def test_the_state_is_all_that_a_console_shows(session: WatchedSession) -> None:
    """Participant, place, trial, fits with gate, timing, disk, deviations, notes."""
    said = Caller().hear()
    assert isinstance(said, Status)
    assert (said.facts.participant, said.place.number, said.place.stages) == ("P07", 22, 40)
    assert said.trial is not None
    assert (said.trial.number, said.trial.robots, said.trial.timesteps) == (2, 12, 400)
    policy, scorer = said.fits
    assert (policy.state, policy.top1, policy.gate) == ("in use", None, "")
    assert (scorer.gate, scorer.top1, scorer.chance_top1) == ("passed", 0.61, 0.25)
    assert scorer.likelihood_gain == pytest.approx(0.486)
    assert (said.timing.frames, said.timing.late) == (600, 1)
    assert said.timing.longest_ms == pytest.approx(34.0)
    assert (said.disk.sent, said.disk.durable, said.disk.unsaved_s) == (5210, 5204, 0.2)
    assert [remark.code for remark in said.deviations] == ["practice_repeated"]
    assert [remark.text for remark in said.notes] == ["asked which key selects a robot"]


def test_what_makes_no_sense_now_is_refused(session: WatchedSession) -> None:
    caller = Caller()
    for command, refused in (
        ("resume", "not paused"), ("pause", ""), ("pause", "already"), ("resume", ""),
    ):  # fmt: skip
        caller.send(json.dumps({"command": command}).encode() + b"\n")
        answer = caller.answer()
        assert answer is not None
        assert refused in answer.refused if refused else not answer.refused
    # The answer may come before the session obeys.
    until(lambda: len(session.obeyed) == 2)
    assert [command.command for command in session.obeyed] == ["pause", "resume"]


def test_rubbish_is_refused_and_then_hung_up_on(session: WatchedSession) -> None:
    """Each line is answered in words; after some the connection ends; others are served."""
    caller, other = Caller(), Caller()
    caller.send(b"\xff\x00{}\n" * (2 * MOST_REFUSALS))
    answers = []
    while (answer := caller.answer()) is not None:
        answers.append(answer.refused)
    assert answers
    assert len(answers) <= MOST_REFUSALS
    assert all("no command was understood" in refused for refused in answers)
    assert isinstance(other.hear(), Status)
    assert session.obeyed == []


def test_a_line_without_end_is_cut_off(session: WatchedSession) -> None:
    """Megabytes without a newline are not gathered."""
    caller = Caller()
    with pytest.raises(OSError, match=r"Broken pipe|reset"):
        caller.send(b"x" * (64 << 20))
    assert isinstance(Caller().hear(), Status)


def test_fuzz(session: WatchedSession) -> None:
    """Torn, doubled and random lines from many connections: no fault, no false command."""
    chance = random.Random(5)
    line = b'{"command": "annotate", "text": "t"}\n'
    for _ in range(60):
        caller = Caller()
        data = bytearray(line * chance.randint(1, 3) + chance.randbytes(chance.randint(0, 40)))
        for _ in range(chance.randint(0, 6)):
            data[chance.randrange(len(data))] = chance.randrange(256)
        with contextlib.suppress(OSError):
            caller.send(bytes(data[: chance.randint(1, len(data))]))
        caller.socket.close()
    assert isinstance(Caller().hear(), Status)
    assert all(command.command in ("annotate", "pause", "resume") for command in session.obeyed)
    assert all(command.text.isprintable() for command in session.obeyed)


def test_a_console_that_does_not_read_keeps_nobody_waiting(session: WatchedSession) -> None:
    """Thousands of answers find no room: the loop's own work stays in milliseconds."""
    caller = Caller()
    caller.socket.setblocking(False)
    deadline = time.monotonic() + 3.0
    while time.monotonic() < deadline:
        try:
            caller.socket.send(b'{"command": "resume"}\n' * 50)
        except BlockingIOError:
            time.sleep(0.01)
        except OSError:
            break
    assert isinstance(Caller().hear(), Status)
    assert session.longest_pass_s < 0.1


def test_no_more_consoles_than_there_is_room_for(session: WatchedSession) -> None:
    """One too many is hung up on; when one goes there is room again."""
    callers = [Caller() for _ in range(MOST_CONSOLES)]
    assert all(isinstance(caller.hear(), Status) for caller in callers)
    assert Caller().hear() is None
    callers[0].socket.close()

    def welcome() -> bool:
        return isinstance(Caller().hear(), Status)

    until(welcome)


def test_the_end_is_said_and_the_socket_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    with room(monkeypatch) as place:
        with place.session():
            caller = Caller()
            caller.send(b'{"command": "end", "text": "fire drill"}\n')
            assert caller.answer() == Answer(command="end")
        heard = []
        while (said := caller.hear()) is not None:
            heard.append(said)
        assert heard[-1] == Ended(complete=False, reason="ended by the experimenter: fire drill")
        assert isinstance(heard[-2], Status)
        assert heard[-2].state == "ended"
        assert list(place.folder.iterdir()) == []


def test_the_socket_is_its_owners_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    with room(monkeypatch) as place, place.session():
        (path,) = place.folder.iterdir()
        assert path.name == "abc0.sock"
        assert path.stat().st_mode & 0o777 == 0o600
