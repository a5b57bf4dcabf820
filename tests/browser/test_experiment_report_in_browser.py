"""An experiment's report in a real browser: accessible, and quiet on the network."""

from __future__ import annotations

from typing import Any

import pytest

from analysis.commands.report import write_experiment_report
from made_up_trials import made_up_results
from report_in_browser import inspect


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What headless Chromium finds in a report of made-up results."""
    folder = tmp_path_factory.mktemp("experiment")
    report = write_experiment_report([made_up_results(folder / "results")], folder / "report")
    return inspect(report)


@pytest.mark.parametrize("view", ["light", "dark", "narrow"])
def test_axe_finds_no_violation(seen: dict[str, Any], view: str) -> None:
    """No rule of axe-core is broken, and nobody has to scroll the page sideways."""
    assert seen["violations"][view] == []
    assert seen["wide"][view] <= 0


def test_no_request_leaves_the_page(seen: dict[str, Any]) -> None:
    """Opened, the page asks for nothing, and its policy blocks nothing of its own."""
    assert seen["requests"] == []
    assert seen["errors"] == []
