"""What computes a report: the files of the analysis and the versions of what they use."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from functools import cache
from pathlib import Path

PACKAGES = ("scaled-autonomy", "numpy", "pandas", "scipy", "statsmodels", "pingouin", "jinja2")
_ROOT = Path(__file__).resolve().parent
_SUFFIXES = {".py", ".j2", ".js"}


@cache
def _files() -> tuple[tuple[str, str], ...]:
    paths = sorted(path for path in _ROOT.rglob("*") if path.suffix in _SUFFIXES)
    return tuple(
        (path.relative_to(_ROOT).as_posix(), hashlib.sha256(path.read_bytes()).hexdigest())
        for path in paths
    )


def analysis_files() -> dict[str, str]:
    """Return the SHA-256 of every file of the analysis, by its path within the package."""
    return dict(_files())


def digest(files: dict[str, str]) -> str:
    """Return one SHA-256 for many, hexadecimal."""
    lines = "".join(f"{value}  {name}\n" for name, value in sorted(files.items()))
    return hashlib.sha256(lines.encode()).hexdigest()


def environment() -> dict[str, str]:
    """Return the versions of what computes a report, by name."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found
