"""A register that is damaged, another program's, locked or unwritable: one clear message each."""

from __future__ import annotations

import os
import resource
import signal
import sqlite3
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import pytest

from patience import PATIENCE_S
from protocols import ROOT
from study.enrolment.register import Register
from study.errors import StudyError
from study.recording.enrolled import add_tombstone, not_analysed, tombstones
from study.recording.register_folders import FILE_NAME

ORDERS = [("a", "b"), ("b", "a")]


def message(folder: Path) -> str:
    """Try to reserve; return the one message."""
    with pytest.raises(StudyError) as caught, Register(folder, patience_s=0.2) as register:
        register.reserve("s", ORDERS)
    assert str(folder) in caught.value.message
    assert caught.value.hint
    return caught.value.message


def filled(folder: Path) -> Path:
    """Make a register with some participants; return its file."""
    with Register(folder) as register:
        for number in range(30):
            register.reserve("s", ORDERS, pseudonym=f"P{number}")
    return folder / FILE_NAME


@pytest.mark.parametrize(
    "content", [b"no database\n" * 500, b"\x00" * 4096, b"SQLite format 3\x00"]
)
def test_what_is_no_register(tmp_path: Path, content: bytes) -> None:
    """It is left as it is."""
    (tmp_path / FILE_NAME).write_bytes(content)
    assert "no register of participants, or is damaged" in message(tmp_path)
    assert (tmp_path / FILE_NAME).read_bytes() == content


def test_damaged(tmp_path: Path) -> None:
    """Pages overwritten by a broken disk are noticed, not taken for participants."""
    path = filled(tmp_path)
    data = bytearray(path.read_bytes())
    data[4096:] = b"\xff" * (len(data) - 4096)
    path.write_bytes(data)
    assert "is damaged" in message(tmp_path)


def test_of_another_program_or_version(tmp_path: Path) -> None:
    """Neither is written to."""
    path = tmp_path / FILE_NAME
    with closing(sqlite3.connect(path)) as other:
        other.execute("CREATE TABLE theirs (x)")
    assert "another program" in message(tmp_path)
    path.unlink()
    filled(tmp_path)
    with closing(sqlite3.connect(path)) as other:
        other.execute("PRAGMA user_version = 2")
    assert "has version 2; this program knows 1" in message(tmp_path)


def test_locked(tmp_path: Path) -> None:
    """By another program for longer than is waited; afterwards it works."""
    path = filled(tmp_path)
    with closing(sqlite3.connect(path)) as other:
        other.execute("BEGIN EXCLUSIVE")
        assert "locked by another program" in message(tmp_path)
    with Register(tmp_path) as register:
        assert len(register.participants()) == 30


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """Let nobody write into a folder, root neither."""
    if os.geteuid() != 0:
        folder.chmod(0o500)
        yield
        folder.chmod(0o700)
        return
    done = subprocess.run(["mount", "--bind", str(folder), str(folder)], check=False)
    if done.returncode:
        pytest.skip("root, and yet may not mount")
    try:
        subprocess.run(["mount", "-o", "remount,ro,bind", str(folder)], check=True)
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


@pytest.mark.skipif(sys.platform == "win32", reason="folders of POSIX")
def test_read_only_folder(tmp_path: Path) -> None:
    """Without a register in it, and with one."""
    empty, full = tmp_path / "empty", tmp_path / "full"
    empty.mkdir()
    filled(full)
    with read_only(empty):
        assert "cannot be made" in message(empty)
    with read_only(full):
        assert "cannot be" in message(full)
    with Register(full) as register:
        assert len(register.participants()) == 30


def test_folder_that_is_a_file(tmp_path: Path) -> None:
    """No folder can be made there."""
    blocker = tmp_path / "file"
    blocker.touch()
    assert "cannot be made" in message(blocker)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of Linux")
def test_full_disk(tmp_path: Path) -> None:
    """No byte more can be written: one message, and the register is as it was."""
    path = filled(tmp_path)
    size = path.stat().st_size
    program = (
        "import sys; from pathlib import Path; from study.enrolment.register import Register\n"
        "from study.errors import StudyError\n"
        "try:\n"
        "    register = Register(Path(sys.argv[1]))\n"
        "    for n in range(2000): register.reserve('s', [('a', 'b')], pseudonym=f'Q{n}')\n"
        "except StudyError as error: sys.exit(f'one message: {error}')\n"
    )

    def limit() -> None:
        # Beyond it a write fails as on a full disk instead of ending the program.
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=limit,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.stderr.startswith("one message: the register"), done.stderr
    assert "disk is full" in done.stderr
    with Register(tmp_path) as register:
        known = register.participants("s")
    assert {f"P{number}" for number in range(30)} <= {each.pseudonym for each in known}


def test_tombstones_are_never_taken_for_none(tmp_path: Path) -> None:
    """A damaged list is a message: data of somebody who withdrew must not come back."""
    add_tombstone(tmp_path, "s", "P1", "2026-01-01T00:00:00+00:00")
    assert not_analysed(tmp_path) == {("s", "P1"): "the participant withdrew"}
    for content in ("[]", '{"s": ["P1"]}', "not json", '{"s": {"P1": 1}}'):
        (tmp_path / "withdrawn.json").write_text(content)
        with pytest.raises(StudyError, match="no list of those who withdrew"):
            tombstones(tmp_path)
