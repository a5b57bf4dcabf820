"""The commands as a user meets them: exit status, messages, and never a traceback."""

from __future__ import annotations

import importlib.metadata
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from command_line import study
from protocols import variant
from study.commands.composing import session_opened, start_recorder
from study.commands.enrolling import assign
from study.loading import load_protocol
from study.recording.reader import read_recording


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One simulated participant of the smoke protocol, recorded by the command."""
    folder = tmp_path_factory.mktemp("recordings")
    done = study("simulate", "smoke", "--participants", "1", "--jobs", "1", "-o", folder)
    assert done.returncode == 0, done.stderr
    assert "1 simulated participant (seed " in done.stdout
    (path,) = folder.glob("*.mcap")
    return path


@pytest.mark.parametrize("command", ["study", "analysis"])
def test_version(command: str) -> None:
    """Both command lines tell which version they are."""
    program = Path(sys.executable).with_name(command)
    done = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(
        f"scaled-autonomy {importlib.metadata.version('scaled-autonomy')}"
    )


def test_validate_prints_dwell_and_minutes() -> None:
    """A valid protocol: dwell in seconds, minutes a stage and the marked assumptions."""
    done = study("validate", "scaled_autonomy")
    assert done.returncode == 0
    assert "dwell 15 timesteps = 1.88 s" in done.stdout
    assert "Phase three, assisted" in done.stdout
    assert f"Assumptions marked: {len(load_protocol('scaled_autonomy').protocol.assumptions)}" in (
        done.stdout
    )


@pytest.mark.parametrize("command", ["validate", "simulate", "run"])
def test_wrong_protocol_is_one_message_a_problem(tmp_path: Path, command: str) -> None:
    """Exit status 2 and as many lines as there are problems, with a file name that means markup."""
    folder = tmp_path / "odd [" / "] [bold]name"
    folder.mkdir(parents=True)
    path = variant(folder, ("episodes = 2", "episode = 2"), ("dwell = 15", "dwell = -1"))
    extra = ["-p", "P01"] if command == "run" else []
    done = study(command, path, *extra)
    assert done.returncode == 2
    lines = done.stderr.splitlines()
    assert lines[0] == f"Error: {path}: 2 problems"
    assert [line.split(":")[0] for line in lines[1:]] == [
        "  phase_one.episode",
        "  conditions.assisted.dwell",
    ]


def test_valid_protocol_in_a_folder_that_means_markup(tmp_path: Path) -> None:
    """Names are printed as they are."""
    folder = tmp_path / "odd [" / "] [bold]name"
    folder.mkdir(parents=True)
    done = study("validate", variant(folder))
    assert done.returncode == 0
    assert str(folder) in done.stdout


def test_simulated_recording_is_complete(recording: Path) -> None:
    """The recording is whole, of a simulated participant, with the protocol in full."""
    read = read_recording(recording)
    assert read.complete
    assert recording.name.startswith("smoke_S01_")
    # Simulated participants are not enrolled.
    assert list(recording.parent.iterdir()) == [recording]


def test_replay_verifies(recording: Path) -> None:
    """Exit status 0 where every event follows, with both checks."""
    done = study("replay", recording, "--verify", "--resimulate")
    assert done.returncode == 0, done.stderr
    assert "byte for byte" in done.stdout
    assert "largest difference of a state 0" in done.stdout


def test_the_protocol_is_got_out_of_a_recording(recording: Path, tmp_path: Path) -> None:
    """Byte for byte the file that the session began with; nothing is overwritten."""
    out = tmp_path / "out.toml"
    done = study("protocol", recording, "-o", out)
    assert done.returncode == 0, done.stderr
    assert out.read_bytes() == load_protocol("smoke").text.encode()
    assert study("protocol", recording, "-o", out).returncode == 2
    assert study("protocol", tmp_path / "none.mcap").returncode == 2


def test_replay_takes_several(recording: Path, tmp_path: Path) -> None:
    """Several recordings at once, each once; one that differs decides the exit status."""
    again = Path(shutil.copy(recording, tmp_path / "again.mcap"))
    done = study("replay", recording, again, recording, "--verify")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("byte for byte") == 2
    again.write_bytes(again.read_bytes()[:5000])
    assert study("replay", recording, again, "--verify").returncode != 0


def test_replay_proves_nothing_of_nothing(tmp_path: Path) -> None:
    """Exit status 1 where a recording holds no inputs that events could follow from."""
    loaded = load_protocol("smoke")
    opened = session_opened(loaded, assign(loaded, "P01", tmp_path))
    path = start_recorder(tmp_path, loaded, opened).close()
    done = study("replay", path, "--verify")
    assert done.returncode == 1
    assert "Different: the recording holds no inputs" in done.stderr


@pytest.mark.parametrize("damage", ["missing", "folder", "empty", "text", "cut", "flipped"])
def test_replay_refuses_what_is_no_whole_recording(
    tmp_path: Path, recording: Path, damage: str
) -> None:
    """Exit status 2 and one message; of a torn file a part may agree, which is no proof (1)."""
    path = tmp_path / "x.mcap"
    data = recording.read_bytes()
    if damage == "folder":
        path.mkdir()
    elif damage != "missing":
        flipped = bytearray(data)
        flipped[len(data) // 2] ^= 0x10
        contents = {"empty": b"", "text": b"no recording\n" * 50, "cut": data[: len(data) // 3]}
        path.write_bytes(contents.get(damage, bytes(flipped)))
    done = study("replay", path, "--verify")
    allowed = {1, 2} if damage in ("cut", "flipped") else {2}
    assert done.returncode in allowed, done.stderr
    assert "Identical" not in done.stdout
    if damage == "flipped":
        # What was lost is not taken for events that do not follow.
        assert "Different" not in done.stderr
        assert "Compared up to record" in done.stderr
    if done.returncode == 2:
        assert done.stderr.startswith("Error: ")
        assert str(path) in done.stderr


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["simulate", "nowhere.toml"], "scaled_autonomy"),
        (["simulate", "smoke", "--participants", "0"], "--participants"),
        (["simulate", "smoke", "--jobs", "0"], "--jobs"),
        (["run", "smoke", "-p", "../P01"], "participant id"),
        (["run", "smoke", "-p", "P01", "--seed", "99999999999999999999"], "--seed"),
        (["run", "smoke", "-p", "P01", "--order", "manual"], "manual"),
        (["run", "smoke", "--resume"], "no folder recordings"),
        (["validate"], "protocol"),
        (["fly"], "fly"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_arguments(tmp_path: Path, arguments: list[str], words: str) -> None:
    """Exit status 2, and the message names what was wrong; nothing is recorded."""
    done = study(*arguments, folder=tmp_path)
    assert done.returncode == 2
    assert words in done.stderr
    assert not list(tmp_path.rglob("*.mcap*"))


@pytest.mark.parametrize("command", ["simulate", "run"])
def test_output_that_cannot_be_written(tmp_path: Path, command: str) -> None:
    """An output folder that is a file, or lies in one, is one message."""
    blocker = tmp_path / "file"
    blocker.write_text("")
    extra = ["-p", "P01"] if command == "run" else ["--participants", "1", "--jobs", "1"]
    for output in (blocker, blocker / "below"):
        done = study(command, "smoke", *extra, "-o", output)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith("Error: ")
        assert str(blocker) in done.stderr
    assert blocker.read_text() == ""
