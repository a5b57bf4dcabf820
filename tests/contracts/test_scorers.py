"""Every scorer keeps the scorer contract."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from patience import PATIENCE_S
from study.families import known_members, load_member
from study.map_grid import score_grid
from study.policies.base import FitResult
from study.tasks import navigation

DESCRIPTION = navigation.describe({})
QUICK = {"epochs": 3}


def _choices(count: int) -> dict[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]]:
    random = np.random.default_rng(0)
    low, high = (0, 0, -3.14, 0), (20, 15, 3.14, 100)
    return {
        "states": random.uniform(low, high, (count, 4, 4)).astype(np.float32),
        "available": np.ones((count, 4), np.bool_),
        "chosen": random.integers(0, 4, count).astype(np.int32),
        "trials": (np.arange(count) // 10).astype(np.int32),
    }


@pytest.fixture(params=known_members("study.scorers"))
def name(request: pytest.FixtureRequest) -> str:
    """The name of one scorer."""
    return str(request.param)


def _fit(name: str) -> FitResult:
    module = load_member("study.scorers", "scorer", name)
    choices = _choices(40)
    if name == "recorded":
        choices["weights"] = np.frombuffer(_fit("luce").weights, np.uint8)
    fitted: FitResult = module.fit(choices, DESCRIPTION, {} if _is_control(name) else QUICK, 3)
    return fitted


def _is_control(name: str) -> bool:
    """Whether a scorer learns nothing from the operator."""
    return bool(getattr(load_member("study.scorers", "scorer", name), "IS_CONTROL", False))


def test_modules_offer_the_family_interface(name: str) -> None:
    """A scorer's module has parameters with descriptions, ``fit`` and ``load``."""
    module = load_member("study.scorers", "scorer", name)
    for field in module.Parameters.model_fields.values():
        assert field.description
    assert callable(module.fit)
    assert callable(module.load)


def test_scores_are_one_number_a_state(name: str) -> None:
    """Float64 scores, finite, each decided by its own state alone unless the scorer remembers."""
    module = load_member("study.scorers", "scorer", name)
    scorer = module.load(_fit(name).weights, DESCRIPTION)
    states = _choices(10)["states"].astype(np.float32).reshape(-1, 4)
    scores = scorer.scores(states)
    assert scores.shape == (40,)
    assert scores.dtype == np.float64
    assert np.isfinite(scores).all()
    if hasattr(scorer, "begin"):
        return
    assert scorer.scores(states[3:4])[0] == pytest.approx(scores[3], abs=1e-12)
    assert np.isfinite(score_grid(scorer, DESCRIPTION)).all()


def test_a_fit_repeats_and_measures(name: str) -> None:
    """Equal data and seed give equal bytes; held-out and chance measures are there."""
    first, second = _fit(name), _fit(name)
    assert first.weights == second.weights
    if _is_control(name):
        assert first.metrics == {}
        return
    assert all(np.isfinite(value) for value in first.metrics.values())
    expected = {"log_likelihood_per_choice", "chance_log_likelihood", "top1", "choices"}
    assert expected <= set(first.metrics)
    assert "held_out_log_likelihood_per_choice" in first.metrics


def test_scoring_needs_no_torch(name: str, tmp_path: Path) -> None:
    """A process that loads weights and scores with them has neither torch nor pygame."""
    weights = tmp_path / "weights"
    weights.write_bytes(_fit(name).weights)
    check = (
        "import sys, pathlib, numpy; from study.families import load_member;"
        "from study.tasks import navigation;"
        f"module = load_member('study.scorers', 'scorer', {name!r});"
        f"weights = pathlib.Path({str(weights)!r}).read_bytes();"
        "scorer = module.load(weights, navigation.describe({}));"
        "assert scorer.scores(numpy.ones((3, 4), numpy.float32)).shape == (3,);"
        "assert not {'torch', 'pygame'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", check], check=True, timeout=PATIENCE_S)
