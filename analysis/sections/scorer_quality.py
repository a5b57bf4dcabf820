"""How good the learned scorers are on held-out trials, and what their gates decided."""

from __future__ import annotations

import dataclasses

import pandas as pd

from analysis.formatting import counted, fraction, number
from analysis.results import StudyResults
from analysis.statistics.by_trial import mean_over_trials
from analysis.statistics.result import Interval

DECISIONS = {
    "use": "used",
    "repeat": "repeated with further trials",
    "go_on": "used all the same",
    "end": "session ended",
}


@dataclasses.dataclass(frozen=True, slots=True)
class AboveChance:
    """One scorer on its held-out trials.

    Attributes:
        participant, scorer: whose, and which.
        trials, choices: how many were held out.
        likelihood_gain, top1_gain: above chance, each with its interval over trials.
        top1, chance: the share named, and what guessing would name.
    """

    participant: str
    scorer: str
    trials: int
    choices: int
    likelihood_gain: tuple[float, Interval | None]
    top1_gain: tuple[float, Interval | None]
    top1: float
    chance: float

    @property
    def likelihood_text(self) -> str:
        """Return the gain in log-likelihood with its interval."""
        return _with_interval(*self.likelihood_gain, digits=3)

    @property
    def top1_text(self) -> str:
        """Return the share named, against chance."""
        return f"{fraction(self.top1)} ({fraction(self.chance)})"

    @property
    def top1_gain_text(self) -> str:
        """Return the share above chance with its interval."""
        return _with_interval(*self.top1_gain, digits=2)


@dataclasses.dataclass(frozen=True, slots=True)
class Reliability:
    """One bin of predicted probability, over all fitted scorers."""

    low: float
    high: float
    robots: int
    predicted: float
    chosen: float


def _with_interval(mean: float, interval: Interval | None, digits: int) -> str:
    text = number(mean, digits)
    if interval is None:
        return text
    return f"{text} [{number(interval.low, digits)}, {number(interval.high, digits)}]"


def last_fits(frame: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of each participant's last fit of each scorer: the one that was used."""
    if not len(frame):
        return frame
    keys = [frame["session"].astype(str), frame["artefact_id"].astype(str)]
    return frame[frame["request_id"] == frame.groupby(keys)["request_id"].transform("max")]


def above_chance(results: StudyResults) -> list[AboveChance]:
    """Compare every scorer with chance on its held-out trials."""
    rows = last_fits(results.tables.frame("held_out_trials"))
    found: list[AboveChance] = []
    keys = [rows[name].astype(str) for name in ("participant", "artefact_id")]
    for (who, artefact), group in rows.groupby(keys) if len(rows) else ():
        choices = group["choices"].to_numpy(dtype="float64")
        gain = (group["log_likelihood"] - group["chance_log_likelihood"]).to_numpy()
        top1, chance = group["top1"].to_numpy(), group["chance_top1"].to_numpy()
        found.append(
            AboveChance(
                participant=str(who),
                scorer=str(artefact),
                trials=len(group),
                choices=int(choices.sum()),
                likelihood_gain=mean_over_trials(gain, choices),
                top1_gain=mean_over_trials(top1 - chance, choices),
                top1=mean_over_trials(top1, choices)[0],
                chance=mean_over_trials(chance, choices)[0],
            )
        )
    return found


def reliability(results: StudyResults, scorer: str) -> list[Reliability]:
    """Pool the bins of all participants' fits of a scorer, weighted by robots."""
    rows = last_fits(results.tables.frame("calibration"))
    rows = rows[rows["artefact_id"].astype(str) == scorer]
    found: list[Reliability] = []
    for _, group in rows.groupby("bin") if len(rows) else ():
        robots = group["robots"].to_numpy(dtype="float64")
        total = float(robots.sum())
        found.append(
            Reliability(
                low=float(group["low"].iloc[0]),
                high=float(group["high"].iloc[0]),
                robots=round(total),
                predicted=float((group["predicted"].to_numpy() * robots).sum()) / total,
                chosen=float((group["chosen"].to_numpy() * robots).sum()) / total,
            )
        )
    return found


def reliabilities(results: StudyResults) -> list[tuple[str, float, list[Reliability]]]:
    """Return each scorer's pooled bins, with the expected calibration error of the pool."""
    frame = results.tables.frame("calibration")
    found: list[tuple[str, float, list[Reliability]]] = []
    for scorer in sorted(set(frame["artefact_id"].astype(str))):
        bins = reliability(results, scorer)
        total = sum(each.robots for each in bins)
        error = sum(each.robots * abs(each.predicted - each.chosen) for each in bins) / total
        found.append((scorer, error, bins))
    return found


@dataclasses.dataclass(frozen=True, slots=True)
class GateRow:
    """One judgement of a gate, as written."""

    participant: str
    scorer: str
    attempt: str
    passed: bool
    decision: str
    likelihood: str
    top1: str
    calibration: str
    reason: str


def gates(results: StudyResults) -> list[GateRow]:
    """Lay out what gates found and decided, in order of participant and attempt."""
    frame = results.tables.frame("fit_gates")
    rows: list[GateRow] = []
    for row in frame.to_dict("records"):
        decision = DECISIONS.get(str(row["decision"]), str(row["decision"]))
        if row["decision"] == "fallback":
            instead = "the participant" if row["fallback"] == "manual" else str(row["fallback"])
            decision = f"replaced: {instead} chose"
        rows.append(
            GateRow(
                participant=str(row["participant"]),
                scorer=str(row["artefact_id"]),
                attempt=f"{row['attempt']} of {row['attempts']}",
                passed=bool(row["passed"]),
                decision=decision,
                likelihood=_against(row["likelihood_gain"], row["min_likelihood_gain"], "≥"),
                top1=_against(row["top1_gain"], row["min_top1_gain"], "≥"),
                calibration=_against(row["calibration_error"], row["max_calibration_error"], "≤"),
                reason=str(row["reason"]),
            )
        )
    return rows


def gate_finding(results: StudyResults) -> str:
    """Say how many judgements were passed."""
    rows = gates(results)
    passed = sum(row.passed for row in rows)
    return f"{passed} of {counted(len(rows), 'judgement')} passed the gate."


def _against(value: float, threshold: float, sign: str) -> str:
    measured = "not measured" if pd.isna(value) else number(value, 3)
    return f"{measured} ({sign} {number(threshold, 3)})"
