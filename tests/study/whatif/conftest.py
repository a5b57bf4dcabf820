"""A study whose participants choose by scorers that are known."""

from __future__ import annotations

from pathlib import Path

import pytest

from choosing_study import choosing_study
from study.commands.whatif import open_sessions
from study.whatif.sessions import ChoiceSession


@pytest.fixture(scope="session")
def choosing_files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Six recordings, one a participant."""
    return choosing_study(tmp_path_factory.mktemp("choosing"), 6, trials=4, timesteps=40)


@pytest.fixture(scope="session")
def sessions(choosing_files: list[Path]) -> list[ChoiceSession]:
    """The choices in them."""
    return open_sessions(choosing_files)
