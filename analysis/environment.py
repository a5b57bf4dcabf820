"""What computes a report or an export: the versions of the packages it uses."""

from __future__ import annotations

import importlib.metadata
import platform

PACKAGES = ("scaled-autonomy", "numpy", "pandas", "scipy", "statsmodels", "pingouin")


def version_of(package: str) -> str | None:
    """Return a package's version; None if it is not installed."""
    try:
        return importlib.metadata.version(package)
    except importlib.metadata.PackageNotFoundError:
        return None


def environment() -> dict[str, str]:
    """Return the versions of what computes an export, by name."""
    found = {name: version_of(name) or "not installed" for name in (*PACKAGES, "jinja2")}
    return {"python": platform.python_version(), **found}
