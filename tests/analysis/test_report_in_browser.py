"""The report in a real browser: accessible, quiet on the network, usable."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import pytest

from analysis.report import render_report
from analysis.results import StudyResults

TOOLS = Path(__file__).resolve().parents[1] / "browser"


def program(*names: str) -> str:
    """Return the path of the first program found; skip the test if there is none."""
    for name in names:
        found = shutil.which(name)
        if found:
            return found
    pytest.skip(f"needs the program {names[0]}")


def installed() -> Path:
    """Install the locked packages once for all workers and return their folder."""
    npm = program("npm")
    stamp = (TOOLS / "package-lock.json").stat().st_mtime_ns
    home = Path(tempfile.gettempdir()) / f"scaled-autonomy-browser-{os.getuid()}-{stamp}"
    home.mkdir(mode=0o700, exist_ok=True)
    with (home / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (home / "done").exists():
            for name in ("package.json", "package-lock.json"):
                shutil.copy(TOOLS / name, home)
            command = [npm, "ci", "--no-audit", "--no-fund", "--ignore-scripts"]
            done = subprocess.run(command, cwd=home, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr[-2000:]
            (home / "done").touch()
    shutil.copy(TOOLS / "inspect_report.mjs", home)
    return home


@pytest.fixture(scope="module")
def seen(results: StudyResults, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What headless Chromium found in the synthetic study's report."""
    node, chromium = program("node"), program("chromium", "chromium-browser", "google-chrome")
    home = installed()
    report = tmp_path_factory.mktemp("browser") / "report.html"
    report.write_text(render_report(results), encoding="utf-8")
    command = [node, str(home / "inspect_report.mjs"), chromium, str(report)]
    done = subprocess.run(command, cwd=home, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-4000:]
    found: dict[str, Any] = json.loads(done.stdout)
    return found


pytestmark = pytest.mark.timeout(600)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_no_violation(seen: dict[str, Any], scheme: str) -> None:
    """No rule of axe-core is broken, on the light page and on the dark one."""
    assert seen["violations"][scheme] == []


def test_no_request_leaves_the_page(seen: dict[str, Any]) -> None:
    """Opened and used, the page asks for nothing, and its policy blocks nothing of its own."""
    assert seen["requests"] == []
    assert seen["errors"] == []


def test_every_contents_link_leads_to_its_section(seen: dict[str, Any]) -> None:
    """Each link of the contents brings its section into view."""
    assert "#summary" in seen["links"]
    assert "#participants" in seen["links"]
    assert len(seen["links"]) == len(set(seen["links"])) >= 12


def test_a_table_is_downloaded(seen: dict[str, Any], results: StudyResults) -> None:
    """The first download button gives the table of sessions, whole."""
    download = seen["downloads"][0]
    assert download["name"] == "sessions.csv"
    assert download["text"] == results.tables["sessions"].to_csv(results.label.line)


def test_text_is_copied_and_the_theme_changes_by_keyboard(seen: dict[str, Any]) -> None:
    """A copy button takes its text; Enter on the theme's button changes the page."""
    assert seen["copied"] is True
    assert seen["theme"] == "dark"
