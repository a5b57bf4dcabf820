"""The report in a real browser: accessible, quiet on the network, usable by keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from analysis.commands.report import write_report
from report_in_browser import inspect
from synthetic_study import CROSSED, Plan, study_plans, write_session


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The report of six whole sessions and one that broke off, with its tables beside it."""
    recordings: Path = tmp_path_factory.mktemp("recordings")
    for plan in study_plans(6, trials=3, timesteps=12, planned=7):
        write_session(recordings, plan)
    write_session(recordings, Plan("P07", 6, stop_after=10, trials=3, timesteps=12, planned=7))
    return write_report([recordings], tmp_path_factory.mktemp("report")).parent


@pytest.fixture(scope="module")
def seen(folder: Path) -> dict[str, Any]:
    """What the browser finds in it."""
    return inspect(folder / "report.html")


@pytest.mark.parametrize("view", ["light", "dark", "narrow"])
def test_axe_finds_no_violation(seen: dict[str, Any], view: str) -> None:
    """No rule of axe-core is broken, and nobody has to scroll the page sideways."""
    assert seen["violations"][view] == []
    assert seen["wide"][view] <= 0


def test_no_request_leaves_the_page(seen: dict[str, Any]) -> None:
    """Opened and used, the page asks for nothing, and its policy blocks nothing of its own."""
    assert seen["requests"] == []
    assert seen["errors"] == []


def test_every_contents_link_leads_to_its_section(seen: dict[str, Any]) -> None:
    """By keyboard each link brings its section into view, and the contents stay in view."""
    hashes = [link["hash"] for link in seen["links"]]
    assert {"#summary", "#checks", "#participants", "#downloads"} <= set(hashes)
    assert len(hashes) == len(set(hashes))
    assert all(link["section"] and link["contents"] for link in seen["links"])
    assert seen["first"] == "skip"


def test_every_table_inside_the_page_is_downloaded_whole(
    seen: dict[str, Any], folder: Path
) -> None:
    """Each download button gives the very file that lies beside the report."""
    names = {download["name"] for download in seen["downloads"]}
    assert {"sessions.csv", "trials.csv", "responses.csv"} <= names
    for download in seen["downloads"]:
        assert download["text"] == (folder / "tables" / download["name"]).read_text()


def test_text_is_copied_and_the_theme_changes_by_keyboard(seen: dict[str, Any]) -> None:
    """A copy button selects its text; Enter on the theme's button changes the page, not paper."""
    assert "Team reward is the sum of all robots" in seen["copied"]
    assert seen["theme"] == "dark"
    assert seen["paper"] == "rgb(255, 255, 255)"


def test_every_figure_says_what_it_shows(seen: dict[str, Any]) -> None:
    """Each drawing has a name of its own for those who cannot see it."""
    assert len(seen["named"]) > 10
    assert all(len(name) > 10 for name in seen["named"])
    assert len(seen["named"]) == len(set(seen["named"]))


@pytest.mark.acceptance
def test_crossed_factors_are_accessible_too(tmp_path: Path) -> None:
    """The report of conditions that cross two factors breaks no rule either, in any view."""
    for plan in study_plans(4, trials=1, timesteps=4, conditions=CROSSED, phase_four=False):
        write_session(tmp_path, plan)
    found = inspect(write_report([tmp_path], tmp_path / "report"))
    assert found["violations"] == {"light": [], "dark": [], "narrow": []}
    assert max(found["wide"].values()) <= 0
    assert any("by allocation and fleet size" in name for name in found["named"])


def test_refusals_and_hostile_names_break_nothing(tmp_path: Path) -> None:
    """A study of one person with an id that tries to be markup is accessible too."""
    plan = Plan("<img src=x onerror=alert(1)>", 0, trials=1, timesteps=4, operator_kind="person")
    write_session(tmp_path, plan)
    found = inspect(write_report([tmp_path], tmp_path / "report"))
    assert found["violations"] == {"light": [], "dark": [], "narrow": []}
    assert found["requests"] == []
    assert found["errors"] == []
