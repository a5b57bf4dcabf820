"""The primary test on other rows: without exclusions, as treated, complete sessions only."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from analysis.recordings import load_recordings
from analysis.report import render_report
from analysis.results import StudyResults, compute_results
from analysis.sections import reward
from analysis.statistics.result import EffectResult
from analysis.tables.study_tables import StudyTables
from analysis.variants import variants
from study.events.codes import Phase
from synthetic_study import Plan, write_session


def changed(results: StudyResults, column: str, who: str, value: object) -> StudyResults:
    """Return the results as they were, had a participant's assisted trials another value."""
    data = results.data
    trials = data.trials.copy()
    one = (trials["participant"] == who) & (trials["condition"] == "assisted")
    trials[column] = trials[column].astype("object").mask(one, value)
    ran = trials["treated"].astype("str")
    data = dataclasses.replace(
        data,
        trials=trials,
        treated=trials[ran != ""].assign(condition=ran[ran != ""]),
        departures=trials[ran != trials["condition"].astype("str")],
    )
    return dataclasses.replace(results, data=data)


def test_the_same_rows_are_not_tested_anew(results: StudyResults) -> None:
    """Where no trial departed from its condition, as treated is as assigned."""
    treated = next(item for item in results.variants if item.name == "as treated")
    assert treated.same
    assert treated.outcome is results.primary


def test_without_exclusions_everybody_counts(results: StudyResults) -> None:
    """Without the rule the trials of whom it leaves out are back, and the test is another."""
    (rule,) = results.data.rules
    assert rule.participants == ("P08",)
    assert [item.participant for item in results.data.excluded] == ["P08"]
    assert "P08" not in set(results.data.trials["participant"])
    item = next(item for item in results.variants if item.name == "without exclusions")
    assert not item.same
    assert isinstance(item.outcome, EffectResult)
    assert "P08" in item.outcome.participants


def test_a_trial_that_ran_no_condition_is_left_out_as_treated(results: StudyResults) -> None:
    """Assisted trials without a scorer count where they were assigned, not as treated."""
    departed = changed(results, "treated", "P01", "")
    found = variants(departed.data, results.cells, results.primary, frozenset())
    treated = next(item for item in found if item.name == "as treated")
    assert not treated.same
    assert isinstance(treated.outcome, EffectResult)
    assert treated.outcome.method == "Kenward-Roger", "who lacks a condition counts in the model"
    rows = len(results.data.trials) - len(departed.data.departures)
    assert treated.outcome.rows == rows
    assert departed.data.departures["participant"].unique().tolist() == ["P01"]


def test_other_rows_stand_in_table_and_forest(results: StudyResults) -> None:
    """Each variant that differs is a row of its own, with an interval in the forest."""
    groups = {group.heading: group.results for group in reward.test_groups(results)}
    names = [result.name for result in groups["The primary test on other rows"]]
    assert any(name.endswith("without exclusions") for name in names)
    drawing = reward.forest_figure(results)
    assert drawing is not None
    assert "without exclusions" in drawing.markup()


def test_a_fleet_run_without_its_scorer_departs(tmp_path: Path) -> None:
    """The table tells what ran from what was assigned; the participant's page says so."""
    for index in range(3):
        write_session(tmp_path, Plan(f"P{index + 1:02d}", index, trials=3, timesteps=8, planned=3))
    study = load_recordings([tmp_path])
    first = study.sessions[0]
    trials = {
        number: dataclasses.replace(trial, scorer_id="")
        if trial.phase == Phase.THREE and trial.condition == "assisted" and trial.trial == 1
        else trial
        for number, trial in first.trials.items()
    }
    gated = dataclasses.replace(
        study, sessions=(dataclasses.replace(first, trials=trials), *study.sessions[1:])
    )
    results = compute_results(gated, StudyTables(gated))
    assert len(results.data.departures) == 1
    page = render_report(results)
    assert "1\u00a0trial did not run as assigned" in page
    treated = next(item for item in results.variants if item.name == "as treated")
    assert isinstance(treated.outcome, EffectResult)
    assert treated.outcome.rows == pytest.approx(len(results.data.trials) - 1)
