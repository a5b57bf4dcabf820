"""Who may load what, and what no file may hold."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted([*(ROOT / "study").rglob("*.py"), *(ROOT / "analysis").rglob("*.py")])
HEAVY = ("pygame", "torch")
MOST_LINES = 350

# Each: what is imported, and what that must not load.
LIGHT = {
    "study.recording.reader": (*HEAVY, "study.session", "study.shell", "study.tasks", "pydantic"),
    "study.recording.writer": (*HEAVY, "study.session", "study.shell", "pandas"),
    "study.session.session": (*HEAVY, "mcap", "study.recording", "study.shell", "study.simulated"),
    "study.commands.main": (*HEAVY, "pandas", "analysis", "study.shell.window"),
    "study.verification": HEAVY,
    "study.robots.on_jetbot": (*HEAVY, "numpy", "pydantic", "mujoco", "study.session"),
    "analysis.commands.main": (*HEAVY, "study.session", "study.shell", "study.tasks"),
    "analysis.report": (*HEAVY, "study.session", "study.shell", "study.commands"),
}
MEMBERS = r"study\.(tasks|policies|scorers)\.(?!base)\w+"


def loaded_by(module: str) -> set[str]:
    """Return the names of the modules that an import loads, in a process of its own."""
    code = f"import sys, {module}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split())


@pytest.mark.parametrize("module", LIGHT)
def test_import_stays_light(module: str) -> None:
    """Reading needs no window, the session no disk, the commands nothing until they run."""
    loaded = loaded_by(module)
    heavy = {
        name
        for name in loaded
        for unwanted in LIGHT[module]
        if name == unwanted or name.startswith(f"{unwanted}.")
    }
    assert heavy == set()
    if module == "study.session.session":
        assert [name for name in loaded if re.fullmatch(MEMBERS, name)] == []


@pytest.mark.parametrize(
    "path", sorted((ROOT / "study" / "session").glob("*.py")), ids=lambda p: p.stem
)
def test_session_asks_no_clock_no_chance_no_disk(path: Path) -> None:
    """The core has inputs and nothing else: that is why its events replay."""
    banned = (
        r"\b(time|random|datetime|secrets|uuid|os|sys|Path)\.[a-z]|\bopen\(|\bprint\(|default_rng"
    )
    banned += r"|^\s*(import|from) (time|random|datetime|secrets|os|pathlib|threading|asyncio)\b"
    lines = path.read_text().splitlines()
    found = [
        line for line in lines if re.search(banned, line) and "np.random.Generator" not in line
    ]
    assert found == []


@pytest.mark.parametrize(
    "banned",
    [
        r"^\s*(import|from) (pickle|cPickle|dill|marshal|shelve)\b",
        r"(?<![\w.])(eval|exec|compile)\(",
        r"\byaml\.load\b",
        r"shell\s*=\s*True",
        r"\bos\.(fork|system)\(",
        r"allow_pickle\s*=\s*True",
        r"\btorch\.load\(",
        r'get_context\("fork',
        r"\bTODO\b|\bFIXME\b|\bXXX\b",
    ],
)
def test_no_file_holds(banned: str) -> None:
    """Nothing read is ever run, no shell is opened, no process forked, nothing left undone."""
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in FILES
        for number, line in enumerate(path.read_text().splitlines(), start=1)
        if re.search(banned, line)
    ]
    assert found == []


def test_nothing_listens_on_a_network_but_the_live_view() -> None:
    """A listener elsewhere is a Unix socket, bound to a path (docs/explanation/threat-model.md).

    Robots listen too, on themselves, for who proves to hold a key.
    """
    listening = r"\.bind\(|\bstart_server\(|\bcreate_server\(|\bHTTPServer\(|\bAF_INET"
    robots = {"study/robots/agent.py", "study/robots/twin.py"}
    allowed = {"study/foxglove/live_server.py", "study/console/link.py"} | robots
    found = {
        str(path.relative_to(ROOT))
        for path in FILES
        if path.is_relative_to(ROOT / "study") or path.is_relative_to(ROOT / "analysis")
        if re.search(listening, path.read_text())
    }
    assert found == allowed
    for path in robots:
        assert "curve_server = True" in (ROOT / path).read_text()
    assert "AF_UNIX" in (ROOT / "study/console/link.py").read_text()


def test_package_init_files_are_empty() -> None:
    """Importing one module of a package loads no other: the writer starts at once."""
    inits = [path for path in FILES if path.name == "__init__.py"]
    assert inits
    assert [path for path in inits if path.read_text()] == []


def test_no_file_is_long() -> None:
    """One job a file."""
    lengths = {path: len(path.read_text().splitlines()) for path in FILES}
    assert {str(path): lines for path, lines in lengths.items() if lines > MOST_LINES} == {}
