"""Tables: declared columns, and numbers that agree with the recordings."""

from __future__ import annotations

import dataclasses
import gc
import io
import json
import weakref
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.stats

from analysis.commands.writing import write_tables
from analysis.data_label import data_label
from analysis.recordings import StudyRecordings
from analysis.statistics.by_trial import mean_over_trials
from analysis.tables import study_tables
from analysis.tables.columns import Column, Table
from analysis.tables.study_tables import BUILDERS, StudyTables
from analysis.tables.trials import treated_condition
from study.events.events import Timestep

KIND = {"integer": "i", "number": "f", "boolean": "b"}


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_columns_are_those_declared(tables: StudyTables, name: str) -> None:
    """Each table has rows, its declared columns in order, and their types."""
    table = tables[name]
    assert len(table) > 0
    assert list(table.frame.columns) == [column.name for column in table.columns]
    for column in table.columns:
        assert column.text
        kind = table.frame[column.name].dtype
        if column.dtype in KIND:
            assert kind.kind == KIND[column.dtype]
        else:
            assert str(kind) == {"text": "str", "label": "category"}[column.dtype]


def test_trial_rewards_are_sums_of_timesteps(tables: StudyTables) -> None:
    """Team reward and length of every fleet run, broken ones too, follow from its timesteps."""
    steps = tables.frame("timesteps")
    keys = ["participant", "trial_id"]
    sums = steps.groupby(keys, observed=True)["team_reward"].agg(["sum", "count"])
    trials = tables.frame("trials").set_index(keys)
    assert (~trials["complete"]).any()
    joined = trials.join(sums)
    known = joined["sum"].notna()
    np.testing.assert_allclose(joined["team_reward"][known], joined["sum"][known], rtol=1e-6)
    assert (joined["timesteps"][known] == joined["count"][known]).all()


def test_every_recorded_timestep_is_in_the_table(
    study: StudyRecordings, tables: StudyTables
) -> None:
    """No timestep is lost, whatever the number of robots changes to."""
    recorded = sum(1 for s in study.sessions for _ in s.recording.records(Timestep.topic))
    assert len(tables["timesteps"]) == recorded
    steps = tables.frame("timesteps")
    assert len(tables["choices"]) == int((steps["operated"] > 0).sum())


def test_choices_hold_the_state_before_the_step(
    study: StudyRecordings, tables: StudyTables
) -> None:
    """A choice's state is that of the chosen robot at that timestep."""
    session = study.sessions[0]
    choices = tables.frame("choices")
    own = choices[choices["session"] == session.opened.session_id]
    first = next(
        r
        for _, r in session.recording.records(Timestep.topic)
        if isinstance(r, Timestep) and r.operated >= 0 and r.robots == 12
    )
    row = own[(own["trial_id"] == first.trial_id) & (own["timestep"] == first.timestep)].iloc[0]
    names = [f"state_{field.name}" for field in session.task.state_fields]
    np.testing.assert_allclose([row[n] for n in names], first.states[first.operated], rtol=1e-6)
    assert row["chosen"] == first.operated + 1


def test_interventions_cover_operator_driven_timesteps_once(tables: StudyTables) -> None:
    """Lengths add up to the operator-driven timesteps, and idling ends an intervention."""
    steps = tables.frame("timesteps")
    interventions = tables.frame("interventions")
    assert interventions["length"].sum() == (steps["action_source"] == "operator").sum()
    assert interventions["length"].min() >= 1
    # The synthetic operator idles at every fifth timestep.
    assert interventions["length"].max() <= 4


def test_robots_repeat_the_fleet_at_each_timestep(tables: StudyTables) -> None:
    """The long form has a row a robot, and its rewards add up to the team's."""
    robots, steps = tables.frame("robots"), tables.frame("timesteps")
    keys = ["participant", "trial_id", "timestep"]
    sums = robots.groupby(keys, observed=True)["reward"].sum().reset_index()
    merged = steps.merge(sums, on=keys)
    assert len(merged) == len(steps)
    np.testing.assert_allclose(merged["reward"], merged["team_reward"], rtol=1e-6)


def test_scorer_fits_have_their_measures(tables: StudyTables) -> None:
    """Every applied fit lists each of its measures once."""
    metrics = tables.frame("fit_metrics")
    scorers = metrics[metrics["kind"] == "scorer"]
    assert set(scorers["metric"]) >= {"choices", "held_out_top1"}
    assert not metrics.duplicated(["participant", "request_id", "metric"]).any()


def test_tables_are_built_once_and_only_when_asked(
    study: StudyRecordings, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A table costs nothing until it is asked for, and is then kept."""
    built: list[str] = []

    def build(recordings: StudyRecordings) -> Table:
        built.append("sessions")
        return Table("sessions", "text", (), {})

    monkeypatch.setitem(study_tables.BUILDERS, "sessions", build)
    fresh = StudyTables(study)
    assert built == []
    assert fresh["sessions"] is fresh["sessions"]
    assert built == ["sessions"] * len(study.sessions)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"b": [1]}, "columns differ"),
        ({"a": [1.5]}, "not integers"),
        ({"a": [None]}, "missing values"),
        ({"a": ["x"]}, "not integers"),
    ],
)
def test_undeclared_data_are_refused(data: dict[str, list[object]], message: str) -> None:
    """A table refuses other columns than declared, and values of another type."""
    with pytest.raises(ValueError, match=message):
        Table("t", "text", [Column("a", "integer", "a number")], data)


def test_columns_of_different_lengths_are_refused() -> None:
    """Columns must be equally long."""
    columns = [Column("a", "integer", "x"), Column("b", "number", "y")]
    with pytest.raises(ValueError, match="different lengths"):
        Table("t", "text", columns, {"a": [1, 2], "b": [1.0]})


def test_csv_neutralises_formulas_and_names_its_origin() -> None:
    """A text that a spreadsheet would run gets an apostrophe; each row says who made it."""
    table = Table("t", "text", [Column("a", "text", "x")], {"a": ["=1+1", "fine", "NA"]})
    read = pd.read_csv(io.StringIO(table.to_csv("Simulated, N = 2")), keep_default_na=False)
    assert list(read["a"]) == ["'=1+1", "fine", "NA"]
    assert set(read["data"]) == {"Simulated, N = 2"}


def test_written_tables_are_complete_and_repeatable(study: StudyRecordings, tmp_path: Path) -> None:
    """All files are written, are described, name their origin, and come out the same again."""
    label = data_label(study)
    first, second = tmp_path / "a", tmp_path / "b"
    count = write_tables(StudyTables(study), label, first)
    write_tables(StudyTables(study), label, second)
    files = sorted(path.name for path in first.iterdir())
    assert len(files) == count + 1
    for name in files:
        assert (first / name).read_bytes() == (second / name).read_bytes()
    described = json.loads((first / "columns.json").read_text())
    assert described["data"].startswith("Simulated participants, N = 8")
    for name, entry in described["tables"].items():
        frame = pd.read_csv(first / f"{name}.csv", keep_default_na=False, low_memory=False)
        assert list(frame.columns) == list(entry["columns"])
        assert set(frame["data"]) == {described["data"]}


def test_label_counts_simulated_and_gives_seeds(study: StudyRecordings) -> None:
    """The label states kind, number, seeds and parameters."""
    label = data_label(study)
    assert label.line == "Simulated participants, N = 8, seeds 500 to 507"
    assert dict(label.parameters) == {"attention_tiles": "3", "lapse_rate": "0.02 to 0.027"}


def test_data_label_names_the_seed_that_made_the_study(study: StudyRecordings) -> None:
    """One number from which all sessions follow, where the recordings tell it."""
    sessions = tuple(
        dataclasses.replace(
            session,
            opened=dataclasses.replace(session.opened, operator_json='{"study_seed": 7}'),
        )
        for session in study.sessions
    )
    label = data_label(dataclasses.replace(study, sessions=sessions))
    assert label.line == "Simulated participants, N = 8, study seed 7"


@pytest.mark.parametrize("name", sorted(study_tables.LONG_TABLES))
def test_long_tables_are_held_a_session_at_a_time(study: StudyRecordings, name: str) -> None:
    """Going through a long table never keeps more than one session's part of it."""
    seen: list[weakref.ref[Table]] = []
    for part in StudyTables(study).parts(name):
        assert len(set(part.frame["session"])) == 1
        seen.append(weakref.ref(part))
        gc.collect()
        assert sum(reference() is not None for reference in seen) == 1
    assert len(seen) == len(study.sessions)


def test_held_out_quality_has_tables_of_its_own(tables: StudyTables) -> None:
    """Trials, bins and decisions are rows; the measures of fit list none of them."""
    trials, bins = tables.frame("held_out_trials"), tables.frame("calibration")
    assert set(trials["trial_id"]) == {12, 13}
    assert set(zip(bins["bin"], bins["low"], bins["chosen"], strict=True)) == {
        (2, 0.1, 0.1),
        (6, 0.5, 0.6),
    }
    gates = tables.frame("fit_gates")
    assert set(gates["decision"]) == {"use"}
    assert gates["passed"].all()
    assert not gates["warm"].any()
    names = set(tables.frame("fit_metrics")["metric"])
    assert not [name for name in names if "trial_" in name or "bin_" in name]


def test_another_scorer_is_another_treatment(study: StudyRecordings) -> None:
    """A fleet run that a gate gave another scorer did not run as assigned."""
    session = study.sessions[0]
    trial = next(t for t in session.trials.values() if t.allocation == "assisted")
    declared = [{"name": "assisted", "allocation": "assisted", "scorer": "luce"}]
    own = dataclasses.replace(session, protocol={"conditions": declared})
    assert treated_condition(own, trial) == "assisted"
    other = dataclasses.replace(trial, scorer_id="scorer:stuck_longest")
    assert treated_condition(own, other) == ""


def test_an_interval_over_trials_takes_a_trial_for_one_observation() -> None:
    """With trials of equal length it is the t interval of their means; two trials have none."""
    means = np.array([0.2, 0.4, 0.6, 0.4])
    mean, interval = mean_over_trials(means, np.full(4, 50.0))
    low, high = scipy.stats.t.interval(0.95, 3, loc=0.4, scale=means.std(ddof=1) / 2)
    assert interval is not None
    assert (mean, interval.low, interval.high) == pytest.approx((0.4, low, high))
    assert mean_over_trials(means[:1], np.array([50.0])) == (0.2, None)
    assert mean_over_trials(means[:2], np.full(2, 50.0))[1] is None
    assert mean_over_trials(means[:3], np.full(3, 50.0))[1] is not None


def test_what_ran_is_told_from_what_was_assigned(tables: StudyTables) -> None:
    """In this study every trial of phase three ran as assigned; other phases assign nothing."""
    trials = tables.frame("trials")
    three = trials["phase"] == 3
    ran, assigned = trials["treated"].astype("str"), trials["condition"].astype("str")
    assert (ran[three] == assigned[three]).all()
    assert (ran[trials["phase"] < 3] == "").all()


def test_an_assisted_trial_without_a_scorer_ran_no_condition(study: StudyRecordings) -> None:
    """Assigned is what the protocol says; treated is what the allocation and scorer did."""
    session = study.sessions[0]
    trial = next(t for t in session.trials.values() if t.allocation == "assisted")
    assert treated_condition(session, trial) == "assisted"
    assert treated_condition(session, dataclasses.replace(trial, scorer_id="")) == ""
    fallen_back = dataclasses.replace(trial, allocation="manual", scorer_id="")
    assert treated_condition(session, fallen_back) == "manual"
