"""Luce's model: the likelihood, its maximum and the scores that come of it."""

from __future__ import annotations

from collections.abc import Iterator
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
import safetensors.numpy
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from statsmodels.discrete.conditional_models import ConditionalLogit

from study.errors import StudyError
from study.features import encode, standardisation
from study.scorers import classifier, luce
from study.scorers._choices import log_probabilities
from study.tasks import navigation

DESCRIPTION = navigation.describe({})
FIELDS = DESCRIPTION.state_fields


def _choices(count: int, robots: int, seed: int) -> dict[str, npt.NDArray[Any]]:
    """Choices of somebody who looks after low healths and the second room."""
    random = np.random.default_rng(seed)
    low, high = (0, 0, -3.14, 0), (20, 15, 3.14, 100)
    states = random.uniform(low, high, (count, robots, 4)).astype(np.float32)
    x, y, heading, health = np.moveaxis(states.astype(np.float64), -1, 0)
    value = 3 * np.exp(-((x - 13) ** 2 + (y - 5) ** 2) / 9) + np.cos(heading) + 2 * (health < 40)
    available = random.random((count, robots)) < 0.8
    available[:, :2] = True
    noisy = np.where(available, value + random.gumbel(size=value.shape), -np.inf)
    return {
        "states": states,
        "available": available,
        "chosen": noisy.argmax(axis=1).astype(np.int32),
        "trials": (np.arange(count) * 8 // count).astype(np.int32),
    }


@pytest.fixture(autouse=True)
def _one_thread() -> Iterator[None]:
    """Fit on one thread, as the fitting process does."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


@settings(max_examples=100)
@given(st.integers(0, 2**32), st.floats(-50, 50))
def test_the_likelihood_is_invariant_to_a_constant(seed: int, constant: float) -> None:
    """A constant added to all scores changes neither the loss nor any probability."""
    random = np.random.default_rng(seed)
    scores = random.normal(0, 5, (20, 6))
    available = random.random((20, 6)) < 0.6
    available[:, 2] = True
    chosen = torch.full((20,), 2)
    losses = [
        luce.negative_log_likelihood(torch.from_numpy(given), torch.from_numpy(available), chosen)
        for given in (scores, scores + constant)
    ]
    assert float(losses[0]) == pytest.approx(float(losses[1]), abs=1e-9)
    logs = log_probabilities(scores, available)
    moved = log_probabilities(scores + constant, available)
    assert logs[available] == pytest.approx(moved[available], abs=1e-9)
    assert np.exp(logs).sum(axis=1) == pytest.approx(np.ones(20))
    assert float(losses[0]) == pytest.approx(-logs[:, 2].mean(), abs=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_linear_scorer_equals_conditional_logit(seed: int) -> None:
    """Coefficients and log-likelihood are statsmodels' to 1e-6."""
    arrays = _choices(400, 5, seed)
    fitted = luce.fit(arrays, DESCRIPTION, {"hidden": ()}, 0)
    coefficients = safetensors.numpy.load(fitted.weights)["layer0.weight"][0]

    available = arrays["available"]
    standard = standardisation(arrays["states"][available], FIELDS)
    features = encode(arrays["states"], FIELDS, standard=standard)[available]
    is_chosen = np.arange(5) == arrays["chosen"][:, None]
    groups = np.broadcast_to(np.arange(400)[:, None], (400, 5))[available]
    model = ConditionalLogit(is_chosen[available].astype(float), features, groups=groups)
    reference = model.fit(method="newton", disp=False)

    total = 400 * fitted.metrics["log_likelihood_per_choice"]
    assert coefficients.dtype == np.float64
    assert coefficients == pytest.approx(np.asarray(reference.params), abs=1e-6)
    assert total == pytest.approx(reference.llf, abs=1e-6)


def test_scores_equal_torch() -> None:
    """The NumPy pass computes what torch computes with the same weights."""
    arrays = _choices(200, 4, 5)
    fitted = luce.fit(arrays, DESCRIPTION, {"epochs": 2}, 0)
    tensors = {
        name: torch.from_numpy(value).double()
        for name, value in safetensors.numpy.load(fitted.weights).items()
    }
    states = arrays["states"].reshape(-1, 4)
    standard = standardisation(arrays["states"][arrays["available"]], FIELDS)
    values = torch.from_numpy(encode(states, FIELDS, standard=standard))
    for layer in range(2):
        weight, bias = tensors[f"layer{layer}.weight"], tensors[f"layer{layer}.bias"]
        values = torch.nn.functional.relu(torch.nn.functional.linear(values, weight, bias))
    last = torch.nn.functional.linear(values, tensors["layer2.weight"], tensors["layer2.bias"])
    scores = luce.load(fitted.weights, DESCRIPTION).scores(states)
    assert scores == pytest.approx(last[:, 0].numpy(), abs=1e-12)


def test_the_fit_learns_and_its_measures_say_so() -> None:
    """On unseen trials a fit to 800 choices explains more than chance and than a line."""
    arrays = _choices(800, 4, 7)
    everything = {"held_out_parts": 5}
    network = luce.fit(arrays, DESCRIPTION, everything, 0).metrics
    linear = luce.fit(arrays, DESCRIPTION, {"hidden": (), **everything}, 0).metrics
    chance = network["held_out_chance_log_likelihood"]
    assert network["held_out_log_likelihood_per_choice"] > chance + 0.2
    assert (
        network["held_out_log_likelihood_per_choice"] > linear["held_out_log_likelihood_per_choice"]
    )
    assert network["held_out_top1"] > 0.5
    assert network["choices"] == 800
    assert network["held_out_choices"] == 800
    assert luce.fit(arrays, DESCRIPTION, {"epochs": 1}, 0).metrics["held_out_choices"] == 200


def test_few_trials_hold_nothing_out() -> None:
    """With two trials all choices are fitted and no held-out measure is claimed."""
    arrays = _choices(60, 4, 8)
    arrays["trials"] = (np.arange(60) // 30).astype(np.int32)
    metrics = luce.fit(arrays, DESCRIPTION, {}, 0).metrics
    assert not [name for name in metrics if name.startswith("held_out")]


def test_unavailable_robots_do_not_matter() -> None:
    """What stands in the place of a robot that could not be chosen changes no weight."""
    arrays = _choices(60, 4, 9)
    first = luce.fit(arrays, DESCRIPTION, {"epochs": 3}, 1)
    arrays["states"] = np.where(arrays["available"][..., None], arrays["states"], np.nan)
    assert luce.fit(arrays, DESCRIPTION, {"epochs": 3}, 1).weights == first.weights


def test_equal_seeds_give_equal_weights() -> None:
    """A fit is decided by its data and seed, and leaves torch's own stream alone."""
    arrays = _choices(60, 4, 10)
    state = torch.get_rng_state()
    first, again, other = (
        luce.fit(arrays, DESCRIPTION, {"epochs": 3}, seed).weights for seed in (4, 4, 5)
    )
    assert first == again
    assert first != other
    assert torch.equal(torch.get_rng_state(), state)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"none": True}, "no choices"),
        ({"nan": True}, "not finite"),
        ({"chosen": 3}, "choice 6 of 20 names robot 4, which was not available"),
        ({"chosen": 4}, "names robot 5"),
        ({"chosen": -1}, "names robot 0"),
    ],
)
def test_what_cannot_be_fitted_is_said_in_words(change: dict[str, int], reason: str) -> None:
    """Empty, unfinite or impossible data raise an error that a person can read."""
    arrays = _choices(20, 4, 12)
    if "none" in change:
        arrays = {name: array[:0] for name, array in arrays.items()}
    if "nan" in change:
        arrays["states"][3, 0, 1] = np.nan
    if "chosen" in change:
        arrays["available"][5, 3] = False
        arrays["chosen"][5] = change["chosen"]
    with pytest.raises(StudyError, match=reason):
        luce.fit(arrays, DESCRIPTION, {}, 0)


@pytest.mark.parametrize("module", [luce, classifier])
def test_a_warm_start_is_as_good_as_a_fit_from_the_beginning(module: ModuleType) -> None:
    """Going on from the first seven trials predicts unseen choices as well as a whole fit."""
    everything = _choices(4000, 4, 11)
    known = {name: values[:2000] for name, values in everything.items()}
    earlier = {name: values[:1750] for name, values in everything.items()}
    prepared = module.fit(earlier, DESCRIPTION, {}, 3).preparation
    cold = module.fit(known, DESCRIPTION, {}, 3)
    warm = module.fit(known, DESCRIPTION, {}, 3, prepared)
    assert (cold.metrics["warm"], warm.metrics["warm"]) == (0.0, 1.0)

    def unseen(weights: bytes) -> float:
        states, available = everything["states"][2000:], everything["available"][2000:]
        scorer = module.load(weights, DESCRIPTION)
        scores = scorer.scores(states.reshape(-1, 4)).reshape(available.shape)
        logs = log_probabilities(scores, available)
        return float(logs[np.arange(2000), everything["chosen"][2000:]].mean())

    by_chance = -np.log(everything["available"][2000:].sum(axis=1)).mean()
    assert unseen(cold.weights) > by_chance + 0.1
    assert unseen(warm.weights) > unseen(cold.weights) - 0.02
