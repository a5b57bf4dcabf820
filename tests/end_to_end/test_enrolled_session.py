"""`study run` without an id: enrolled, killed, interrupted, resumed in its slot, dropped."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from patience import PATIENCE_S
from protocols import ROOT
from study.errors import StudyError
from study.recording.parts import read_session
from study.recording.reader import read_recording
from study.recording.register_folders import FILE_NAME

ENVIRONMENT = {
    **os.environ,
    "PYTHONPATH": str(ROOT),
    "SDL_VIDEODRIVER": "dummy",
    "SDL_AUDIODRIVER": "dummy",
}
COMMAND = [sys.executable, "-m", "study.commands.main"]


def begin(folder: Path, *options: str) -> subprocess.Popen[str]:
    """Start a session."""
    return subprocess.Popen(
        [*COMMAND, "run", "smoke", "-o", str(folder), *options],
        cwd=ROOT,
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def shown(folder: Path) -> list[dict[str, Any]]:
    """Return what `study participants` shows."""
    command = [*COMMAND, "participants", str(folder), "--json"]
    done = subprocess.run(
        command,
        cwd=ROOT,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    rows: list[dict[str, Any]] = json.loads(done.stdout)
    return rows


def until_running(folder: Path, studies: list[subprocess.Popen[str]]) -> None:
    """Wait until as many sessions run as were started."""
    end = time.monotonic() + PATIENCE_S
    while True:
        for study in studies:
            assert study.poll() is None, study.communicate()[0]
        # Nothing is shown before the first of them has made the register.
        if (folder / FILE_NAME).exists():
            running = [row for row in shown(folder) if row["state"] == "running"]
            if len(running) == len(studies):
                return
        assert time.monotonic() < end
        time.sleep(0.1)


def until_recorded(folder: Path, study: subprocess.Popen[str], name: str) -> None:
    """Wait until the file of that name's end holds records."""
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        assert study.poll() is None, study.communicate()[0]
        for path in folder.glob(name):
            # It may have been made this moment, and be empty.
            with suppress(StudyError):
                if sum(1 for _ in read_recording(path).raw("event")) >= 2:
                    return
        time.sleep(0.1)
    raise AssertionError(f"nothing recorded in {name}")


def test_two_at_once_one_killed_and_resumed(tmp_path: Path) -> None:
    """Both get a slot and an order of their own; the outcome of each is written back."""
    studies = [begin(tmp_path), begin(tmp_path, "--participant", "P01")]
    try:
        until_running(tmp_path, studies)
        rows = shown(tmp_path)
        assert sorted(row["slot"] for row in rows) == [1, 2]
        assert sorted(row["order"] for row in rows) == [
            ["assisted", "manual"],
            ["manual", "assisted"],
        ]
        (drawn,) = [row["pseudonym"] for row in rows if row["pseudonym"] != "P01"]
        until_recorded(tmp_path, studies[0], f"smoke_{drawn}_*.mcap.part")
        again = begin(tmp_path, "--participant", drawn)
        assert "is in a session: process" in again.communicate(timeout=PATIENCE_S)[0]
        studies[0].kill()
        studies[0].wait(PATIENCE_S)
        states = {row["pseudonym"]: row["state"] for row in shown(tmp_path)}
        assert states == {drawn: "interrupted", "P01": "running"}
        slot = next(row["slot"] for row in rows if row["pseudonym"] == drawn)
        # Without an id: the one that broke off.
        resumed = begin(tmp_path, "--resume")
        studies.append(resumed)
        until_recorded(tmp_path, resumed, f"smoke_{drawn}_*_part2.mcap.part")
        now = next(row for row in shown(tmp_path) if row["pseudonym"] == drawn)
        assert (now["state"], now["slot"]) == ("running", slot)
        for study in studies[1:]:
            study.send_signal(signal.SIGTERM)
            assert study.wait(PATIENCE_S) == 3
    finally:
        for study in studies:
            study.kill()
            study.communicate(timeout=PATIENCE_S)
    rows = shown(tmp_path)
    assert {row["state"] for row in rows} == {"dropped"}
    assert {row["reason"] for row in rows} == {"SIGTERM"}
    for path in tmp_path.glob("*[0-9a-f].mcap"):
        session = read_session(path)
        order = next(r["order"] for r in rows if r["pseudonym"] == session.metadata["participant"])
        assert session.complete
        assert order


@pytest.mark.acceptance
def test_the_advice_to_go_on_is_a_command_that_works(tmp_path: Path) -> None:
    """Whatever it began with, the session that was ended early goes on with what is advised."""

    def ended_early(*options: str) -> str:
        """Begin a session, end it, and return what is said of going on."""
        study = begin(tmp_path, *options)
        try:
            until_running(tmp_path, [study])
            study.send_signal(signal.SIGTERM)
            said = " ".join(study.communicate(timeout=PATIENCE_S)[0].split())
        finally:
            study.kill()
        assert study.returncode == 3, said
        return said.partition("To go on where it broke off, ")[2]

    assert ended_early("--participant", "P01") == "say the same with --resume."
    again = ended_early("--participant", "P01", "--again", "--seed", "7")
    assert again == "say the same with --resume, without --again and --seed."
    assert ended_early("--participant", "P01", "--resume") == "say the same with --resume."
    before = {row["pseudonym"] for row in shown(tmp_path)}
    said = ended_early("--pilot")
    (drawn,) = {row["pseudonym"] for row in shown(tmp_path)} - before
    assert said == f"say the same with --participant {drawn} and --resume, without --pilot."
    assert ended_early("--participant", drawn, "--resume") == "say the same with --resume."
