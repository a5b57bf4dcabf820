"""Choice sets as training data, and how well scores explain them."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.policies.base import Arrays

Floats = npt.NDArray[np.float64]

CALIBRATION_BINS = 10
"""Bins of predicted probability, each 0.1 wide."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Choices:
    """m choices, each among up to n robots.

    Attributes:
        states: float32 [m, n, d]; 0 where not available.
        available: bool [m, n].
        chosen: int64 [m].
        trials: int64 [m], which trial each belongs to.
    """

    states: npt.NDArray[np.float32]
    available: npt.NDArray[np.bool_]
    chosen: npt.NDArray[np.int64]
    trials: npt.NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.chosen)

    def rows(self, which: npt.NDArray[np.bool_]) -> Choices:
        """Return the choices in ``which``, bool [m]."""
        return Choices(
            self.states[which], self.available[which], self.chosen[which], self.trials[which]
        )


def validated_choices(arrays: Arrays) -> Choices:
    """Check training data as `study.session.effects.RequestFit` describes it.

    Raises:
        StudyError: there are no rows, an available robot's state is not finite, or a chosen
            robot was not available.
    """
    states = arrays["states"].astype(np.float32)
    available = arrays["available"].astype(np.bool_)
    chosen = arrays["chosen"].astype(np.int64)
    trials = arrays["trials"].astype(np.int64)
    if not len(chosen):
        raise StudyError(
            "there are no choices to fit the scorer to",
            "Choose robots by hand for a few timesteps before the scorer is fitted.",
        )
    if not np.isfinite(states[available]).all():
        raise StudyError("a state among the choices holds a number that is not finite")
    robots = states.shape[1]
    rows = np.arange(len(chosen))
    listed = (chosen >= 0) & (chosen < robots)
    allowed = listed & available[rows, np.where(listed, chosen, 0)]
    if not allowed.all():
        row = int(np.flatnonzero(~allowed)[0])
        raise StudyError(
            f"choice {row + 1} of {len(chosen)} names robot {int(chosen[row]) + 1}, "
            f"which was not available (of {robots} robots)"
        )
    states = np.where(available[:, :, None], states, np.float32(0))
    return Choices(states, available, chosen, trials)


def held_out_parts(
    choices: Choices, fraction: float, parts: int, random: np.random.Generator
) -> list[npt.NDArray[np.bool_]]:
    """Choose whole trials to hold out: disjoint parts of them, to be held out in turn.

    Timesteps of one trial resemble each other, so rows of a trial never go to both sides. Every
    k-th trial belongs to the same part, and which part comes first is drawn; so the part of a
    trial does not change when further trials follow, and a fit to all but a part can go on from
    one that was made before they did.

    Args:
        choices: the data.
        fraction: of the trials in one part, about: k is its reciprocal, rounded.
        parts: how many parts are held out at most.
        random: the stream to draw from.

    Returns:
        bool [m] for each part that holds trials; none with fewer than three trials or a
        fraction of 0. At least two trials are left outside each part of three or more.
    """
    trials, places = np.unique(choices.trials, return_inverse=True)
    if len(trials) < 3 or not fraction:
        return []
    every = max(2, round(1 / fraction))
    # With every second of three trials, two would be held out and one left: begin with the other.
    first = 1 if every == 2 else int(random.integers(min(every, 3)))
    numbers = [(first + part) % every for part in range(min(parts, every))]
    return [np.asarray(places % every == number) for number in numbers if number < len(trials)]


def log_probabilities(scores: Floats, available: npt.NDArray[np.bool_]) -> Floats:
    """Return Luce's log-probability of every robot: log softmax over those available.

    The paper's choice model: robot i is chosen with probability
    exp(phi(s_i)) / sum_j exp(phi(s_j)). A constant added to all scores changes nothing.

    Args:
        scores: float64 [m, n].
        available: bool [m, n], at least one in each row.

    Returns:
        float64 [m, n]; minus infinity where not available.
    """
    masked = np.where(available, scores, -np.inf)
    shifted = masked - masked.max(axis=1, keepdims=True)
    logs: Floats = shifted - np.log(np.exp(shifted).sum(axis=1, keepdims=True))
    return logs


def fit_metrics(scores: Floats, choices: Choices) -> dict[str, float]:
    """Return how well scores [m, n] explain the choices, by the measure's name.

    ``log_likelihood_per_choice`` in nats; ``chance_log_likelihood`` the same for choosing
    with equal chances; ``top1`` the part of choices that fell on the highest score (of equal
    scores the lower index); ``chance_top1`` the same for choosing with equal chances.
    """
    logs = log_probabilities(scores, choices.available)
    offered = choices.available.sum(axis=1)
    return {
        "log_likelihood_per_choice": float(logs[np.arange(len(choices)), choices.chosen].mean()),
        "chance_log_likelihood": float(-np.log(offered).mean()),
        "top1": float(_hits(scores, choices).mean()),
        "chance_top1": float((1 / offered).mean()),
    }


def _hits(scores: Floats, choices: Choices) -> npt.NDArray[np.bool_]:
    masked = np.where(choices.available, scores, -np.inf)
    hits: npt.NDArray[np.bool_] = masked.argmax(axis=1) == choices.chosen
    return hits


def trial_metrics(scores: Floats, choices: Choices) -> dict[str, float]:
    """Return the measures of each trial by itself, named ``trial_<id>_<measure>``.

    Choices of one trial resemble each other, so an interval has to be made of trials.
    """
    found: dict[str, float] = {}
    for trial in np.unique(choices.trials):
        which = choices.trials == trial
        rows = choices.rows(which)
        found[f"trial_{trial}_choices"] = float(len(rows))
        measures = fit_metrics(scores[which], rows)
        found |= {f"trial_{trial}_{name}": value for name, value in measures.items()}
    return found


def calibration(scores: Floats, choices: Choices) -> dict[str, float]:
    """Return how far predicted probabilities of being chosen are those that came true.

    The probabilities of all robots that could be chosen are sorted into bins of equal width;
    ``calibration_error`` is the mean over robots of the distance between a bin's mean prediction
    and the share of its robots that was chosen (expected calibration error; Naeini, Cooper and
    Hauskrecht, AAAI 2015). ``calibration_bin_<number>_<measure>`` has each bin's number of
    robots, mean prediction and share chosen; empty bins are left out.
    """
    predicted = np.exp(log_probabilities(scores, choices.available))[choices.available]
    is_chosen = np.arange(scores.shape[1]) == choices.chosen[:, None]
    came_true = is_chosen[choices.available].astype(np.float64)
    bins = np.minimum((predicted * CALIBRATION_BINS).astype(np.int64), CALIBRATION_BINS - 1)
    found: dict[str, float] = {"calibration_error": 0.0}
    for number in np.unique(bins):
        inside = bins == number
        mean, share = float(predicted[inside].mean()), float(came_true[inside].mean())
        found["calibration_error"] += float(inside.mean()) * abs(mean - share)
        name = f"calibration_bin_{number + 1}"
        found |= {
            f"{name}_robots": float(inside.sum()),
            f"{name}_predicted": mean,
            f"{name}_chosen": share,
        }
    return found
