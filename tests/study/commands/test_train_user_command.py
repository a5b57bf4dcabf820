"""`study train-user` and `study check-user` as they are typed."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from study.commands import main
from study.errors import StudyError
from study.simulated.trained_user import TrainedUser
from study.training import user


@pytest.fixture(autouse=True)
def _short_rollouts(monkeypatch: pytest.MonkeyPatch) -> None:
    """A hundred updates teach nothing: its rollouts would all last to their end."""
    monkeypatch.setattr(user, "VALUE_TIMESTEPS", 10)


def _said(*words: str) -> str:
    done = CliRunner().invoke(main.app, list(words), catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


@pytest.mark.acceptance
def test_a_user_is_trained_kept_and_checked(tmp_path: Path) -> None:
    """The command in the weights is the one that was given; the check reads them again."""
    weights = tmp_path / "new" / "user.safetensors"
    _said(
        "train-user", "smoke", "--seed", "5", "--updates", "100", "--no-check", "-o", str(weights)
    )
    made_of = TrainedUser.load(weights, "navigation").made_of
    assert made_of["command"] == "study train-user smoke --seed 5 --updates 100"
    assert made_of["training"]["updates"] == 100

    said = _said(
        "check-user", "smoke", "--weights", str(weights), "--robots", "10", "--cell", "0.6"
    )
    assert "Made by study train-user smoke --seed 5 --updates 100" in said
    assert "in 400 states, each measured by the mean of 25 rollouts" in said
    assert "10 episodes from the task's own starts" in said


def test_a_file_that_exists_is_never_overwritten(tmp_path: Path) -> None:
    """It is refused before any training."""
    weights = tmp_path / "user.safetensors"
    weights.write_text("mine")
    with pytest.raises(StudyError, match="exists"):
        _said("train-user", "smoke", "--updates", "100", "-o", str(weights))
    assert weights.read_text() == "mine"
