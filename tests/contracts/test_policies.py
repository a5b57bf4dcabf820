"""Every policy keeps the policy contract."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from patience import PATIENCE_S
from study.families import known_members, load_member
from study.policies.base import FitResult, Policy
from study.tasks import navigation

DESCRIPTION = navigation.describe({})


def _demonstrations(count: int) -> dict[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]]:
    random = np.random.default_rng(0)
    low, high = (0, 0, -3.14, 0), (20, 15, 3.14, 100)
    return {
        "states": random.uniform(low, high, (count, 4)).astype(np.float32),
        "actions": random.integers(0, 4, count).astype(np.int32),
    }


@pytest.fixture(params=known_members("study.policies"))
def name(request: pytest.FixtureRequest) -> str:
    """The name of one policy."""
    return str(request.param)


def _policy(name: str) -> Policy:
    """The policy, fitted if it is one that is fitted."""
    module = load_member("study.policies", "policy", name)
    if hasattr(module, "create"):
        made: Policy = module.create(DESCRIPTION)
        return made
    fitted = module.fit(_demonstrations(200), DESCRIPTION, {}, 3)
    loaded: Policy = module.load(fitted.weights, DESCRIPTION)
    return loaded


def test_modules_offer_the_family_interface(name: str) -> None:
    """A policy's module has parameters with descriptions, and is either made or fitted."""
    module = load_member("study.policies", "policy", name)
    for field in module.Parameters.model_fields.values():
        assert field.description
    fitted = hasattr(module, "fit") and hasattr(module, "load")
    assert fitted != hasattr(module, "create")


@pytest.mark.parametrize("count", [1, 12])
def test_actions_are_whole_numbers_of_actions(name: str, count: int) -> None:
    """An int32 action that the task knows comes back for each state."""
    states = _demonstrations(count)["states"].astype(np.float32)
    actions = _policy(name).actions(states, np.random.default_rng(0))
    assert actions.shape == (count,)
    assert actions.dtype == np.int32
    assert set(actions.tolist()) <= set(range(len(DESCRIPTION.action_names)))
    assert DESCRIPTION.idle_action not in actions


def test_equal_streams_give_equal_actions(name: str) -> None:
    """Fitted and asked twice from equal seeds, a policy answers the same."""
    states = _demonstrations(50)["states"].astype(np.float32)
    first, second = (
        _policy(name).actions(states, np.random.default_rng(8)).tolist() for _ in range(2)
    )
    assert first == second


def test_a_fit_repeats_and_measures(name: str) -> None:
    """Equal data and seed give equal bytes, and the measures are finite."""
    module = load_member("study.policies", "policy", name)
    if not hasattr(module, "fit"):
        pytest.skip("is not fitted")
    first, second = (module.fit(_demonstrations(50), DESCRIPTION, {}, 3) for _ in range(2))
    assert isinstance(first, FitResult)
    assert first.weights == second.weights
    assert all(np.isfinite(value) for value in first.metrics.values())


def test_acting_needs_no_torch(name: str) -> None:
    """Importing a policy, loading included, brings in neither torch nor pygame."""
    check = (
        "import sys; from study.families import load_member;"
        f"module = load_member('study.policies', 'policy', {name!r});"
        "assert not {'torch', 'pygame'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", check], check=True, timeout=PATIENCE_S)
