"""What computes a report or an export: the analysis' own files and the packages it uses."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping
from functools import cache
from pathlib import Path

PACKAGES = ("scaled-autonomy", "numpy", "pandas", "scipy", "statsmodels", "pingouin")
_ROOT = Path(__file__).resolve().parent
_SUFFIXES = {".py", ".j2", ".js"}


def version_of(package: str) -> str | None:
    """Return a package's version; None if it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def environment() -> dict[str, str]:
    """Return the versions of what computes a report, by name."""
    found = {name: version_of(name) or "not installed" for name in (*PACKAGES, "jinja2")}
    return {"python": platform.python_version(), **found}


@cache
def analysis_files() -> Mapping[str, str]:
    """Return the SHA-256 of every file of the analysis, by its path within the package."""
    paths = sorted(path for path in _ROOT.rglob("*") if path.suffix in _SUFFIXES)
    return {
        path.relative_to(_ROOT).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in paths
    }


def digest(files: Mapping[str, str]) -> str:
    """Return one SHA-256 for many, hexadecimal."""
    lines = "".join(f"{value}  {name}\n" for name, value in sorted(files.items()))
    return hashlib.sha256(lines.encode()).hexdigest()
