"""Team reward by the factors that conditions cross: main effects, interactions, simple effects."""

from __future__ import annotations

import dataclasses
import itertools

import pandas as pd

from analysis.factors import Crossing
from analysis.statistics.cells import Cells
from analysis.statistics.holm import holm_of
from analysis.statistics.mixed.model import MixedModel
from analysis.statistics.result import EffectResult, Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.trial_model import trial_model
from analysis.statistics.within import within_anova


@dataclasses.dataclass(frozen=True, slots=True)
class Factorial:
    """The effects of crossed factors.

    Attributes:
        crossing: the factors.
        means: each effect on the participants' means, Holm-adjusted over the effects.
        trials: the same in the mixed model of the trials; primary where trials are missing.
        simple: each pair of levels of one factor at each cell of the others, Holm-adjusted over
            all of these.
    """

    crossing: Crossing
    means: tuple[Outcome, ...]
    trials: tuple[Outcome, ...]
    simple: tuple[Outcome, ...]

    def effects(self, *, by_trial: bool) -> tuple[EffectResult, ...]:
        """Return the effects that words go by, where they were computed."""
        chosen = self.trials if by_trial else self.means
        return tuple(effect for effect in chosen if isinstance(effect, EffectResult))


def factorial(crossing: Crossing | None, trials: pd.DataFrame, cells: Cells) -> Factorial | None:
    """Test every main effect and interaction of team reward; None where nothing is crossed.

    Args:
        crossing: the factors that the conditions cross.
        trials: rows that enter, of any participant.
        cells: participants' means under every condition.
    """
    if crossing is None:
        return None
    factors = crossing.levels
    rows = trials[trials["condition"].isin(list(crossing.cells))]
    names = rows["condition"].astype("str")
    placed = {
        factor: names.map({name: cell[place] for name, cell in crossing.cells.items()})
        for place, factor in enumerate(factors)
    }
    period = rows["block"].astype("int64")
    model = trial_model(rows.assign(**placed, period=period), list(crossing.cells), crossed=factors)
    return Factorial(
        crossing=crossing,
        means=_adjusted(effects_of_means(crossing, cells)),
        trials=_adjusted(_of_trials(crossing, model)),
        simple=_adjusted(_simple(crossing, cells)),
    )


def effects_of_means(crossing: Crossing, cells: Cells) -> list[Outcome]:
    """Test every main effect and interaction on participants' means, by the factors' labels.

    Args:
        crossing: the factors that the conditions cross.
        cells: participants' means under every condition.

    Returns:
        The effects, main effects first; one refusal if all are refused together.
    """
    factors = list(crossing.levels)
    rows = [
        {"participant": who, **dict(zip(factors, cell, strict=True)), "mean": mean}
        for who, means in zip(cells.participants, cells.means, strict=True)
        for cell, mean in zip((crossing.cells[c] for c in cells.levels), means, strict=True)
    ]
    frame = pd.DataFrame(rows, columns=["participant", *factors, "mean"]).astype({"mean": float})
    name = "Effects of factors on participant means"
    found = within_anova(frame, "mean", crossing.levels, name)
    if isinstance(found, Refusal):
        return [dataclasses.replace(found, excluded=cells.excluded)]
    named = [
        dataclasses.replace(
            effect,
            name=crossing.label(effect.name.removeprefix(f"{name}: ")),
            excluded=cells.excluded,
        )
        for effect in found
    ]
    return [
        dataclasses.replace(e, role="primary") if isinstance(e, EffectResult) else e for e in named
    ]


def _of_trials(crossing: Crossing, model: MixedModel | Refusal) -> list[Outcome]:
    if isinstance(model, Refusal):
        return [model]
    sizes = range(1, len(crossing.factors) + 1)
    terms = [
        ":".join(chosen)
        for size in sizes
        for chosen in itertools.combinations(crossing.levels, size)
    ]
    return [
        dataclasses.replace(model.test(term), name=f"{crossing.label(term)}, mixed model")
        for term in terms
    ]


def _simple(crossing: Crossing, cells: Cells) -> list[Outcome]:
    found: list[Outcome] = []
    for place, factor in enumerate(crossing.factors):
        others = [f for f in crossing.factors if f is not factor]
        labels = dict(zip(factor.levels, factor.level_labels, strict=True))
        for rest in itertools.product(*(f.levels for f in others)):
            where = ", ".join(
                f.level_labels[f.levels.index(level)] for f, level in zip(others, rest, strict=True)
            )
            for a, b in itertools.combinations(factor.levels, 2):
                pair = [
                    crossing.condition((*rest[:place], level, *rest[place:])) for level in (a, b)
                ]
                name = f"{labels[b]} − {labels[a]}, at {where}"
                found.append(rm_anova(cells.keep(pair), name, "sensitivity"))
    return found


def _adjusted(outcomes: list[Outcome]) -> tuple[Outcome, ...]:
    return tuple(
        dataclasses.replace(outcome, p_adjusted=p) if isinstance(outcome, EffectResult) else outcome
        for outcome, p in zip(outcomes, holm_of(outcomes), strict=True)
    )
