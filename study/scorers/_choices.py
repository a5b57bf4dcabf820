"""Choice sets as training data, and how well scores explain them."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from study.errors import StudyError
from study.policies.base import Arrays

Floats = npt.NDArray[np.float64]


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


def held_out_rows(
    choices: Choices, fraction: float, random: np.random.Generator
) -> npt.NDArray[np.bool_] | None:
    """Draw whole trials to hold out.

    Timesteps of one trial resemble each other, so rows of a trial never go to both sides.

    Args:
        choices: the data.
        fraction: of the trials; at least one is held out and at least two are kept.
        random: the stream to draw from.

    Returns:
        bool [m], or None with fewer than three trials or a fraction of 0.
    """
    trials = np.unique(choices.trials)
    if len(trials) < 3 or not fraction:
        return None
    count = min(max(1, round(fraction * len(trials))), len(trials) - 2)
    held_out: npt.NDArray[np.bool_] = np.isin(
        choices.trials, random.choice(trials, count, replace=False)
    )
    return held_out


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
    scores the lower index).
    """
    logs = log_probabilities(scores, choices.available)
    masked = np.where(choices.available, scores, -np.inf)
    return {
        "log_likelihood_per_choice": float(logs[np.arange(len(choices)), choices.chosen].mean()),
        "chance_log_likelihood": float(-np.log(choices.available.sum(axis=1)).mean()),
        "top1": float((masked.argmax(axis=1) == choices.chosen).mean()),
    }
