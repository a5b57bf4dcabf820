"""Degenerate data are refused in words; what is computed keeps its invariants."""

from __future__ import annotations

import itertools

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.statistics.cells import cell_means
from analysis.statistics.holm import holm
from analysis.statistics.likert import likert_rows
from analysis.statistics.order_effects import describe_orders, period_means
from analysis.statistics.pooled_trials import condition_and_trial, condition_trial_order
from analysis.statistics.result import EffectResult, Refusal
from analysis.statistics.rm_anova import rm_anova
from analysis.statistics.wilcoxon import signed_rank

LEVELS = ("manual", "assisted")


def frame(manual: list[float], assisted: list[float]) -> pd.DataFrame:
    rows = [
        {"participant": f"P{place:02d}", "condition": name, "trial": 1, "team_reward": value}
        for name, values in (("manual", manual), ("assisted", assisted))
        for place, value in enumerate(values)
    ]
    return pd.DataFrame(rows, columns=["participant", "condition", "trial", "team_reward"])


def test_too_few_participants_are_refused() -> None:
    """Two participants are no sample; the reason says how many are needed."""
    result = rm_anova(cell_means(frame([1, 2], [3, 5]), "team_reward", LEVELS))
    assert isinstance(result, Refusal)
    assert "2 participants have" in result.reason
    assert "at least 3" in result.reason


@pytest.mark.parametrize("shift", [0.0, 2.5])
def test_equal_differences_are_refused(shift: float) -> None:
    """Differences without variance are refused, whether they are zero or not."""
    manual = [1.0, 4.0, 2.0, 9.0]
    cells = cell_means(frame(manual, [x + shift for x in manual]), "team_reward", LEVELS)
    result = rm_anova(cells)
    assert isinstance(result, Refusal)
    assert "no variance" in result.reason


def test_empty_cell_excludes_its_participant_aloud() -> None:
    """A participant without a condition is left out and named with the reason."""
    cells = cell_means(frame([1, 2, 5, 4], [2, 4, 9]), "team_reward", LEVELS)
    result = rm_anova(cells)
    assert isinstance(result, EffectResult)
    assert [(e.participant, e.reason) for e in result.excluded] == [
        ("P03", "no rows under assisted")
    ]
    assert result.participants == ("P00", "P01", "P02")


def test_one_condition_is_refused() -> None:
    """With one condition there is nothing to compare."""
    result = rm_anova(cell_means(frame([1, 2, 3], []), "team_reward", ("manual",)))
    assert isinstance(result, Refusal)


def test_pooled_form_refuses_too_few_rows() -> None:
    """A model with as many parameters as rows is refused."""
    assert isinstance(condition_and_trial(frame([1], [2]), LEVELS), Refusal)


def test_pooled_order_form_refuses_a_single_order() -> None:
    """Without two orders the order term is not estimable."""
    data = frame([1, 2, 5, 4], [2, 4, 9, 1]).assign(order="manual, assisted")
    result = condition_trial_order(data, LEVELS)
    assert isinstance(result, Refusal)
    assert "1 order" in result.reason


def test_all_zero_differences_refuse_the_signed_rank_test() -> None:
    """Zeros are dropped; with nothing left the test is refused."""
    assert isinstance(signed_rank(np.zeros(5), ("a",) * 5), Refusal)


def test_refused_rating_stays_out_of_the_family() -> None:
    """Holm's family holds only the tests that were computed."""
    rows = [
        {
            "participant": f"P{p}",
            "condition": c,
            "item": i,
            "occasion": "before_reveal",
            "answer": a,
        }
        for p in range(4)
        for c, i, a in [
            ("manual", "Q1", 2),
            ("assisted", "Q1", 2),
            ("manual", "Q2", 1 + p % 2),
            ("assisted", "Q2", 4 + p),
        ]
    ]
    keys = [("Q1", "before_reveal"), ("Q2", "before_reveal")]
    first, second = likert_rows(pd.DataFrame(rows), keys, LEVELS)
    assert first.holm_p is None
    assert isinstance(second.rank_test, EffectResult)
    assert second.holm_p == second.rank_test.p


@given(st.lists(st.integers(-6, 6), min_size=1, max_size=9))
def test_signed_rank_equals_enumeration(differences: list[int]) -> None:
    """The exact p equals that of listing every sign pattern, ties and zeros included."""
    values = np.array(differences, dtype=np.float64)
    result = signed_rank(values, tuple(f"P{i}" for i in range(values.size)))
    kept = values[values != 0]
    if kept.size == 0:
        assert isinstance(result, Refusal)
        return
    assert isinstance(result, EffectResult)
    magnitudes = np.abs(kept)
    ranks = np.array(
        [(magnitudes < m).sum() + ((magnitudes == m).sum() + 1) / 2 for m in magnitudes]
    )
    sums = [float(np.dot(signs, ranks)) for signs in itertools.product((0, 1), repeat=kept.size)]
    observed = float(ranks[kept > 0].sum())
    low = sum(s <= observed + 1e-9 for s in sums) / len(sums)
    high = sum(s >= observed - 1e-9 for s in sums) / len(sums)
    assert result.statistic == pytest.approx(observed)
    assert result.p == pytest.approx(min(1.0, 2 * min(low, high)))


@given(st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_holm_never_lowers_and_keeps_the_order(p_values: list[float]) -> None:
    """Adjusted values are at least the raw ones, at most one, and ordered alike."""
    adjusted = holm(p_values)
    assert all(a >= p for a, p in zip(adjusted, p_values, strict=True))
    assert max(adjusted) <= 1
    ranked = [a for _, a in sorted(zip(p_values, adjusted, strict=True))]
    assert ranked == sorted(ranked)


@given(st.integers(0, 2**32 - 1), st.floats(0.1, 10), st.floats(-50, 50))
def test_scaling_leaves_the_test_alone(seed: int, scale: float, shift: float) -> None:
    """A change of unit changes the estimate by its factor and F, p and d_z not at all."""
    generator = np.random.default_rng(seed)
    manual, assisted = generator.normal(size=(2, 6))
    first = rm_anova(cell_means(frame(list(manual), list(assisted)), "team_reward", LEVELS))
    moved = frame(list(scale * manual + shift), list(scale * assisted + shift))
    second = rm_anova(cell_means(moved, "team_reward", LEVELS))
    assert isinstance(first, EffectResult)
    assert isinstance(second, EffectResult)
    assert second.statistic == pytest.approx(first.statistic, rel=1e-6)
    assert second.p == pytest.approx(first.p, rel=1e-6)
    assert first.estimate is not None
    assert second.estimate == pytest.approx(scale * first.estimate, rel=1e-6)


def test_orders_are_described_by_period() -> None:
    """Each order lists its people and means; a period's mean counts every participant once."""
    data = frame([1, 3, 10], [5, 7, 20])
    ab, ba = ("manual", "assisted"), ("assisted", "manual")
    rows = describe_orders(data, {"P00": ab, "P01": ab, "P02": ba})
    described = {(row.order, row.condition): (row.period, row.mean) for row in rows}
    assert described == {
        (ab, "manual"): (1, 2.0),
        (ab, "assisted"): (2, 6.0),
        (ba, "assisted"): (1, 20.0),
        (ba, "manual"): (2, 10.0),
    }
    assert period_means(rows) == {1: 8.0, 2: pytest.approx(22 / 3)}
