"""`study plan` as it is typed."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd
import pytest

from analysis.planning.assumptions import Assumptions, Design
from analysis.planning.closed_form import closed_form
from command_line import study
from protocols import variant
from study.commands.planning import planned_study
from study.loading import load_protocol

SCATTER = ("--effect-sd", "15", "--trial-sd", "30")


def test_a_plan_by_options_reproduces_the_closed_form(tmp_path: Path) -> None:
    """Table, sentence, report and tables; the same for one process and for two."""
    command: tuple[str, ...] = ("plan", "scaled_autonomy", "--effect", "20", *SCATTER)
    command += ("--drop-out", "0.1", "--participants", "12,16,20", "--trials", "4,8")
    command += ("--studies", "4000")
    one, two = tmp_path / "one", tmp_path / "two"
    done = study(*command, "--jobs", "1", "-o", one)
    assert done.returncode == 0, done.stderr
    assert "16\u00a0participants, 4\u00a0trials" not in done.stdout
    assert "16\u00a0participants, 8\u00a0trials a condition: the smallest" in done.stdout
    assert "simulated afresh, with other seeds" in done.stdout
    assert "nothing here shows that they are so" in done.stderr
    power = pd.read_csv(one / "tables" / "power.csv")
    grid = power[power["role"] == "grid"]
    assert len(grid) == 6
    assumed = Assumptions((0.0, 20.0), 15.0, 30.0, ((0, 1), (1, 0)), drop_out=0.1, needed=1.0)
    for row in grid.itertuples():
        formula = closed_form(assumed, Design(int(row.participants), int(row.trials)))  # type: ignore[arg-type]
        assert formula is not None
        assert row.closed_form == pytest.approx(formula.power)
        error = (formula.power * (1 - formula.power) / 4000) ** 0.5
        assert row.power == pytest.approx(formula.power, abs=4 * error)
    check = power[power["role"] == "check"].iloc[0]
    assert (check["participants"], check["trials"]) == (16, 8)
    assert check["power"] >= 0.8
    again = study(*command, "--jobs", "2", "-o", two)
    assert again.returncode == 0, again.stderr
    for path in sorted(one.rglob("*.*")):
        assert path.read_bytes() == (two / path.relative_to(one)).read_bytes(), path.name


@pytest.mark.acceptance
def test_a_pilot_of_simulated_participants_of_stated_attention(tmp_path: Path) -> None:
    """They go through the protocol; what is not given is estimated from their recordings."""
    protocol = variant(
        tmp_path,
        ("trials = 1\ntrial_timesteps = 40", "trials = 2\ntrial_timesteps = 40"),
        ("at_least = 2", "at_least = 4"),
    )
    out = tmp_path / "plan"
    command = ("plan", protocol, "--participants", "10,20", "--trials", "2", "--studies", "500")
    done = study(*command, "--sessions", "4", "--set", "glance_tiles=1", "--jobs", "1", "-o", out)
    assert done.returncode == 0, done.stderr
    assert len(list((out / "pilot").glob("*.mcap"))) == 4
    assert "participants are simulated" in done.stderr
    rows = pd.read_csv(out / "tables" / "assumptions.csv", keep_default_na=False)
    sources = dict(zip(rows["option"], rows["source"], strict=True))
    assert {sources[name] for name in ("effect", "effect-sd", "trial-sd", "level-sd")} == {"pilot"}
    page = (out / "report.html").read_text()
    assert "Pilot: Simulated participants, N = 4" in page
    # The same recordings again, as anybody's would be given.
    other = tmp_path / "again"
    again = study(*command, "--from", out / "pilot", "--jobs", "1", "-o", other)
    assert again.returncode == 0, again.stderr
    assert (other / "report.html").read_text() == page
    wrong = study("plan", "scaled_autonomy", "--from", tmp_path / "none", "-o", other)
    assert wrong.returncode == 2
    assert "no such file or folder" in wrong.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ((), "no effect to plan for"),
        (("--effect", "20"), "no --effect-sd"),
        (("--effect", "1e300", *SCATTER), "at most 1e+09 points"),
        (("--effect", "1e8", *SCATTER), "nothing has to be planned to find that"),
        (("--effect", "0", *SCATTER), "no condition differs from another"),
        (("--effect", "20", "--effect-sd", "1e200", "--trial-sd", "30"), "at most 1e+09 points"),
        (("--participants", "a"), "--participants a: whole numbers"),
        (("--participants", "2"), "--participants: 2 given"),
        (("--sessions", "3", "--trials", "0"), "--trials: 0 given"),
        (("--sessions", "3", "--power", "80"), "--power: 80 given"),
        (("--effect", "20", *SCATTER, "--drop-out", "10"), "--drop-out: 10 given"),
        (("--effect", "20", *SCATTER, "--jobs", "0"), "0 processes"),
        (("--set", "glance_tiles=3"), "--set is about simulated participants"),
        (("--sessions", "3", "--from", "x"), "both given"),
        (("--sessions", "3", "--set", "glance_tile=3"), 'Did you mean "glance_tiles"?'),
        (("--sessions", "3", "--set", "glance_tiles=50"), "allowed: 12 or less"),
        (("--sessions", "3", "--set", "glance_tiles"), "is no number"),
    ],
)
def test_bad_input_is_one_message(options: tuple[str, ...], said: str, tmp_path: Path) -> None:
    """Nothing is written, and nobody sees a traceback."""
    done = study("plan", "smoke", *options, "-o", tmp_path / "out")
    assert done.returncode == 2
    assert said in re.sub(r"\s+", " ", done.stderr)
    assert not (tmp_path / "out").exists()


def test_a_protocol_says_what_a_plan_needs(tmp_path: Path) -> None:
    """The report's reference, the orders as they are given out, the rule as a part of the whole."""
    found = planned_study(load_protocol("scaled_autonomy"))
    assert found.levels == ("manual", "assisted")
    assert found.orders == ((0, 1), (1, 0))
    assert found.needed == 1.0
    assert found.bound is None
    assert found.minutes(8) == pytest.approx(8.0)
    three = planned_study(load_protocol("every_screen"))
    assert sorted(three.orders[0]) == list(range(len(three.levels)))
    path = variant(
        tmp_path,
        ('primary = "team_reward"', 'primary = "team_reward"\nequivalence_bound = 12.0'),
        ("at_least = 2", "at_least = 1"),
    )
    changed = planned_study(load_protocol(str(path)))
    assert changed.bound == 12.0
    assert changed.needed == 0.5
