"""Where the layout for Foxglove is that is shipped with this program."""

from __future__ import annotations

from pathlib import Path


def layout_path() -> Path:
    """Return the layout file: Foxglove's own JSON, to be imported there."""
    return Path(__file__).with_name("layout.json")
