"""How often each test rejects: under a true null, and at a stated effect.

    python -m benchmarks.statistics_error_rates --size quick
    python -m benchmarks.statistics_error_rates --size full --jobs 2 --seed 1

Team reward is simulated as twelve participants run it: two conditions of eight trials, AB/BA,
participants who differ in level and truly differ in the effect of the condition. Under the null
the effects differ from person to person and average zero. Ratings are seven-point answers of
the same people. Three conditions and two factors are simulated beside them, see
`benchmarks.simulated_designs`. Printed are rejections at 5 %, with Wilson's 95 % Monte-Carlo
interval. Equivalence has its null where the others have their effect, and the other way round.
A Bayes factor promises no error rate: printed is how often it exceeds 3, the usual threshold.
"""

from __future__ import annotations

import argparse
import math
import os
import platform
import sys
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")

import joblib
import numpy as np
import pandas as pd
import scipy
from scipy import stats

from analysis.statistics.bayes_factor import BayesFactor, paired_bayes_factor
from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.contrasts import paired_contrasts
from analysis.statistics.crossover import Crossover, crossover
from analysis.statistics.cumulative_link import CumulativeLink, cumulative_link
from analysis.statistics.equivalence import equivalence
from analysis.statistics.friedman import friedman
from analysis.statistics.latin_square import LatinSquare, latin_square
from analysis.statistics.mixed.model import MixedModel, mixed_model
from analysis.statistics.permutation import sign_flip
from analysis.statistics.pooled_trials import condition_and_trial, condition_trial_order
from analysis.statistics.proportion import wilson
from analysis.statistics.result import EffectResult, Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.trial_model import trial_model
from analysis.statistics.wilcoxon import signed_rank
from analysis.statistics.within import within_anova
from benchmarks.simulated_designs import (
    CARRY,
    EFFECT,
    EFFECT_SD,
    FACTORS,
    LEVEL_SD,
    PEOPLE,
    PERIOD,
    TRIAL_SD,
    TRIALS,
    UNEQUAL_SD,
    period_and_carry_over,
    three_conditions,
    two_factors,
)

LEVELS = ("manual", "assisted")
# On the latent scale, in units of its logistic.
RATING_EFFECT, RATING_LEVEL_SD, RATING_EFFECT_SD = 1.5, 1.5, 0.8
CUTS = np.array([-3.0, -1.8, -0.6, 0.6, 1.8, 3.0])
THRESHOLD = 3.0
SIZES = {"quick": 200, "full": 4000}
RECOMMENDED = "recommended"
SENSITIVITY = "sensitivity"
COMPARISON = "comparison only"
NO_RATE = "not an error rate"
SWAPPED = frozenset({"equivalence, bound of the effect"})
"""Whose null hypothesis is the effect of the others."""
TESTS = {
    "paired t on participant means": RECOMMENDED,
    "exact Wilcoxon": RECOMMENDED,
    "sign-flip permutation": RECOMMENDED,
    "mixed model, Kenward-Roger": RECOMMENDED,
    "the same, a fifth of trials missing": RECOMMENDED,
    "mixed model, Satterthwaite": SENSITIVITY,
    "mixed model, random intercept only": COMPARISON,
    "pooled rows, condition + trial": COMPARISON,
    "pooled rows, condition x trial x order": COMPARISON,
    "rating: exact Wilcoxon": RECOMMENDED,
    "rating: F on answers": RECOMMENDED,
    "rating: cumulative-link, likelihood ratio": SENSITIVITY,
    "equivalence, bound of the effect": RECOMMENDED,
    "Bayes factor above 3": NO_RATE,
    "Bayes factor below 1/3": NO_RATE,
    "AB/BA: condition, adjusted for period": SENSITIVITY,
    "AB/BA: period": SENSITIVITY,
    "AB/BA: carry-over": SENSITIVITY,
    "three conditions: RM-ANOVA, corrected": RECOMMENDED,
    "the same, not corrected": COMPARISON,
    "three conditions: Friedman": SENSITIVITY,
    "three conditions: any pair, Holm": RECOMMENDED,
    "Latin squares: condition": SENSITIVITY,
    "the same, unequal scatter": COMPARISON,
    "Latin squares: period": SENSITIVITY,
    "Latin squares: carry-over": SENSITIVITY,
    "two factors: allocation": RECOMMENDED,
    "two factors: fleet size": RECOMMENDED,
    "two factors: interaction": RECOMMENDED,
}


def simulate(effect: float, rating: float, seed: np.random.SeedSequence) -> dict[str, float]:
    """Return the p of each test on one simulated study; NaN where it refuses."""
    generator = np.random.default_rng(seed)
    rows, answers = [], []
    for person in range(PEOPLE):
        who = f"P{person:02d}"
        order = LEVELS if person % 2 == 0 else LEVELS[::-1]
        level = generator.normal(50, LEVEL_SD)
        slope = generator.normal(effect, EFFECT_SD)
        taste = generator.normal(0, RATING_LEVEL_SD)
        gain = generator.normal(rating, RATING_EFFECT_SD)
        for period, condition in enumerate(order, start=1):
            helped = condition == LEVELS[1]
            for trial in range(1, TRIALS + 1):
                reward = level + slope * helped + 0.7 * trial + generator.normal(0, TRIAL_SD)
                rows.append((who, "".join(order), period, condition, trial, reward))
            latent = taste + gain * helped + generator.logistic()
            answers.append((who, condition, 1 + int(np.searchsorted(CUTS, latent))))
    columns = ["participant", "order", "period", "condition", "trial", "team_reward"]
    frame = pd.DataFrame(rows, columns=columns)
    rated = pd.DataFrame(answers, columns=["participant", "condition", "answer"])
    cells = cell_means(frame, "team_reward", LEVELS)
    told = cell_means(rated, "answer", LEVELS)
    model = trial_model(frame, LEVELS)
    fewer = trial_model(frame[generator.random(len(frame)) > 0.2], LEVELS)
    formula = "team_reward ~ condition + trial + (1 | participant)"
    intercept = mixed_model(frame, formula, {"condition": LEVELS})
    ordinal = cumulative_link(rated, LEVELS)
    values = [
        _p(rm_anova(cells)),
        _p(signed_rank(cells.means[:, 1] - cells.means[:, 0], cells.participants)),
        _p(sign_flip(cells)),
        _p(model.test("condition") if isinstance(model, MixedModel) else None),
        _p(fewer.test("condition") if isinstance(fewer, MixedModel) else None),
        _p(model.satterthwaite[0] if isinstance(model, MixedModel) else None),
        _p(intercept.test("condition") if isinstance(intercept, MixedModel) else None),
        _p(condition_and_trial(frame, LEVELS)),
        _p(condition_trial_order(frame, LEVELS)),
        _p(signed_rank(told.means[:, 1] - told.means[:, 0], told.participants)),
        _p(rm_anova(told)),
        _p(ordinal.test if isinstance(ordinal, CumulativeLink) else None),
    ]
    orders = {f"P{n:02d}": LEVELS if n % 2 == 0 else LEVELS[::-1] for n in range(PEOPLE)}
    values += _two_conditions(cells, frame, orders, effect)
    values += _three_conditions(effect, generator)
    values += [_p(outcome) for outcome in _two_factors(effect, generator)]
    return dict(zip(TESTS, values, strict=True))


def _two_conditions(
    cells: Cells, frame: pd.DataFrame, orders: dict[str, tuple[str, ...]], effect: float
) -> list[float]:
    bayes = paired_bayes_factor(cells)
    bf10 = bayes.bf10 if isinstance(bayes, BayesFactor) else math.nan
    shifted = frame.copy()
    present = effect > 0  # of the condition, and then of period and carry-over too
    period_and_carry_over(shifted, LEVELS[0], PERIOD if present else 0.0, 0.0)
    periods = crossover(cell_means(shifted, "team_reward", LEVELS), orders)
    period_and_carry_over(shifted, LEVELS[0], 0.0, CARRY if present else 0.0)
    left = crossover(cell_means(shifted, "team_reward", LEVELS), orders)
    return [
        _p(equivalence(cells, EFFECT)),
        float(bf10 <= THRESHOLD),  # 0 where it is exceeded, so that it counts as p below 5 %
        float(bf10 >= 1 / THRESHOLD),
        _p(periods.condition if isinstance(periods, Crossover) else None),
        _p(periods.period if isinstance(periods, Crossover) else None),
        _p(left.carry_over if isinstance(left, Crossover) else None),
    ]


def _three_conditions(effect: float, generator: np.random.Generator) -> list[float]:
    cells, _ = three_conditions(effect, generator, UNEQUAL_SD)
    several = rm_anova(cells)
    uncorrected = math.nan
    if isinstance(several, EffectResult):
        uncorrected = float(stats.f.sf(several.statistic, 2, 2 * (PEOPLE - 1)))
    pairs = [test.p_adjusted for test in paired_contrasts(cells) if isinstance(test, EffectResult)]
    alike = (EFFECT_SD / math.sqrt(2),) * 3
    period, carry = (PERIOD, CARRY) if effect > 0 else (0.0, 0.0)
    plain = latin_square(*three_conditions(effect, generator, alike))
    unequal = latin_square(*three_conditions(effect, generator, UNEQUAL_SD))
    carried = latin_square(*three_conditions(effect, generator, alike, period, carry))
    return [
        _p(several),
        uncorrected,
        _p(friedman(cells)),
        min((p for p in pairs if p is not None), default=math.nan),
        _p(plain.condition if isinstance(plain, LatinSquare) else None),
        _p(unequal.condition if isinstance(unequal, LatinSquare) else None),
        _p(carried.period if isinstance(carried, LatinSquare) else None),
        _p(carried.carry_over if isinstance(carried, LatinSquare) else None),
    ]


def _two_factors(effect: float, generator: np.random.Generator) -> list[Outcome]:
    outcomes = within_anova(two_factors(effect, generator), "reward", FACTORS)
    return [outcomes] * 3 if isinstance(outcomes, Refusal) else list(outcomes)


def _p(outcome: Outcome | None) -> float:
    return outcome.p if isinstance(outcome, EffectResult) else math.nan


def main() -> int:
    """Simulate, print, and fail where a recommended test exceeds 5 % beyond Monte-Carlo error."""
    parser = argparse.ArgumentParser(description="Rejection rates of the tests of the report.")
    parser.add_argument("--size", choices=sorted(SIZES), default="quick")
    parser.add_argument("--studies", type=int, help="simulated studies, in place of the size's")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    count = given.studies or SIZES[given.size]
    started = time.perf_counter()
    null_seeds, effect_seeds = (s.spawn(count) for s in np.random.SeedSequence(given.seed).spawn(2))
    work = [joblib.delayed(simulate)(0.0, 0.0, seed) for seed in null_seeds]
    work += [joblib.delayed(simulate)(EFFECT, RATING_EFFECT, seed) for seed in effect_seeds]
    found = joblib.Parallel(n_jobs=given.jobs, batch_size=8)(work)
    null, effect = pd.DataFrame(found[:count]), pd.DataFrame(found[count:])
    for test in SWAPPED:
        null[test], effect[test] = effect[test].copy(), null[test].copy()
    print(f"Python {platform.python_version()}, NumPy {np.__version__}, SciPy {scipy.__version__},")
    print(f"pandas {pd.__version__}; seed {given.seed}; {count} studies under each hypothesis")
    print(f"{PEOPLE} participants, 2 x {TRIALS} trials; standard deviations: level {LEVEL_SD:g},")
    print(f"effect {EFFECT_SD:g}, trial {TRIAL_SD:g}; effect {EFFECT:g} points a trial, ratings")
    print(f"{RATING_EFFECT:g} log odds (level {RATING_LEVEL_SD:g}, effect {RATING_EFFECT_SD:g});")
    print(f"period {PERIOD:g}, carry-over {CARRY:g} points where they are tested; three conditions")
    print(f"scatter unequally ({', '.join(f'{sd:g}' for sd in UNEQUAL_SD)}); two factors 2 x 3\n")
    print(f"{'':43}{'null true: rejects':>22}{'effect: power':>15}{'refused':>9}")
    wrong = []
    for test, role in TESTS.items():
        ps, qs = null[test].dropna(), effect[test].dropna()
        hits = int((ps < 0.05).sum())
        bounds = wilson(hits / max(len(ps), 1), len(ps))
        low, high = bounds.low, bounds.high
        rate, power = hits / max(len(ps), 1), float((qs < 0.05).mean())
        shown = f"{100 * rate:5.1f} % [{100 * low:4.1f}, {100 * high:4.1f}]"
        refused = f"{count - len(ps)}, {count - len(qs)}"
        print(f"{test:43}{shown:>22}{100 * power:13.1f} %{refused:>9}  {role}")
        if role == RECOMMENDED and low > 0.05:
            wrong.append(test)
    print(f"\n{time.perf_counter() - started:.0f} s with {given.jobs} processes")
    if wrong:
        print(f"More than 5 % beyond Monte-Carlo error: {', '.join(wrong)}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
