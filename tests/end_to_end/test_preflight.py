"""`study preflight` in a real window, and what `study run` makes of its result."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from study.commands.preflight import preflight_remark
from study.errors import StudyError
from study.loading import load_protocol
from study.shell.preflight.check import FILE
from x11_driver import x_server


def _study(*words: str, display: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "DISPLAY": display, "SDL_VIDEODRIVER": "x11"}
    command = [sys.executable, "-m", "study.commands.main", *words]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=180, check=False
    )


def test_red_blocks_and_an_override_is_recorded(tmp_path: Path) -> None:
    """Every check is made and kept; a red result stops `study run`, a reason lets it begin."""
    with x_server(1280, 960) as display:
        done = _study("preflight", "smoke", "-o", str(tmp_path), "--no-keys", "--json",
                      display=display)  # fmt: skip
        told = json.loads(done.stdout)
        assert "cannot be opened" not in done.stdout, done.stdout
        names = [check["name"] for check in told["checks"]]
        assert names == [
            "rehearsal", "fits", "disk space", "writing", "clock",
            "display", "fonts", "punctuality", "keyboard",
        ]  # fmt: skip
        assert (done.returncode == 3) == (told["state"] == "red")
        assert (tmp_path / FILE).stat().st_mode & 0o077 == 0

        kept = json.loads((tmp_path / FILE).read_text())
        kept["checks"][2] |= {"state": "red", "found": "2 MiB free"}
        (tmp_path / FILE).write_text(json.dumps(kept))
        refused = _study("run", "smoke", "-p", "P01", "-o", str(tmp_path), display=display)
    assert refused.returncode != 0
    assert "2 MiB free" in refused.stderr
    assert "Traceback" not in refused.stderr
    assert not list(tmp_path.glob("*.mcap*"))

    sha256 = load_protocol("smoke").sha256
    remark = preflight_remark(tmp_path, sha256, "the disk is emptied at noon")
    assert remark.endswith("begun all the same: the disk is emptied at noon")
    with pytest.raises(StudyError, match="--override-preflight"):
        preflight_remark(tmp_path, sha256, "  ")
