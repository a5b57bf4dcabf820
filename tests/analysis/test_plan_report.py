"""A plan's report and tables say what the plan found, and are safe to open."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import pandas as pd
import pytest

from analysis.planning.assumptions import Assumptions
from analysis.planning.files import COLUMNS, write_plan
from analysis.planning.page import render_plan
from analysis.planning.plan import Plan, Wanted, grid, make_plan
from analysis.planning.power import run_here
from analysis.planning.stated import Given, PlannedStudy, Stated, settle
from analysis.planning.words import warnings
from assumed_law import AB_BA, planned

WANTED = Wanted(grid((8, 12, 16), (4, 8)), 0.8, 1000, 50, 1)
Made = tuple[Plan, PlannedStudy, tuple[Stated, ...]]


def made(study: PlannedStudy, given: Given, wanted: Wanted = WANTED) -> Made:
    assumed, rows = settle(study, given, None)
    return make_plan(assumed, wanted, None, run_here), study, rows


@pytest.fixture(scope="module")
def plain() -> Made:
    """A plan of two conditions that names a size."""
    given = Given(("9",), effect_sd=5.0, trial_sd=10.5, drop_out=0.1)
    return made(planned(needed=1.0), given)


def _text(page: str) -> str:
    body = page[page.index("<main>") :]
    return re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body)).replace("\u00a0", " ")


def test_the_page_is_one_safe_file_and_repeats(plain: Made) -> None:
    """Same plan, same bytes; nothing from elsewhere; text from the protocol is escaped."""
    page = render_plan(*plain)
    assert page == render_plan(*plain)
    assert "default-src &#39;none&#39;" in page
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert "Nothing here was measured" in page
    shown = _text(page)
    assert not re.search(r"\bnan\b|None|\binf\b", shown)
    hostile = "<script>alert(1)</script>"
    found, study, rows = plain
    assert hostile not in render_plan(found, dataclasses.replace(study, title=hostile), rows)


def test_the_page_names_the_size_and_its_fresh_power(plain: Made) -> None:
    """In words, in the table and in the figure; every cell of the grid has its row."""
    found, _, rows = plain
    assert found.chosen is not None
    assert found.check is not None
    page = render_plan(*plain)
    shown = _text(page)
    size = found.chosen.design
    assert f"{size.participants} participants, {size.trials} trials a condition" in shown
    assert "(named)" in shown
    assert f"simulated afresh, with other seeds, {found.check.power:.2f}" in shown
    assert page.count('<th scope="row">') == 6 + len(found.variations) + len(rows)
    assert page.count('<polyline class="s-c') == 2
    assert "smallest that reaches it" in page
    assert found.cells[0].formula is not None
    assert f"{found.cells[0].formula.power:.3f}" in shown


def test_nothing_named_is_said(plain: Made) -> None:
    """No ring, no name, and what would do."""
    given = Given(("2",), effect_sd=5.0, trial_sd=10.5)
    page = render_plan(*made(planned(), given))
    shown = _text(page)
    assert "No size in the grid reaches a power of 0.80" in shown
    assert "By the closed form it takes" in shown
    assert "(named)" not in shown
    assert "smallest that reaches it" not in page


def test_three_conditions_are_marked_as_near(plain: Made) -> None:
    """Where the closed form is not exact the table says so."""
    study = planned(
        levels=("manual", "suggested", "assisted"),
        labels=("Manual", "Suggested", "Assisted"),
        orders=((0, 1, 2), (1, 2, 0), (2, 0, 1)),
    )
    given = Given(("suggested=5", "assisted=9"), effect_sd=5.0, trial_sd=10.5)
    page = _text(render_plan(*made(study, given)))
    assert "† before Greenhouse and Geisser’s correction" in page
    assert "effects of 5 and 9 points a trial" in page
    assert "not each pair’s" in page
    assert "†" not in _text(render_plan(*plain))


def test_tables_hold_what_the_plan_found(plain: Made, tmp_path: Path) -> None:
    """Each table has the columns that it declares; a label cannot be run by a spreadsheet."""
    found, study, rows = plain
    hostile = tuple(
        dataclasses.replace(row, text="=cmd()") if row.option == "--effect" else row for row in rows
    )
    path = write_plan(found, study, hostile, tmp_path / "out")
    assert path == tmp_path / "out" / "report.html"
    assert path.stat().st_mode & 0o077 == 0
    meaning = json.loads((tmp_path / "out" / "tables" / "columns.json").read_text())
    for name, columns in COLUMNS.items():
        table = pd.read_csv(tmp_path / "out" / "tables" / f"{name}.csv", keep_default_na=False)
        assert [*columns, "data"] == list(table.columns)
        assert set(meaning["tables"][name]) == set(columns)
        assert set(table["data"]) == {meaning["data"]}
    power = pd.read_csv(tmp_path / "out" / "tables" / "power.csv")
    in_grid = power[power["role"] == "grid"]
    assert list(in_grid["power"]) == [cell.power for cell in found.cells]
    assert in_grid["named"].sum() == 1
    assert (power["role"] == "check").sum() == 1
    assert (power["found"] / power["studies"] == power["power"]).all()
    text = (tmp_path / "out" / "tables" / "assumptions.csv").read_text()
    assert "'=cmd()" in text


def test_warnings_are_those_that_apply() -> None:
    """Each assumption that can fail is named where it was made, and only there."""
    given = {"effects": ("9",), "effect_sd": 5.0, "trial_sd": 10.5}

    def said(study: PlannedStudy, studies: int = 10, **more: float) -> str:
        assumed, rows = settle(study, Given(**given, **more), None)  # type: ignore[arg-type]
        small = Wanted(grid((4, 5), (2,)), 0.8, studies, studies // 2, 1)
        found: Plan = make_plan(assumed, small, None, run_here)
        return " ".join(warnings(found, study, rows))

    assert isinstance(settle(planned(), Given(**given), None)[0], Assumptions)  # type: ignore[arg-type]
    plain = said(planned(), studies=100)
    assert "Nobody is taken to leave" in plain
    assert "Neither the place in the session" in plain
    assert "no multiple of the 2 orders" in plain
    assert "times the true effect on average" in plain
    assert "mixed model" not in plain
    assert "as stated; nothing here shows" in plain
    lossy = said(planned(needed=0.5), drop_out=0.3)
    assert "fewer than 50 % of the trials is left out" in lossy
    assert "is the mixed model of the trials" in lossy
    assert "Nobody is taken to leave" not in lossy
    assert "costs power" in said(planned(), period=3.0)
    assert "Everybody has the same order" in said(planned(orders=AB_BA[:1]))
    assert "not simulated: few_choices" in said(planned(other_rules=("few_choices",)))
