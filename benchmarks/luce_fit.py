"""Our fit of Luce's model against xlogit and statsmodels, at equal likelihood.

python -m benchmarks.luce_fit [--quick]

A linear scorer (``hidden = []``) is the conditional logit that both fit. Choices are drawn from
known weights on the scorer's own features. All fit the same choices in turn; the likelihoods
reached are printed beside the times, for a fast fit to a lesser likelihood is no fit. The
scorer's usual network is timed beside them: it is another model, and there its own alternative.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from benchmarks.growth import best_seconds, print_growth, print_row, versions
from benchmarks.made_up_sessions import machine
from study.features import encode, standardisation
from study.scorers import luce
from study.seeding import generator
from study.tasks import navigation

ROBOTS = 4
WEIGHTS = np.array([-1.0, 0.6, 0.8, -0.4, -1.5])
PARAMETERS: dict[str, object] = {}

Fit = Callable[[], float]
"""Fits, and returns the mean log-likelihood of a choice, nats."""


def drawn_choices(count: int) -> dict[str, npt.NDArray[np.generic]]:
    """Return choices among robots spread over the map, as a fit is given them."""
    random = generator(1, "benchmark_choices", count)
    states = navigation.spread_states(PARAMETERS, random, count * ROBOTS)
    states = states.reshape(count, ROBOTS, -1)
    utilities = features_of(states) @ WEIGHTS + random.gumbel(size=(count, ROBOTS))
    return {
        "states": states,
        "available": np.ones((count, ROBOTS), np.bool_),
        "chosen": utilities.argmax(axis=1).astype(np.int32),
        "trials": np.repeat(np.arange(10), -(-count // 10))[:count].astype(np.int32),
    }


def features_of(states: npt.NDArray[np.float32]) -> npt.NDArray[np.float64]:
    """Return the features that the scorer itself makes of states [m, n, d]."""
    fields = navigation.describe(PARAMETERS).state_fields
    flat = states.reshape(-1, states.shape[-1])
    return encode(states, fields, standard=standardisation(flat, fields))


def ours(arrays: dict[str, npt.NDArray[np.generic]], hidden: list[int]) -> Fit:
    """Return our fit."""
    description = navigation.describe(PARAMETERS)
    parameters = {"hidden": hidden, "held_out_fraction": 0.0, "epochs": 10}

    def fit() -> float:
        result = luce.fit(arrays, description, parameters, 1)
        return result.metrics["log_likelihood_per_choice"]

    return fit


def by_statsmodels(arrays: dict[str, npt.NDArray[np.generic]]) -> Fit:
    """Return statsmodels' fit; its default optimiser stops short of the maximum."""
    from statsmodels.discrete.conditional_models import ConditionalLogit  # noqa: PLC0415

    count = len(arrays["chosen"])
    chosen = (np.arange(ROBOTS) == arrays["chosen"][:, None]).astype(np.int64).ravel()
    exog = features_of(arrays["states"]).reshape(count * ROBOTS, -1)
    groups = np.repeat(np.arange(count), ROBOTS)

    def fit() -> float:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = ConditionalLogit(chosen, exog, groups=groups).fit(method="newton", disp=0)
        return float(result.llf) / count

    return fit


def by_xlogit(arrays: dict[str, npt.NDArray[np.generic]]) -> Fit | None:
    """Return xlogit's fit, or None where it is not installed."""
    try:
        from xlogit import MultinomialLogit  # noqa: PLC0415
    except ImportError:
        return None
    count = len(arrays["chosen"])
    chosen = (np.arange(ROBOTS) == arrays["chosen"][:, None]).ravel()
    exog = features_of(arrays["states"]).reshape(count * ROBOTS, -1)
    names = [f"f{number}" for number in range(exog.shape[1])]

    def fit() -> float:
        model = MultinomialLogit()
        model.fit(
            exog,
            chosen,
            varnames=names,
            ids=np.repeat(np.arange(count), ROBOTS),
            alts=np.tile(np.arange(ROBOTS), count),
            verbose=0,
        )
        return float(model.loglikelihood) / count

    return fit


def main() -> None:
    """Measure and print."""
    sizes = [200, 800] if "--quick" in sys.argv else [200, 400, 800, 1600, 3200, 6400]
    print(machine())
    print(versions("torch", "statsmodels", "xlogit"))
    print(f"Luce's model, linear, choices among {ROBOTS} robots, 5 features:")
    times: dict[str, list[float]] = {}
    for size in sizes:
        arrays = drawn_choices(size)
        fits: dict[str, Fit | None] = {
            "ours": ours(arrays, []),
            "statsmodels": by_statsmodels(arrays),
            "xlogit": by_xlogit(arrays),
            "our network (32, 32)": ours(arrays, [32, 32]),
        }
        measured, reached = {}, {}
        for name, fit in fits.items():
            if fit is None:
                print(f"  {name} is not installed: pip install --group benchmarks")
                continue
            reached[name] = fit()
            measured[name] = best_seconds(fit)
            times.setdefault(name, []).append(measured[name])
        mine = measured.pop("ours")
        print_row(f"{size:,}", mine, measured)
        best = max(value for name, value in reached.items() if not name.startswith("our network"))
        short = ", ".join(f"{name} {best - value:.1e}" for name, value in reached.items())
        print(f"{'':17s}log-likelihood a choice {best:.6f} at best; short of it: {short}")
    print("Growth with the number of choices:")
    print_growth(sizes, times)


if __name__ == "__main__":
    main()
