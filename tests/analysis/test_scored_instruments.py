"""Scored instruments: scores from the recordings alone, their tests, and how reliable they are."""

from __future__ import annotations

import dataclasses
import json
import types
from pathlib import Path
from typing import Any, cast

import numpy as np
import pandas as pd
import pingouin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.export.wide import wide_table
from analysis.instruments import instruments
from analysis.recordings import Session, StudyRecordings, load_recordings
from analysis.report import render_report
from analysis.results import StudyResults
from analysis.sections import quality, scored
from analysis.statistics.reliability import Reliability
from analysis.statistics.result import EffectResult, Refusal
from analysis.tables import scores
from analysis.tables.study_tables import StudyTables
from study.loading import load_questionnaire
from study_results import results_of
from synthetic_study import Plan, study_plans, write_session

SHIPPED = ("nasa_tlx", "sus", "trust")


@pytest.mark.parametrize("name", SHIPPED)
@given(data=st.data())
def test_scores_are_those_of_the_session(name: str, data: st.DataObject) -> None:
    """Whatever is answered, the recorded definition gives what the session computes, to the bit."""
    questionnaire = load_questionnaire(name, Path("nowhere"))
    values = range(questionnaire.low, questionnaire.high + 1, questionnaire.step)
    answers = {item.id: data.draw(st.sampled_from(values)) for item in questionnaire.items}
    text = json.dumps({name: questionnaire.model_dump(mode="json")})
    opened = types.SimpleNamespace(questionnaires_json=text)
    instrument = instruments(cast(Session, types.SimpleNamespace(opened=opened)))[name]
    found = {scale.name: instrument.score(scale, answers) for scale in instrument.scales}
    assert found == questionnaire.scores(answers)
    assert instrument.version == questionnaire.version
    for scale in instrument.scales:
        low, high = instrument.reach(scale)
        assert low <= found[scale.name] <= high  # type: ignore[operator]


def test_the_table_holds_what_was_recorded(results: StudyResults) -> None:
    """A row a score, with the same computed again from the answers beside it."""
    frame = results.tables.frame("scores")
    whole = [s for s in results.study.sessions if s.complete]
    assert len(frame) >= 2 * len(whole)
    assert set(frame["origin"]) == {"recorded"}
    assert set(frame["version"]) == {2}
    assert frame["score"].to_numpy() == pytest.approx(frame["computed"].to_numpy())
    assert (frame["lowest"].min(), frame["highest"].max()) == (0.0, 100.0)


def test_sessions_without_scores_are_scored_from_their_answers(
    results: StudyResults, tmp_path: Path
) -> None:
    """A recording from before scores were recorded gives the same scores."""
    write_session(tmp_path, Plan("P01", 0, trials=3, timesteps=12, planned=8, scored=False))
    found = scores.build(load_recordings([tmp_path])).frame
    recorded = results.tables.frame("scores")
    recorded = recorded[recorded["participant"] == "P01"]
    assert set(found["origin"]) == {"computed"}
    columns = ["condition", "scale", "occasion", "block", "items"]
    assert found[columns].astype(str).to_numpy().tolist() == (
        recorded[columns].astype(str).to_numpy().tolist()
    )
    assert found["score"].to_numpy() == pytest.approx(recorded["score"].to_numpy())


def test_alpha_is_that_of_the_answers(results: StudyResults) -> None:
    """Alpha and Feldt's interval agree with pingouin's on the answers, relaxed turned round."""
    (row,) = results.scales
    answers = results.data.responses
    for level, found in row.reliability:
        own = answers[(answers["questionnaire"] == "workload") & (answers["condition"] == level)]
        wide = own.astype({"participant": str, "item": str}).pivot_table(
            index="participant", columns="item", values="answer"
        )
        wide["relaxed"] = 6 - wide["relaxed"]
        alpha, interval = pingouin.cronbach_alpha(pd.DataFrame(wide.to_numpy()))
        assert isinstance(found, Reliability)
        assert found.alpha == pytest.approx(alpha, rel=1e-9)
        assert [found.interval.low, found.interval.high] == pytest.approx(interval, abs=1e-3)
        assert (found.participants, found.rows) == (len(wide), 3 * len(wide))


def test_conditions_are_compared_on_scores(results: StudyResults) -> None:
    """The paired difference is that of the scores; items of a scale are no ratings of their own."""
    (row,) = results.scales
    assert isinstance(row.f_test, EffectResult)
    difference = row.cells.column("assisted") - row.cells.column("manual")
    assert row.f_test.estimate == pytest.approx(float(np.mean(difference)))
    assert isinstance(row.rank_test, EffectResult)
    assert row.holm_p == pytest.approx(row.rank_test.p)
    assert {rated.item for rated in results.ratings} == {"q1", "q2"}
    page = render_report(results)
    assert "Workload: Load (before reveal)" in page
    assert "Cronbach’s α" in page


def test_two_people_have_no_reliability(tmp_path: Path) -> None:
    """Too few answers are refused in words, in the report too."""
    results = results_of(tmp_path, study_plans(2, trials=1, timesteps=4))
    (row,) = results.scales
    assert all(isinstance(found, Refusal) for _, found in row.reliability)
    assert isinstance(row.f_test, Refusal)
    assert row.holm_f_p is None
    reason = "Reliability needs at least 3 participants; there are 2."
    assert reason in render_report(results)
    assert "Not tested: Workload" in scored.finding(results)


def test_a_score_that_answers_do_not_give_is_flagged(results: StudyResults) -> None:
    """What was recorded is kept, and a reader told that it does not follow."""
    frame = results.tables.frame("scores").copy()
    frame["score"] = frame["score"] + np.where(frame.index == 0, 10.0, 0.0)
    tables = _Changed(results.tables, frame)
    changed = dataclasses.replace(results, tables=cast(StudyTables, tables))
    flags = [flag for flag in quality.flags(changed) if flag.kind == "Score"]
    assert [flag.session for flag in flags] == [str(frame.loc[0, "participant"])]
    assert not [flag for flag in quality.flags(results) if flag.kind == "Score"]


def test_other_wordings_are_flagged(results: StudyResults) -> None:
    """Sessions that were asked another version of an instrument are pooled, and the report says."""
    first, *rest = results.study.sessions
    asked = json.loads(first.opened.questionnaires_json)
    asked["workload"]["version"] = 3
    opened = dataclasses.replace(first.opened, questionnaires_json=json.dumps(asked))
    sessions = (dataclasses.replace(first, opened=opened), *rest)
    study = StudyRecordings(sessions, results.study.set_aside)
    flags = quality.flags(dataclasses.replace(results, study=study))
    texts = [flag.text for flag in flags if flag.kind == "Instrument"]
    assert texts == ["workload was not asked alike in all sessions (version 2, 3)"]


def test_wide_has_scores_and_no_column_about_the_study(results: StudyResults) -> None:
    """Scores stand beside means and answers; no sentence is repeated in each row."""
    wide = wide_table(results)
    frame = wide.frame
    scored_columns = [name for name in frame if str(name).startswith("score_workload_load")]
    assert len(scored_columns) == 2
    assert "data" not in wide.to_csv(None).splitlines()[0].split(",")
    assert set(frame["operator"]) == {"simulated"}


class _Changed:
    """Tables with another table of scores."""

    def __init__(self, tables: StudyTables, frame: pd.DataFrame) -> None:
        self._tables, self._frame = tables, frame

    def frame(self, name: str) -> pd.DataFrame:
        return self._frame if name == "scores" else self._tables.frame(name)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._tables, name)

    def __getitem__(self, name: str) -> Any:
        return self._tables[name]
