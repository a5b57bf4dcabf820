"""Settings that are valid and pointless are told, and nothing is told of those that are not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from command_line import study
from protocols import ROOT, variant
from study.commands.preflight import _checks
from study.commands.running import Seat
from study.commands.simulating import simulated_assignments
from study.loading import load_protocol, shipped_protocols
from study.remarks import remark_on_consent, remarks

# Smoke: 2 conditions of 1 trial with 30 timesteps, a dwell of 15 at 10 a second.
POINTLESS: dict[str, tuple[list[tuple[str, str]], list[str]]] = {
    "dwell longer than a trial": (
        [("dwell = 15", "dwell = 9999")],
        ["conditions.assisted.dwell: 9999 given", "timesteps: the robot is never switched"],
    ),
    "rule that leaves out everybody": (
        [("at_least = 2", "at_least = 99999")],
        ["exclusions.incomplete.at_least: 99999 given", "at most", "everybody is left out"],
    ),
    "rule that leaves out nobody": (
        [("at_least = 2", "at_least = 0")],
        ["exclusions.incomplete.at_least: 0 given", "nobody is left out"],
    ),
    "rule on choices that cannot be": (
        [('"complete_trials"', '"choices"'), ("at_least = 2", "at_least = 1000")],
        ["at_least: 1000 given", "choices: everybody"],
    ),
    "rule on demonstrations that cannot be": (
        [('"complete_trials"', '"demonstrations"'), ("at_least = 2", "at_least = 10000")],
        ["at_least: 10000 given", "demonstrations: everybody"],
    ),
    "switches announced all the time": (
        [("[keys]", "[switching]\ncue_seconds = 1.5\n\n[keys]")],
        ["switching.cue_seconds: 1.5 s given", "the dwell of assisted is 1.50 s"],
    ),
    "every demonstration flagged": (
        [("[keys]", "[switching]\ngrace_seconds = 9\n\n[keys]")],
        ["switching.grace_seconds: 9 s given", "every demonstration is flagged"],
    ),
    "episodes that end before": (
        [("episodes = 2", "episodes = 2\nepisode_timesteps = 21")],
        ["phase_one.episode_timesteps: 21 given", "after 20: it is never reached"],
    ),
    "breaks that never come": (
        [("[keys]", "[breaks]\nseconds = 10\nevery_trials = 50\n\n[keys]")],
        ["breaks.every_trials: 50 given", "no break within one"],
    ),
    "breaks longer than they say": (
        [("[keys]", "[breaks]\nseconds = 10\nminimum_seconds = 20\n\n[keys]")],
        ["breaks.minimum_seconds: 20 given", "more than the suggested 10 s"],
    ),
}


def remarks_on(path: Path) -> list[str]:
    """Return what is remarked on a file."""
    loaded = load_protocol(str(path))
    return remarks(loaded.protocol, loaded.description.horizon)


def consent_remark_on(path: Path) -> str:
    """Return what is remarked on a file's consent."""
    return remark_on_consent(load_protocol(str(path)).protocol)


def shipped_studies() -> list[Path]:
    """Return the shipped protocols, experiments left out."""
    paths = sorted(shipped_protocols().glob("*.toml"))
    return [path for path in paths if "\n[experiment]" not in path.read_text()]


@pytest.mark.parametrize("case", POINTLESS)
def test_what_is_pointless_is_told(tmp_path: Path, case: str) -> None:
    """One sentence: key path, what was given, what comes of it."""
    changes, words = POINTLESS[case]
    (remark,) = remarks_on(variant(tmp_path, *changes))
    assert [word for word in words if word not in remark] == [], remark


def test_what_can_just_be_is_not(tmp_path: Path) -> None:
    """A rule that asks for all trials there are, and a dwell that ends before the trial does."""
    assert remarks_on(variant(tmp_path, ("dwell = 15", "dwell = 29"))) == []


def test_preflight_tells_before_anything_else(tmp_path: Path) -> None:
    """Amber: a session can begin all the same."""
    path = variant(tmp_path, ("at_least = 2", "at_least = 99999"))
    loaded = load_protocol(str(path))
    (assignment,) = simulated_assignments(loaded, 1, seed=1)
    checks = _checks(loaded, assignment, tmp_path, Seat(None), with_keys=False)
    first = next(checks)
    assert (first.name, first.state) == ("protocol", "amber")
    assert "everybody is left out" in first.found


def test_nothing_is_told_of_what_is_shipped() -> None:
    """Each shipped study makes sense."""
    studies = shipped_studies()
    assert {path.stem: remarks_on(path) for path in studies} == {path.stem: [] for path in studies}


def test_validate_tells_and_accepts(tmp_path: Path) -> None:
    """It is the study's to decide: exit status 0, and the remark on what is printed."""
    done = study("validate", variant(tmp_path, ("dwell = 15", "dwell = 9999")))
    assert done.returncode == 0, done.stderr
    assert "To consider: conditions.assisted.dwell: 9999 given" in done.stdout
    assert "To consider" not in study("validate", "every_screen").stdout


def test_a_study_without_a_consent_page_is_told_of(tmp_path: Path) -> None:
    """Of all that is shipped one has a page; a page that is added ends the remark."""
    asks = {path.stem: not consent_remark_on(path) for path in shipped_studies()}
    assert [name for name, page in asks.items() if page] == ["every_screen"]
    (line,) = [
        each for each in study("validate", "smoke").stdout.splitlines() if "consider" in each
    ]
    assert line.startswith(
        "To consider: consent: there is none, so participants are asked on paper"
    )
    guide = re.findall(r"docs/how-to/\S+\.md", line)
    (example,) = re.findall(r"```toml\n(\[consent\]\n.*?)```", (ROOT / guide[0]).read_text(), re.S)
    path = variant(tmp_path, ("[keys]", f"{example}\n[keys]"))
    assert consent_remark_on(path) == ""
    assert "To consider" not in study("validate", path).stdout


@pytest.mark.parametrize("name", ["smoke", "every_screen"])
def test_preflight_tells_and_can_be_green(tmp_path: Path, name: str) -> None:
    """A laboratory with consent on paper is kept from nothing; the rehearsal's line says so."""
    loaded = load_protocol(name)
    (assignment,) = simulated_assignments(loaded, 1, seed=1)
    first = next(_checks(loaded, assignment, tmp_path, Seat(None), with_keys=False))
    assert (first.name, first.state) == ("rehearsal", "green")
    assert ("no consent page: ask on paper" in first.found) == (name == "smoke")
