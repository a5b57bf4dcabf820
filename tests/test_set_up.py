"""Set-up closes the folders for participants' data to others."""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path
from types import ModuleType

import pytest

from protocols import ROOT


@pytest.fixture
def set_up() -> ModuleType:
    """The script, which is no package's."""
    spec = importlib.util.spec_from_file_location("set_up", ROOT / "tools" / "set_up.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif(os.name != "posix", reason="rights of POSIX")
@pytest.mark.parametrize(
    ("found", "left"), [(0o755, 0o700), (0o775, 0o700), (0o770, 0o770), (0o700, 0o700)]
)
def test_folders_that_everybody_may_look_into_are_closed(
    tmp_path: Path, set_up: ModuleType, found: int, left: int
) -> None:
    """What a lab shares with a group on purpose is left alone; so is a folder that is not there."""
    folder = tmp_path / "recordings"
    folder.mkdir()
    folder.chmod(found)
    set_up.make_private(tmp_path)
    assert folder.stat().st_mode & 0o777 == left
