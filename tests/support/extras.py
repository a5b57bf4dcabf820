"""Skips, aloud, what needs an extra that is not installed."""

from __future__ import annotations

import importlib.util

import pytest


def need(*modules: str) -> None:
    """Skip the test, or the whole file, unless all modules are installed; import none of them."""
    missing = [name for name in modules if importlib.util.find_spec(name) is None]
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)}", allow_module_level=True)
