"""What the trials of a pilot say about effect and scatter, with how little is known of it.

The estimates are those of the report's model of the trials. The interval of the effect is the
model's; that of the trials' scatter is of chi-squared; that of the scatter between participants
is Williams's (1962, Biometrika 49, 278-281), conservative: about 90 % to 95 %.
"""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import pandas as pd
from scipy import stats

from analysis.data_label import data_label
from analysis.measures import analysed_data
from analysis.planning.assumptions import Assumptions
from analysis.protocol_facts import protocol_facts
from analysis.recordings import load_recordings
from analysis.robustness import model_of_trials
from analysis.statistics.mixed.model import Coefficient, MixedModel
from analysis.statistics.result import Interval, Refusal
from analysis.tables.study_tables import StudyTables
from study.errors import StudyError

HINT = "Give --effect, --effect-sd and --trial-sd instead, or a larger pilot."


@dataclasses.dataclass(frozen=True, slots=True)
class Estimate:
    """A number that a pilot estimates.

    Attributes:
        value: the estimate.
        interval: 95 %; None where none is known.
    """

    value: float
    interval: Interval | None


@dataclasses.dataclass(frozen=True, slots=True)
class Pilot:
    """What a pilot estimates, in points of team reward a trial.

    Attributes:
        label: who took part.
        simulated: whether any participant was simulated.
        participants: how many are analysed.
        trials: trials of one participant under one condition, on average.
        protocols: SHA-256 of the protocols recorded.
        levels: names of the conditions, the reference first.
        effects: of each condition but the reference.
        effect_sd, trial_sd, level_sd: as in `Assumptions`.
        period: from one block to the next; None if not told from the condition.
        learning: from one trial to the next; None if there is one trial a block.
        excluded: participants whom a rule of the protocol leaves out.
    """

    label: str
    simulated: bool
    participants: int
    trials: float
    protocols: tuple[str, ...]
    levels: tuple[str, ...]
    effects: tuple[Estimate, ...]
    effect_sd: Estimate
    trial_sd: Estimate
    level_sd: Estimate
    period: Estimate | None
    learning: Estimate | None
    excluded: int

    def bounds(self, given: Assumptions) -> list[tuple[str, Assumptions]]:
        """Return assumptions at the pilot's bounds, where these are what was assumed."""
        found = []
        own = given.effects[-1] == self.effects[-1].value
        bounds = self.effects[-1].interval
        if given.conditions == 2 and own and bounds is not None:
            # The bound nearer to nothing; on the other side of zero there is nothing to find.
            near = min(bounds.low, bounds.high, key=abs) if bounds.low * bounds.high > 0 else 0.0
            changed = dataclasses.replace(given, effects=(0.0, near))
            found.append(
                ("The effect at the bound of the pilot’s interval nearer to none", changed)
            )
        upper = {
            name: estimate.interval.high
            for name, estimate in (("effect_sd", self.effect_sd), ("trial_sd", self.trial_sd))
            if estimate.interval is not None and getattr(given, name) == estimate.value
        }
        if upper:
            wider = dataclasses.replace(
                given,
                effect_sd=upper.get("effect_sd", given.effect_sd),
                trial_sd=upper.get("trial_sd", given.trial_sd),
            )
            found.append(("Scatter at the upper bounds of the pilot’s intervals", wider))
        return found


def pilot_of(recordings: list[Path], *, pool: bool = False) -> Pilot:
    """Estimate what a plan needs from recordings, by the report's own tables and model.

    Raises:
        StudyError: nothing can be used, or the trials do not determine the model.
    """
    study = load_recordings(recordings, pool=pool)
    tables = StudyTables(study)
    facts = protocol_facts(study)
    data = analysed_data(study, tables, facts)
    label = data_label(study)
    trials = data.trials[data.trials["condition"].astype("str").isin(facts.levels)]
    if len(facts.levels) < 2:
        raise StudyError("the pilot's recordings hold fewer than two conditions", HINT)
    model = model_of_trials(trials, facts.levels)
    if isinstance(model, Refusal):
        raise StudyError(f"the pilot tells too little: {model.reason}", HINT)
    return dataclasses.replace(
        estimates(trials, facts.levels, model),
        label=label.line,
        simulated=label.simulated,
        protocols=study.protocol_hashes,
        excluded=len(data.excluded),
    )


def estimates(trials: pd.DataFrame, levels: tuple[str, ...], model: MixedModel) -> Pilot:
    """Read off a model of trials what a plan needs.

    Args:
        trials: the rows that it was fitted to.
        levels: conditions, the reference first.
        model: of `model_of_trials`.

    Raises:
        StudyError: each participant has one trial a condition.
    """
    variances = {part.group: part.value for part in model.components if part.second is None}
    if "participant:condition" not in variances:
        raise StudyError(
            "the pilot has one trial a participant and condition, so that what differs between "
            "people is not told from what differs between trials",
            HINT,
        )
    people = trials["participant"].nunique()
    per_cell = trials.groupby(["participant", "condition"], observed=True).size()
    known = {each.name: each for each in model.coefficients}
    residual, own = variances["Residual"], variances["participant:condition"]
    places = sorted(name for name in known if name.startswith("period"))
    df_within = len(trials) - len(per_cell) - ("trial" in known)
    df_between = (people - 1) * (len(levels) - 1) - len(places)
    size = float(stats.hmean(per_cell))
    return Pilot(
        label="",
        simulated=False,
        participants=people,
        trials=float(per_cell.mean()),
        protocols=(),
        levels=levels,
        effects=tuple(_coefficient(known[f"condition{level}"]) for level in levels[1:]),
        effect_sd=_between(own, residual / size, df_between, df_within),
        trial_sd=Estimate(math.sqrt(residual), _chi_squared(residual, df_within)),
        level_sd=Estimate(math.sqrt(variances["participant"]), None),
        period=_per_step(known[places[-1]], len(places)) if places else None,
        learning=_coefficient(known["trial"]) if "trial" in known else None,
        excluded=0,
    )


def _coefficient(found: Coefficient) -> Estimate:
    return Estimate(found.estimate, found.interval)


def _per_step(last: Coefficient, steps: int) -> Estimate:
    """Return the change from block to block: the last block's less the first's, by steps."""
    low, high = last.interval.low / steps, last.interval.high / steps
    return Estimate(last.estimate / steps, Interval(low, high))


def _chi_squared(variance: float, df: int) -> Interval | None:
    if df < 1:
        return None
    low, high = (math.sqrt(df * variance / stats.chi2.ppf(q, df)) for q in (0.975, 0.025))
    return Interval(low, high)


def _between(own: float, noise: float, df1: int, df2: int) -> Estimate:
    """Return the SD of the difference of two conditions between participants.

    Args:
        own: variance of participant by condition; of a difference it is twice that.
        noise: variance of a cell's mean by its trials.
        df1: degrees of freedom of participant by condition.
        df2: degrees of freedom of the trials.
    """
    value = math.sqrt(2 * own)
    if df1 < 1 or df2 < 1:
        return Estimate(value, None)
    square = own + noise
    ends = []
    for q in (0.975, 0.025):
        rest = square - noise * float(stats.f.ppf(q, df1, df2))
        ends.append(math.sqrt(2 * max(0.0, df1 * rest / float(stats.chi2.ppf(q, df1)))))
    return Estimate(value, Interval(ends[0], ends[1]))
