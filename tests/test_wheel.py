"""What a user installs holds all that the program reads."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


def test_wheel_holds_protocols_fonts_and_templates(tmp_path: Path) -> None:
    """A wheel ships the protocols, the questionnaires, the fonts and the report's templates."""
    command = [sys.executable, "-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    (wheel,) = tmp_path.glob("scaled_autonomy-*.whl")
    names = set(zipfile.ZipFile(wheel).namelist())
    for name in (
        "study/shipped_protocols/scaled_autonomy.toml",
        "study/shipped_protocols/pilot.toml",
        "study/shipped_protocols/smoke.toml",
        "study/shipped_protocols/questionnaires/ease_and_success.toml",
        "study/simulated/users/navigation.safetensors",
        "study/shell/fonts/Inter-Medium.otf",
        "study/shell/fonts/OFL.txt",
        "study/shell/fonts/DejaVuSans.ttf",
        "study/shell/fonts/DejaVuSans-Bold.ttf",
        "study/shell/fonts/DEJAVU_LICENSE.txt",
        "study/locales/en/LC_MESSAGES/study.mo",
        "analysis/templates/report.html.j2",
    ):
        assert name in names
    assert not [name for name in names if name.startswith(("tests/", "recordings/", "docs/"))]
