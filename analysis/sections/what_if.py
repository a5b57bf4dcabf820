"""What if: other scorers asked about recorded choices, in words and tables."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.figures.paired_means import mean_interval
from analysis.formatting import counted, fraction, interval, number
from analysis.statistics.cells import cell_means
from analysis.statistics.holm import holm_of
from analysis.statistics.pairs import SMALLEST_N
from analysis.statistics.result import EffectResult, Interval, Outcome, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.what_if import WhatIf, pooled

OWN = "own"
VALIDATED = "own, cross-validated"
MEASURES = ["agreement", "chance_agreement", "log_likelihood", "chance_log_likelihood"]


@dataclasses.dataclass(frozen=True, slots=True)
class Mean:
    """A mean over participants, with its interval; None with too few."""

    value: float
    interval: Interval | None
    n: int

    def text(self, decimals: int = 2, *, bounded: bool = False) -> str:
        """Write it: ".41 [.35, .47]"."""
        if not self.n:
            return "–"
        write = fraction if bounded else number
        if self.interval is None:
            return write(self.value, decimals)
        return f"{write(self.value, decimals)} {interval(self.interval, decimals, bounded=bounded)}"


@dataclasses.dataclass(frozen=True, slots=True)
class ScorerRow:
    """One scorer on choices that it was not fitted to.

    Attributes:
        scorer: its name.
        group: "later" for choices after the own scorers were fitted, "earlier" for those before.
        choices: how many.
        agreement, chance, rank: means over participants.
        gain: log-likelihood of a choice above chance, nats; n is 0 where it has none.
        against_own: agreement, own minus this one's; None for the own.
        holm_p: over the scorers of the group.
    """

    scorer: str
    group: str
    choices: int
    agreement: Mean
    chance: Mean
    rank: Mean
    gain: Mean
    against_own: Outcome | None = None
    holm_p: float | None = None


def mean_of(values: npt.NDArray[np.float64]) -> Mean:
    """Return the mean of participants' values that are not missing, with its t interval."""
    known = np.sort(values[np.isfinite(values)])
    if not known.size:
        return Mean(float("nan"), None, 0)
    bounds = mean_interval(known) if known.size >= SMALLEST_N else None
    return Mean(float(known.mean()), bounds, int(known.size))


def scorer_rows(what: WhatIf) -> list[ScorerRow]:
    """Compare every scorer with chance and with the own, choices after the fits first."""
    return [*_group(what, fitted=False), *_group(what, fitted=True)]


def _group(what: WhatIf, *, fitted: bool) -> list[ScorerRow]:
    trials = what.tables["trials"]
    trials = trials[(trials["fitted"] == fitted) & ~trials["seen"].astype(bool)]
    if fitted and VALIDATED not in set(trials["scorer"]):
        return []
    people = pooled(trials, ["scorer", "participant"], [*MEASURES, "rank"])
    names = list(dict.fromkeys(trials["scorer"]))
    own = VALIDATED if fitted else OWN
    rows: list[ScorerRow] = []
    for name in sorted(names, key=lambda each: (each != own, names.index(each))):
        mine = people[people["scorer"] == name]
        gains = (mine["log_likelihood"] - mine["chance_log_likelihood"]).to_numpy()
        rows.append(
            ScorerRow(
                scorer=name,
                group="earlier" if fitted else "later",
                choices=int(mine["choices"].sum()),
                agreement=mean_of(mine["agreement"].to_numpy()),
                chance=mean_of(mine["chance_agreement"].to_numpy()),
                rank=mean_of(mine["rank"].to_numpy()),
                gain=mean_of(gains),
                against_own=None if name == own else _against(people, name, own),
            )
        )
    tested = [row.against_own for row in rows if row.against_own is not None]
    adjusted = iter(holm_of(tested))
    return [
        row if row.against_own is None else dataclasses.replace(row, holm_p=next(adjusted))
        for row in rows
    ]


def _against(people: pd.DataFrame, name: str, own: str) -> Outcome:
    pair = people[people["scorer"].isin((name, own))].rename(columns={"scorer": "condition"})
    return rm_anova(cell_means(pair, "agreement", (name, own)), f"{own} − {name}", "sensitivity")


@dataclasses.dataclass(frozen=True, slots=True)
class Matrix:
    """How well each participant's scorer predicts each one's choices.

    Attributes:
        owners: whose scorers, a row each.
        people: whose choices, a column each.
        gain: log-likelihood of a choice above chance, nats [owners, people].
        agreement: share of choices named [owners, people].
        kind: "later" if the choices come after the own scorers' fits, "cross_validated" if each
            own scorer is asked about trials held out from it, "fitted" if it was fitted to them.
        own_gain: own minus the mean of the others' on the same choices, over participants.
        own_agreement: the same of agreement.
    """

    owners: tuple[str, ...]
    people: tuple[str, ...]
    gain: npt.NDArray[np.float64]
    agreement: npt.NDArray[np.float64]
    kind: str
    own_gain: Outcome
    own_agreement: Outcome


def matrix(what: WhatIf) -> Matrix | None:
    """Lay out the matrix; None with fewer than two scorers fitted to participants."""
    table = what.tables["matrix"]
    later = table[~table["fitted"].astype(bool)]
    kind = "later"
    if not len(later):
        own = table[table["scorer_of"] == table["participant"]]
        kind = "fitted" if own["seen"].astype(bool).any() else "cross_validated"
    table = later if len(later) else table
    owners = tuple(sorted(set(table["scorer_of"])))
    people = tuple(sorted(set(table["participant"])))
    if len(owners) < 2:
        return None
    gain = np.full((len(owners), len(people)), np.nan)
    agreement = gain.copy()
    for row in table.itertuples():
        at = (owners.index(str(row.scorer_of)), people.index(str(row.participant)))
        gain[at] = float(row.log_likelihood) - float(row.chance_log_likelihood)  # type: ignore[arg-type]
        agreement[at] = float(row.agreement)  # type: ignore[arg-type]
    return Matrix(
        owners=owners,
        people=people,
        gain=gain,
        agreement=agreement,
        kind=kind,
        own_gain=_own_against_others(gain, owners, people),
        own_agreement=_own_against_others(agreement, owners, people),
    )


def _own_against_others(
    values: npt.NDArray[np.float64], owners: tuple[str, ...], people: tuple[str, ...]
) -> Outcome:
    rows = []
    for column, who in enumerate(people):
        if who not in owners:
            continue
        place = owners.index(who)
        others = np.delete(values[:, column], place)
        if np.isfinite(others).any():
            rows.append((who, "others", float(np.nanmean(np.sort(others)))))
            rows.append((who, "own", float(values[place, column])))
    frame = pd.DataFrame(rows, columns=["participant", "condition", "value"])
    return rm_anova(cell_means(frame, "value", ("others", "own")), "own − others", "sensitivity")


def matrix_finding(found: Matrix) -> str:
    """Say whether participants' own scorers predict them better than others' do."""
    test = found.own_agreement
    if isinstance(test, Refusal) or test.estimate is None or test.interval is None:
        return "Whether own scorers do better than others’ was not tested."
    size = f"{fraction(test.estimate)} {interval(test.interval, bounded=True)}"
    better = "more" if test.estimate > 0 else "less"
    if test.interval.holds(0.0):
        return (
            "Participants’ own scorers cannot be told from others’: the share of choices named "
            f"differs by {size}."
        )
    return f"A participant’s own scorer names their choices {better} often than others’ do: {size}."


@dataclasses.dataclass(frozen=True, slots=True)
class RegretRow:
    """The regret of whoever chose.

    Attributes:
        who: "operator", "chance" or a scorer.
        choices: how many were rolled out.
        regret, gain: points, means over participants.
        best: share of choices without regret.
        against_operator: regret, this one's minus the operator's; None for the operator.
    """

    who: str
    choices: int
    regret: Mean
    gain: Mean
    best: Mean
    against_operator: Outcome | None


def regret_rows(what: WhatIf) -> list[RegretRow]:
    """Compare regrets, the operator's first; only choices that no scorer here was fitted to."""
    table = what.tables["regret"]
    if not len(table):
        return []
    table = table[~table["seen"].astype(bool)].assign(choices=1)
    table = table.assign(none=(table["robot"] == table["best"]) | (table["regret"] <= 0.0))
    people = pooled(table, ["who", "participant"], ["regret", "gain", "none"])
    order = list(dict.fromkeys(table["who"]))
    rows = []
    for who in order:
        mine = people[people["who"] == who]
        pair = people[people["who"].isin((who, "operator"))].rename(columns={"who": "condition"})
        test = (
            None
            if who == "operator"
            else rm_anova(cell_means(pair, "regret", ("operator", who)), who, "sensitivity")
        )
        rows.append(
            RegretRow(
                who=who,
                choices=int(mine["choices"].sum()),
                regret=mean_of(mine["regret"].to_numpy()),
                gain=mean_of(mine["gain"].to_numpy()),
                best=mean_of(mine["none"].to_numpy()),
                against_operator=test,
            )
        )
    return rows


def finding(rows: list[ScorerRow]) -> str:
    """Say which scorers beat chance on choices that they were not fitted to."""
    later = [row for row in rows if row.group == "later"] or rows
    if not later:
        return "No scorer was asked about choices that it was not fitted to."
    judged = [row for row in later if row.agreement.interval is not None]
    if not judged:
        return "With so few participants no interval is drawn."
    better = [
        row
        for row in judged
        if row.agreement.interval is not None and row.agreement.interval.low > row.chance.value
    ]
    return (
        f"{len(better)} of {counted(len(judged), 'scorer')} named choices more often than chance."
    )


def is_computed(outcome: Outcome | None) -> bool:
    """Whether a test was computed."""
    return isinstance(outcome, EffectResult)
