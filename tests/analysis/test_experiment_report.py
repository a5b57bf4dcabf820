"""An experiment's report says what its numbers say, and nothing else."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from analysis.commands.report import write_experiment_report
from analysis.experiment.contrasts import mean_of, paired
from analysis.experiment.frames import load_experiment
from analysis.experiment.page import headline, render_experiment
from analysis.experiment.paper import in_words
from analysis.experiment.questions import PREDICTION, REWARD, hypotheses
from analysis.experiment.summary import markdown
from made_up_trials import made_up_results
from study.errors import StudyError


def _text(page: str) -> str:
    body = page[page.index("<main>") :]
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body)).replace("\u00a0", " ")


def test_contrasts_are_paired_t_tests() -> None:
    """Statistic, p and interval are SciPy's paired t test's."""
    random = np.random.default_rng(1)
    wide = pd.DataFrame(random.normal([0.4, 0.0], size=(20, 2)), columns=["a", "b"])
    found = paired("H", "m", "points", wide, "a", "b")
    assert found is not None
    assert found.mean.interval is not None
    expected = stats.ttest_rel(wide["a"], wide["b"])
    bounds = expected.confidence_interval()
    assert found.t == pytest.approx(expected.statistic)
    assert found.p == pytest.approx(expected.pvalue)
    assert (found.mean.interval.low, found.mean.interval.high) == pytest.approx(tuple(bounds))
    assert found.better == (wide["a"] > wide["b"]).mean()


def test_differences_that_never_vary_have_no_statistic() -> None:
    """Equal differences in all trials: no division by zero, and a tie counts half."""
    wide = pd.DataFrame({"a": [1.0, 2.0, 3.0], "b": [1.0, 2.0, 3.0]})
    found = paired("H", "m", "points", wide, "a", "b")
    assert found is not None
    assert (found.t, found.p, found.better, found.verdict) == (None, 1.0, 0.5, "undecided")
    assert paired("H", "m", "points", wide, "a", "c") is None
    assert mean_of(np.array([])).n == 0


def test_words_follow_the_numbers(tmp_path: Path) -> None:
    """Ahead, the report agrees with the paper; behind, it says so; apart, it names nobody."""
    ahead = load_experiment(made_up_results(tmp_path / "ahead"))
    behind = load_experiment(made_up_results(tmp_path / "behind", luce_ahead=-0.3))
    tests = hypotheses(ahead)
    assert [test.verdict for test in tests[PREDICTION]] == ["higher"] * 3
    said = " ".join(in_words(ahead, tests))
    assert "as in the paper" in said
    assert "against the paper" not in said
    assert "order of team reward holds at all of 2\u00a0dwells" in said
    assert "more often than a classifier, and its fleet earned more." in headline(tests)
    said = " ".join(in_words(behind, hypotheses(behind)))
    assert "against the paper" in said
    assert "as in the paper" not in said
    assert "reversed at 2" in said
    assert "less often" in headline(hypotheses(behind))


def test_holm_is_within_each_heading(tmp_path: Path) -> None:
    """Adjusted p are Holm's over one heading's contrasts: never below the raw, at most 1."""
    tests = hypotheses(load_experiment(made_up_results(tmp_path / "x", luce_ahead=0.0)))
    for contrasts in tests.values():
        smallest = min(contrasts, key=lambda test: test.p)
        assert smallest.p_adjusted == pytest.approx(min(1.0, len(contrasts) * smallest.p))
        assert all(test.p <= test.p_adjusted <= 1 for test in contrasts)
    assert len(tests[REWARD]) == 14


def test_the_report_is_one_safe_file_and_repeats(tmp_path: Path) -> None:
    """Same results, same bytes; text from files is escaped; what is missing is said."""
    hostile = "<script>alert(1)</script>"
    folder = made_up_results(tmp_path / "x", label=hostile, seeds="development")
    (folder / "trial_00003.json").write_text("{}")
    page = render_experiment(load_experiment(folder))
    assert page == render_experiment(load_experiment(folder))
    assert hostile not in page
    assert "default-src &#39;none&#39;" in page
    shown = _text(page)
    assert "trial_00003.json" in shown
    assert "11 of 250 planned" in shown
    assert "Development worlds." in page
    assert not re.search(r"\bnan\b|None", shown)


def test_the_command_writes_report_and_tables(tmp_path: Path) -> None:
    """The CSV's differences are those of the report; every table is there with its meaning."""
    folder = made_up_results(tmp_path / "x")
    out = tmp_path / "report"
    assert write_experiment_report([folder], out) == out / "report.html"
    names = {path.name for path in (out / "tables").iterdir()}
    assert {"runs.csv", "policies.csv", "worlds.csv", "sensitivity.csv", "fleet_sizes.csv",
            "differences.csv", "columns.json"} == names  # fmt: skip
    runs = pd.read_csv(out / "tables" / "runs.csv", keep_default_na=False)
    assert len(runs) == 12 * (2 * 8 + 1)
    with pytest.raises(StudyError, match="one folder"):
        write_experiment_report([folder, folder], out)


def test_the_summary_states_what_made_it(tmp_path: Path) -> None:
    """Command, seeds, versions, wall time and hashes stand in the page for docs/results."""
    experiment = load_experiment(made_up_results(tmp_path / "x"))
    page = markdown(experiment, "study experiment simulation", "12 minutes on 2 cores")
    for part in ("study experiment simulation", "20261126", "numpy 2.0", "12 minutes", "79 %"):
        assert part in page
    assert all(line.count("|") >= 3 for line in page.splitlines() if line.startswith("|"))


def test_too_few_trials_are_refused(tmp_path: Path) -> None:
    """One trial has no interval: no report."""
    with pytest.raises(StudyError, match="needs two"):
        load_experiment(made_up_results(tmp_path / "x", trials=1))
