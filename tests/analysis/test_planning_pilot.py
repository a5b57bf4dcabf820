"""What a pilot says of effect and scatter, and how sure it is of that."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.made_up import level_names, make_up
from analysis.planning.pilot import Pilot, estimates, pilot_of
from analysis.planning.stated import Given, settle
from analysis.robustness import model_of_trials
from analysis.statistics.mixed.model import MixedModel
from analysis.statistics.result import EffectResult
from assumed_law import law, planned, three
from study.errors import StudyError
from study_results import results_of
from synthetic_study import Plan, write_session


def pilot(assumed: Assumptions, size: Design, seed: int, study: int = 0) -> Pilot:
    frame = make_up(assumed, size, seed, "pilot", 0).frame(study)
    levels = level_names(assumed.conditions)
    model = model_of_trials(frame, levels)
    assert isinstance(model, MixedModel)
    return estimates(frame, levels, model)


def test_a_large_pilot_finds_the_law() -> None:
    """Every number of a made-up law is found again."""
    assumed = law(period=4.0, learning=0.8)
    found = pilot(assumed, Design(160, 6), 2)
    assert found.effects[0].value == pytest.approx(6, abs=1.5)
    assert found.effect_sd.value == pytest.approx(5, abs=1.5)
    assert found.trial_sd.value == pytest.approx(10.5, abs=0.6)
    assert found.level_sd.value == pytest.approx(11, abs=2)
    assert found.period is not None
    assert found.learning is not None
    assert found.period.value == pytest.approx(4, abs=1.5)
    assert found.learning.value == pytest.approx(0.8, abs=0.4)
    assert found.participants == 160
    assert found.trials == 6


def test_three_conditions_have_an_effect_each() -> None:
    """And the period is the change from block to block, not from the first to the last."""
    found = pilot(three(period=4.0), Design(60, 4), 2)
    assert [each.value for each in found.effects] == pytest.approx([3, 6], abs=3)
    assert found.period is not None
    assert found.period.value == pytest.approx(4, abs=1.5)


def test_scatter_is_that_of_the_mean_squares() -> None:
    """In complete data without a period the model's variance is that of the differences."""
    size = Design(12, 6)
    studies = make_up(law(effect_sd=15.0, orders=((0, 1),)), size, 4, "pilot", 0)
    frame = studies.frame(0)
    model = model_of_trials(frame, level_names(2))
    assert isinstance(model, MixedModel)
    found = estimates(frame, level_names(2), model)
    means = studies.rewards[0].mean(axis=2)
    variance = np.var(means[:, 1] - means[:, 0], ddof=1)
    own = found.effect_sd.value**2 + 2 * found.trial_sd.value**2 / 6
    assert own == pytest.approx(variance, rel=1e-4)
    assert found.period is None  # one order: it cannot be told from the condition


@pytest.mark.acceptance
def test_intervals_cover_the_truth() -> None:
    """Of 100 small pilots about 95 hold each truth; Williams's interval at least nine in ten."""
    assumed = law(effect_sd=12.0)
    size = Design(8, 4)
    frames = [make_up(assumed, size, 6, "pilot", block) for block in range(2)]
    hits = np.zeros(3)
    levels = level_names(2)
    for made in frames:
        for study in range(50):
            frame = made.frame(study)
            model = model_of_trials(frame, levels)
            assert isinstance(model, MixedModel)
            found = estimates(frame, levels, model)
            truths = zip(
                (found.effects[0], found.effect_sd, found.trial_sd), (6.0, 12.0, 10.5), strict=True
            )
            for at, (estimate, truth) in enumerate(truths):
                assert estimate.interval is not None
                assert estimate.interval.low <= estimate.value <= estimate.interval.high
                hits[at] += estimate.interval.holds(truth)
    assert np.all(hits >= 87)
    assert hits[0] <= 99


def test_one_trial_a_condition_tells_too_little() -> None:
    """What differs between people is not told from noise."""
    with pytest.raises(StudyError, match="one trial a participant and condition"):
        pilot(law(), Design(8, 1), 1)


def test_recordings_are_read_as_the_report_reads_them(tmp_path: Path) -> None:
    """The effect is that of the report's mixed model of the same recordings."""
    plans = [Plan(f"P{index:02d}", index, trials=4) for index in range(6)]
    results = results_of(tmp_path, plans)
    model = next(
        test
        for test in (results.primary, *results.sensitivity)
        if isinstance(test, EffectResult) and test.method == "Kenward-Roger"
    )
    found = pilot_of([tmp_path])
    assert found.effects[0].value == pytest.approx(model.estimate)
    assert found.effects[0].interval == model.interval
    assert found.levels == ("manual", "assisted")
    assert found.simulated
    assert found.label.startswith("Simulated participants, N = 6")
    assert found.participants == 6


def test_too_few_recordings_are_refused(tmp_path: Path) -> None:
    """In words, with what to give instead."""
    for index in range(2):
        write_session(tmp_path, Plan(f"P{index:02d}", index, trials=3))
    with pytest.raises(StudyError, match=r"tells too little: .* at least 3 participants"):
        pilot_of([tmp_path])


def test_what_is_given_counts_before_the_pilot_and_says_so() -> None:
    """Options, then the protocol's bound, then the pilot; bounds where they count."""
    found = dataclasses.replace(
        pilot(law(effects=(0.0, 20.0), period=4.0), Design(12, 4), 3), levels=("manual", "assisted")
    )
    assumed, rows = settle(planned(), Given(), found)
    assert assumed.effects == (0.0, found.effects[0].value)
    assert assumed.period == found.period.value if found.period else False
    assert {row.source for row in rows[:5]} == {"pilot"}
    texts = [text for text, _ in found.bounds(assumed)]
    assert len(texts) == 2
    bounded, rows = settle(planned(bound=5.0), Given(trial_sd=9.0), found)
    assert bounded.effects == (0.0, 5.0)
    assert bounded.trial_sd == 9.0
    assert rows[0].source == "protocol: analysis.equivalence_bound"
    ((text, wider),) = found.bounds(bounded)
    assert "Scatter" in text
    assert wider.trial_sd == 9.0
    assert found.effect_sd.interval is not None
    assert wider.effect_sd == found.effect_sd.interval.high
    with pytest.raises(StudyError, match="the pilot's conditions are manual, assisted"):
        settle(planned(levels=("manual", "other")), Given(), found)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (Given(), "no effect to plan for"),
        (Given(effects=("6",)), "no --effect-sd"),
        (Given(effects=("6",), effect_sd=5.0), "no --trial-sd"),
        (Given(effects=("x",)), "'x' is no number"),
        (Given(effects=("manual=5",)), "manual is the reference"),
        (Given(effects=("nobody=5",)), "nobody is no condition"),
        (Given(effects=("6", "assisted=7")), "given twice"),
        (Given(effects=("nan",), effect_sd=1.0, trial_sd=1.0), "not a finite number"),
        (Given(effects=("6",), effect_sd=-1.0, trial_sd=1.0), "--effect-sd: -1 given"),
        (Given(effects=("6",), effect_sd=1.0, trial_sd=0.0), "--trial-sd: 0 given"),
        (Given(effects=("6",), effect_sd=1.0, trial_sd=1.0, drop_out=1.0), "--drop-out: 1 given"),
        (Given(effects=("6",), effect_sd=1.0, trial_sd=1.0, missing=-0.1), "--missing: -0.1"),
        (Given(effects=("6",), effect_sd=1.0, trial_sd=1.0, alpha=0.0), "--alpha: 0 given"),
        (Given(effects=("6",), effect_sd=math.inf, trial_sd=1.0), "not a finite number"),
    ],
)
def test_what_cannot_be_is_refused_with_its_option(given: Given, said: str) -> None:
    """One message: what was given and what to do."""
    with pytest.raises(StudyError) as error:
        settle(planned(), given, None)
    assert said in error.value.message
    assert error.value.hint


def test_three_conditions_need_a_name_each() -> None:
    """A number alone could be anybody's."""
    study = planned(
        levels=("manual", "suggested", "assisted"), labels=("M", "S", "A"), orders=((0, 1, 2),)
    )
    scatter = {"effect_sd": 1.0, "trial_sd": 1.0}
    with pytest.raises(StudyError, match="3 conditions"):
        settle(study, Given(effects=("6",), **scatter), None)
    with pytest.raises(StudyError, match="none given for assisted"):
        settle(study, Given(effects=("suggested=6",), **scatter), None)
    assumed, _ = settle(study, Given(effects=("assisted=6", "suggested=2"), **scatter), None)
    assert assumed.effects == (0.0, 2.0, 6.0)
