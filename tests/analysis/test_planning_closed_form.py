"""Power by formula: other programs' values, and studies drawn in another way."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from statsmodels.stats.power import FTestPower, TTestPower

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.closed_form import closed_form, smallest_participants
from assumed_law import AB_BA, law, three


def power(assumed: Assumptions, participants: int, trials: int = 8) -> float:
    found = closed_form(assumed, Design(participants, trials))
    assert found is not None
    return found.power


@pytest.mark.parametrize("participants", [3, 8, 12, 13, 30])
@pytest.mark.parametrize("trials", [1, 8])
@pytest.mark.parametrize("alpha", [0.05, 0.005])
@pytest.mark.parametrize("effect", [6.0, -2.0, 7.0])
def test_complete_data_have_the_power_of_the_paired_t_test(
    participants: int, trials: int, alpha: float, effect: float
) -> None:
    """Statsmodels computes the same from the standardised effect."""
    assumed = law(effects=(0.0, effect), alpha=alpha)
    dz = effect / math.sqrt(5.0**2 + 2 * 10.5**2 / trials)
    expected = TTestPower().power(dz, participants, alpha)
    assert power(assumed, participants, trials) == pytest.approx(expected, abs=1e-8)


def test_twelve_participants_find_dz_089() -> None:
    """A textbook value: n = 12 and d_z = 0.89 have a power of 0.8."""
    assumed = law(effects=(0.0, 0.89), effect_sd=0.0, trial_sd=math.sqrt(0.5))
    assert power(assumed, 12, 1) == pytest.approx(0.80, abs=0.005)
    # The same, were there no trials to scatter: only the sum of both scatters counts.
    assert power(assumed, 12, 1) == pytest.approx(
        power(law(effects=(0.0, 0.89), effect_sd=0.6, trial_sd=math.sqrt(0.32)), 12, 1)
    )


def test_three_conditions_have_the_power_of_the_f_test() -> None:
    """Statsmodels' F test with the same noncentrality; said not to be exact."""
    assumed = three()
    found = closed_form(assumed, Design(12, 8))
    assert found is not None
    assert not found.exact
    centre = 12 * (9 + 0 + 9) / (assumed.difference_variance(8) / 2)
    # Statsmodels' noncentrality is f2 * (df_num + df_denom + ncc), of numerator and denominator.
    f = math.sqrt(centre / (22 + 2 + 1))
    expected = FTestPower().power(f, df_denom=2, df_num=22, alpha=0.05, ncc=1)
    assert found.power == pytest.approx(expected, abs=1e-8)


@pytest.mark.parametrize("participants", [4, 11])
@pytest.mark.parametrize("assumed", [law(effects=(0.0, 0.0)), three(effects=(0.0, 0.0, 0.0))])
def test_without_an_effect_it_is_the_level(assumed: Assumptions, participants: int) -> None:
    """A test that finds nothing but by chance."""
    assert power(assumed, participants) == pytest.approx(0.05, abs=1e-9)


def test_order_makes_the_test_of_means_timid() -> None:
    """What order adds is not adjusted for: it counts as scatter, and the level is not used up."""
    assert power(law(effects=(0.0, 0.0), period=8.0), 12) < 0.03
    assert power(law(period=8.0), 12) < power(law(), 12) - 0.1
    assert power(law(period=8.0), 12) == pytest.approx(power(law(period=-8.0), 12))
    # With one order the period is a part of the effect.
    same = law(orders=AB_BA[:1], period=2.0)
    assert power(same, 12) == pytest.approx(power(law(effects=(0.0, 8.0)), 12))


@pytest.mark.parametrize("seed", range(4))
def test_losses_and_orders_by_brute_force(seed: int) -> None:
    """Differences drawn directly, without trials, and tested by t: within 4 standard errors."""
    random = np.random.default_rng(seed)
    participants = int(random.integers(5, 24))
    period, carry = float(random.uniform(-8, 8)), float(random.uniform(-5, 5))
    leave, lost, trials = float(random.uniform(0, 0.4)), float(random.uniform(0, 0.02)), 4
    assumed = law(
        effects=(0.0, 9.0),
        period=period,
        carry_over=carry,
        drop_out=leave,
        missing=lost,
        needed=1.0,
    )
    stays = (1 - leave) * (1 - lost) ** (2 * trials)
    first = np.arange(participants) % 2 == 0
    centres = np.where(first, 9.0 + period, 9.0 - period - carry)
    studies = 40_000
    sd = math.sqrt(assumed.difference_variance(trials))
    drawn = random.normal(centres, sd, (studies, participants))
    drawn[random.random(drawn.shape) > stays] = np.nan
    count = np.sum(~np.isnan(drawn), axis=1)
    drawn, count = drawn[count >= 3], count[count >= 3]
    t = np.nanmean(drawn, axis=1) / np.nanstd(drawn, axis=1, ddof=1) * np.sqrt(count)
    share = float(np.sum(np.abs(t) > stats.t.isf(0.025, count - 1))) / studies
    expected = power(assumed, participants, trials)
    assert share == pytest.approx(expected, abs=4 * math.sqrt(expected * (1 - expected) / studies))


@given(
    effect=st.floats(0.5, 40),
    scatter=st.floats(0.1, 30),
    between=st.floats(0, 30),
    participants=st.integers(3, 120),
    trials=st.integers(1, 30),
)
def test_more_of_everything_is_never_less(
    effect: float, scatter: float, between: float, participants: int, trials: int
) -> None:
    """Power is a probability, grows with both sizes and the effect, and falls with scatter."""
    assumed = law(effects=(0.0, effect), trial_sd=scatter, effect_sd=between)
    here = power(assumed, participants, trials)
    assert 0.05 - 1e-9 <= here <= 1
    larger = law(effects=(0.0, 1.5 * effect), trial_sd=scatter, effect_sd=between)
    wider = law(effects=(0.0, effect), trial_sd=scatter, effect_sd=between + 5)
    assert power(assumed, participants + 1, trials) >= here - 1e-7
    assert power(assumed, participants, trials + 1) >= here - 1e-7
    assert power(larger, participants, trials) >= here - 1e-7
    assert power(wider, participants, trials) <= here + 1e-7


def test_no_formula_where_there_is_none() -> None:
    """Where the mixed model is primary, and with three conditions whose order matters."""
    size = Design(12, 8)
    assert closed_form(law(drop_out=0.1), size) is None
    assert closed_form(law(missing=0.1, needed=0.5), size) is None
    assert closed_form(three(period=1.0), size) is None
    assert closed_form(law(drop_out=0.1, needed=1.0), size) is not None


def test_the_smallest_number_is_the_smallest() -> None:
    """One order's worth fewer does not reach the power; out of reach there is none."""
    found = smallest_participants(law(), 8, 0.8, 2, 400)
    assert found is not None
    assert power(law(), found) >= 0.8 > power(law(), found - 2)
    assert found % 2 == 0
    assert smallest_participants(law(effects=(0.0, 0.001)), 8, 0.8, 2, 400) is None
    # Where there is no formula the data are taken as complete, of those who stay.
    leaving = smallest_participants(law(drop_out=0.3), 8, 0.8, 2, 400)
    assert leaving is not None
    assert leaving > found
