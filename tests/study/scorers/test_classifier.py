"""The classifier: chosen against not chosen, robot by robot."""

from __future__ import annotations

import numpy as np
import pytest
import safetensors.numpy
import statsmodels.api
import torch

from study.errors import StudyError
from study.features import encode, standardisation
from study.scorers import classifier
from study.tasks import navigation

DESCRIPTION = navigation.describe({})


def test_the_loss_is_binary_cross_entropy() -> None:
    """It equals torch's own loss over the available robots."""
    random = np.random.default_rng(0)
    scores = torch.from_numpy(random.normal(0, 4, (30, 5)))
    available = torch.from_numpy(random.random((30, 5)) < 0.7)
    available[:, 1] = True
    chosen = torch.ones(30, dtype=torch.int64)
    labels = torch.nn.functional.one_hot(chosen, 5).double()
    expected = torch.nn.functional.binary_cross_entropy_with_logits(
        scores[available], labels[available]
    )
    loss = classifier.binary_cross_entropy(scores, available, chosen)
    assert float(loss) == pytest.approx(float(expected), abs=1e-12)


def test_a_linear_classifier_equals_logistic_regression() -> None:
    """Coefficients and intercept are statsmodels' to 1e-6."""
    random = np.random.default_rng(3)
    low, high = (0, 0, -3.14, 0), (20, 15, 3.14, 100)
    states = random.uniform(low, high, (300, 4, 4)).astype(np.float32)
    chosen = (random.gumbel(size=(300, 4)) - states[..., 3] / 20).argmax(axis=1)
    arrays = {
        "states": states,
        "available": np.ones((300, 4), np.bool_),
        "chosen": chosen.astype(np.int32),
        "trials": np.zeros(300, np.int32),
    }
    fitted = classifier.fit(arrays, DESCRIPTION, {"hidden": ()}, 0)
    tensors = safetensors.numpy.load(fitted.weights)
    flat, fields = states.reshape(-1, 4), DESCRIPTION.state_fields
    features = encode(flat, fields, standard=standardisation(flat, fields))
    labels = (np.arange(4) == chosen[:, None]).reshape(-1).astype(float)
    reference = statsmodels.api.Logit(labels, statsmodels.api.add_constant(features)).fit(
        disp=False
    )
    ours = [tensors["layer0.bias"][0], *tensors["layer0.weight"][0]]
    assert ours == pytest.approx(np.asarray(reference.params), abs=1e-6)
    assert fitted.metrics["top1"] > 0.4


def test_no_choices_is_said_in_words() -> None:
    """An empty training set is the user's to mend."""
    arrays = {
        "states": np.zeros((0, 4, 4), np.float32),
        "available": np.zeros((0, 4), np.bool_),
        "chosen": np.zeros(0, np.int32),
        "trials": np.zeros(0, np.int32),
    }
    with pytest.raises(StudyError, match="no choices"):
        classifier.fit(arrays, DESCRIPTION, {}, 0)
