"""``-o`` names a folder; a file there is said to be one, before anything is done."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from analysis.commands.main import app as analysis
from study.commands.main import app as study
from study.errors import StudyError

COMMANDS = {
    "run": (study, ["run", "smoke", "-p", "P01"]),
    "preflight": (study, ["preflight", "smoke", "--no-keys"]),
    "simulate": (study, ["simulate", "smoke", "--participants", "1"]),
    "gallery": (study, ["gallery", "smoke"]),
    "plan": (study, ["plan", "smoke", "--effect", "3"]),
    "experiment": (study, ["experiment", "simulation", "--trials", "2"]),
    "participants": (study, ["participants", "smoke"]),
    "whatif": (study, ["whatif", "nowhere"]),
    "report": (analysis, ["report", "nowhere"]),
    "tables": (analysis, ["tables", "nowhere"]),
    "export": (analysis, ["export", "nowhere"]),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("inside", ["", "a/folder"], ids=["the file", "within it"])
def test_a_file_is_no_folder(tmp_path: Path, command: str, inside: str) -> None:
    """The file is named and stays as it was."""
    app, words = COMMANDS[command]
    file = tmp_path / "notes.txt"
    file.write_text("mine")
    done = CliRunner().invoke(app, [*words, "-o", str(file / inside)])
    assert isinstance(done.exception, StudyError)
    assert done.exception.message.startswith(f"-o {file}")
    assert "a folder is wanted" in done.exception.message
    assert file.read_text() == "mine"


def test_a_video_is_in_no_file(tmp_path: Path) -> None:
    """Said before the recording is looked at."""
    file = tmp_path / "notes.txt"
    file.write_text("mine")
    video = file / "clips" / "a.webm"
    done = CliRunner().invoke(study, ["replay", "nowhere.mcap", "--video", str(video)])
    assert isinstance(done.exception, StudyError)
    assert done.exception.message.startswith(f"--video {video} lies in {file}, which is a file")
