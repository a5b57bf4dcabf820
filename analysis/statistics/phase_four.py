"""Phase four: the policy fitted with each condition's demonstrations, run on its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.statistics.cells import Cells, cell_means
from analysis.statistics.result import Outcome
from analysis.statistics.rm_anova import rm_anova

TEST_NAME = "Policy reward, participant means, paired"


@dataclasses.dataclass(frozen=True, slots=True)
class PolicyRow:
    """One condition's policies.

    Attributes:
        condition: its name.
        mean: mean reward of the policies, points a trial.
        demonstrations: rows each participant's policy was fitted on, sorted; empty if unknown.
        gain: mean reward above the phase-one policy on the same starts; None if that was not run.
    """

    condition: str
    mean: float
    demonstrations: tuple[int, ...]
    gain: float | None


@dataclasses.dataclass(frozen=True, slots=True)
class PhaseFour:
    """Phase four's results.

    Attributes:
        cells: participant-by-condition means of policy reward.
        test: the paired test on them.
        rows: one a condition.
        same_starts: participants whose policies were run from identical start states.
    """

    cells: Cells
    test: Outcome
    rows: tuple[PolicyRow, ...]
    same_starts: int


def phase_four(
    trials: pd.DataFrame, fits: pd.DataFrame, levels: Sequence[str], baseline: dict[str, str]
) -> PhaseFour:
    """Compare the conditions' policies.

    Args:
        trials: fleet runs of phase four: "participant", "condition", "trial", "policy_id",
            "start_states", "team_reward".
        fits: the table of fits.
        levels: conditions, the reference first.
        baseline: each participant's policy before phase four; runs of it are the baseline.
    """
    own = trials[trials["condition"].isin(list(levels))]
    cells = cell_means(own, "team_reward", levels, what="phase-four runs")
    before = trials[trials["policy_id"].astype("str") == trials["participant"].map(baseline)]
    before_means = {
        str(who): float(np.mean(np.sort(rows["team_reward"])))
        for who, rows in before.groupby("participant", observed=True)
    }
    demonstrations = _demonstrations(own, fits)
    rows = []
    for level in levels:
        if cells.n == 0:
            break
        rewards = cells.column(level)
        gains = [
            reward - before_means[who]
            for who, reward in zip(cells.participants, rewards, strict=True)
            if who in before_means
        ]
        counts = [
            demonstrations[who, level]
            for who in cells.participants
            if (who, level) in demonstrations
        ]
        gain = float(np.mean(gains)) if len(gains) == cells.n else None
        mean = float(np.mean(np.sort(rewards)))
        rows.append(PolicyRow(level, mean, tuple(sorted(counts)), gain))
    return PhaseFour(
        cells=cells,
        test=rm_anova(cells, TEST_NAME),
        rows=tuple(rows),
        same_starts=_same_starts(own, cells),
    )


def _demonstrations(trials: pd.DataFrame, fits: pd.DataFrame) -> dict[tuple[str, str], int]:
    """Return how many rows each participant's policy of each condition was fitted on."""
    applied = fits[fits["applied"] & (fits["kind"] == "policy")]
    # A name fitted anew replaces the fit before it.
    latest = {
        (str(who), str(artefact)): int(rows)
        for who, artefact, rows in zip(
            applied["participant"], applied["artefact_id"], applied["rows"], strict=True
        )
    }
    found: dict[tuple[str, str], int] = {}
    columns = (trials["participant"], trials["condition"], trials["policy_id"])
    for who, condition, policy in zip(*columns, strict=True):
        count = latest.get((str(who), str(policy)))
        if count is not None:
            found[str(who), str(condition)] = count
    return found


def _same_starts(trials: pd.DataFrame, cells: Cells) -> int:
    """Count participants whose k-th runs started alike under every condition."""
    alike = 0
    for participant in cells.participants:
        rows = trials[trials["participant"] == participant]
        sequences = {
            tuple(str(s) for s in own.sort_values("trial", kind="stable")["start_states"])
            for _, own in rows.groupby("condition", observed=True)
        }
        alike += len(sequences) == 1
    return alike
