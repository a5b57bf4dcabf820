"""Set up the project: a virtual environment in .venv with exactly what the lock names.

Runs on any Python from 3.11 on, with nothing installed. Every package but torch is checked
against its hash; torch is pinned to its version, and on Linux its CPU build is preferred.

    python3 tools/set_up.py              all that the lock names
    python3 tools/set_up.py doom jetbot  these extras as well, each from a lock of its own
"""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VENV = ROOT / ".venv"
STAMP = VENV / ".set-up"
LOCK = ROOT / "requirements" / "lock.txt"
TORCH = ROOT / "requirements" / "torch.txt"
PRIVATE = ("recordings", "reports")
"""Folders for participants' data: git keeps no rights, and a clone lets everyone list them."""
EXTRAS = ("doom", "jetbot")
"""Extras that have a lock of their own, requirements/NAME.txt."""
OLDEST = (3, 11)


def main() -> int:
    """Set up, with the extras named."""
    if sys.version_info < OLDEST:
        given = ".".join(str(part) for part in sys.version_info[:3])
        print(f"Python {given} is too old; use 3.11 or newer: make PYTHON=python3.12 ...")
        return 2
    if unknown := [name for name in sys.argv[1:] if name not in EXTRAS]:
        print(f"Unknown: {', '.join(unknown)}. With a lock of their own: {', '.join(EXTRAS)}.")
        return 2
    make_private(ROOT)
    set_up()
    for name in sys.argv[1:]:
        print(f"Extra: {name}", flush=True)
        pip("install", "--require-hashes", "-r", str(ROOT / "requirements" / f"{name}.txt"))
    return 0


def set_up() -> None:
    """Make the environment, unless it is there and the lock has not changed."""
    wanted = fingerprint()
    if STAMP.is_file() and STAMP.read_text() == wanted:
        STAMP.touch()
        return
    print("Setting up .venv (once; some minutes on a slow line) ...", flush=True)
    if not python().is_file():
        venv.create(VENV, with_pip=True)
    print("1 of 3: the locked packages", flush=True)
    pip("install", "--require-hashes", "-r", str(LOCK))
    print("2 of 3: torch", flush=True)
    # The index of CPU builds is a convenience: if it does not answer, do not wait for it.
    pip("install", "--no-deps", "--retries", "1", "-r", str(TORCH))
    print("3 of 3: this project", flush=True)
    # The lock has what the extras need too, so that each of them works.
    pip("install", "--no-deps", "--no-build-isolation", "-e", str(ROOT))
    STAMP.write_text(wanted)


def make_private(root: Path) -> None:
    """Keep others out of the folders for participants' data.

    A folder that not everybody may look into has rights that somebody chose: it is left alone.
    """
    for name in PRIVATE:
        folder = root / name
        if os.name == "posix" and folder.is_dir() and folder.stat().st_mode & 0o007:
            folder.chmod(0o700)


def fingerprint() -> str:
    """Return a hash of all that decides what is installed."""
    digest = hashlib.sha256()
    for path in (LOCK, TORCH, ROOT / "pyproject.toml"):
        digest.update(path.read_bytes())
    return f"{sys.version_info[0]}.{sys.version_info[1]} {digest.hexdigest()}\n"


def python() -> Path:
    """Return the environment's interpreter."""
    return VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def pip(*arguments: str) -> None:
    """Run pip in the environment; stop with its message if it fails."""
    command = [str(python()), "-m", "pip", "--disable-pip-version-check", "--quiet"]
    done = subprocess.run([*command, *arguments], check=False)
    if done.returncode:
        sys.exit(f"Set-up failed at: pip {' '.join(arguments)}")


if __name__ == "__main__":
    sys.exit(main())
