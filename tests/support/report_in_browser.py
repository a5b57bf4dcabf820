"""Opens a report in headless Chromium and says what was found."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

from node_packages import install_packages
from patience import PATIENCE_S
from x11_driver import require_program

TOOLS = Path(__file__).parents[1] / "browser"


def inspect(report: Path) -> dict[str, Any]:
    """Return what headless Chromium finds in a report; skip the test where a program is missing."""
    node, chromium = require_program("node"), require_program("chromium")
    install_packages(TOOLS)
    command = [node, str(TOOLS / "inspect_report.mjs"), chromium, str(report)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr[-4000:]
    found: dict[str, Any] = json.loads(done.stdout)
    return found
