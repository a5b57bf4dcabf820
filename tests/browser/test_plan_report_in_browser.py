"""A plan's report in a real browser: accessible, and quiet on the network."""

from __future__ import annotations

from typing import Any

import pytest

from analysis.planning.files import write_plan
from analysis.planning.plan import Wanted, grid, make_plan
from analysis.planning.power import run_here
from analysis.planning.stated import Given, settle
from assumed_law import planned
from report_in_browser import inspect


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What headless Chromium finds in the report of a plan."""
    study = planned(needed=1.0)
    given = Given(("9",), effect_sd=5.0, trial_sd=10.5, drop_out=0.1)
    assumed, rows = settle(study, given, None)
    plan = make_plan(assumed, Wanted(grid((8, 12), (4, 8)), 0.7, 1000, 50, 1), None, run_here)
    return inspect(write_plan(plan, study, rows, tmp_path_factory.mktemp("plan")))


@pytest.mark.parametrize("view", ["light", "dark", "narrow"])
def test_axe_finds_no_violation(seen: dict[str, Any], view: str) -> None:
    """No rule of axe-core is broken, and nobody has to scroll the page sideways."""
    assert seen["violations"][view] == []
    assert seen["wide"][view] <= 0


def test_no_request_leaves_the_page(seen: dict[str, Any]) -> None:
    """Opened, the page asks for nothing, and its policy blocks nothing of its own."""
    assert seen["requests"] == []
    assert seen["errors"] == []
