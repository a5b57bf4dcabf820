"""The report: repeatable, self-contained, escaped, honest about its data."""

from __future__ import annotations

import base64
import dataclasses
import hashlib
import html
import re
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from analysis.commands import main as command
from analysis.recordings import load_recordings
from analysis.report import render_report
from analysis.results import StudyResults, compute_results
from analysis.sections import scorers
from analysis.statistics.result import EffectResult
from analysis.tables.study_tables import StudyTables
from synthetic_study import HOSTILE


def report_of(folder: Path) -> str:
    recordings = load_recordings([folder])
    return render_report(compute_results(recordings, StudyTables(recordings)))


@pytest.fixture(scope="module")
def page(results: StudyResults) -> str:
    return render_report(results)


@pytest.fixture(scope="module")
def hostile_page(hostile_folder: Path) -> str:
    return report_of(hostile_folder)


def test_second_run_gives_the_same_bytes(page: str, study_folder: Path, tmp_path: Path) -> None:
    """Reading everything again, from another folder, gives the same report to the byte."""
    copy = tmp_path / "elsewhere"
    shutil.copytree(study_folder, copy)
    assert report_of(copy) == page


def test_one_map_is_spoken_of_as_one(results: StudyResults) -> None:
    """With a single participant the sentence on peaks counts no maps."""
    study = dataclasses.replace(results.study, sessions=results.study.sessions[:1])
    sentence = scorers.peak_finding(dataclasses.replace(results, study=study))
    assert sentence.startswith("The landmark nearest to the highest peak of the one map is the ")


def test_a_remark_on_several_tests_stands_once(results: StudyResults) -> None:
    """The note under the table names the tests that share a remark."""
    noted = tuple(
        dataclasses.replace(test, note="Much is doubtful.")
        for test in results.sensitivity
        if isinstance(test, EffectResult)
    )
    assert len(noted) > 1
    page = render_report(dataclasses.replace(results, sensitivity=noted))
    names = "; ".join(test.name for test in noted)
    assert page.count("Much is doubtful.") == 1
    assert f"{names}: Much is doubtful." in page


def test_nothing_is_loaded_from_elsewhere(page: str) -> None:
    """No address of another place occurs; images and fonts are data, tables lie beside."""
    without_data = re.sub(r"data:[a-z/0-9+;=,-]+[A-Za-z0-9+/=]*", "data:", page)
    assert "http://" not in without_data
    assert "https://" not in without_data
    assert "//cdn" not in without_data
    targets = re.findall(r'(?:href|src)="([^"]*)"', page)
    assert targets
    assert all(t.startswith(("#", "data:", "tables/")) for t in targets)
    assert "@import" not in page


def test_security_policy_allows_exactly_the_page_itself(page: str) -> None:
    """Sheet and script match the hashes of the policy, and no style or handler is inline."""
    policy = html.unescape(
        re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1]  # type: ignore[index]
    )
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    for kind in ("style", "script"):
        blocks = re.findall(rf"<{kind}>(.*?)</{kind}>", page, flags=re.DOTALL)
        assert len(blocks) == 1
        digest = base64.b64encode(hashlib.sha256(blocks[0].encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert " style=" not in page
    assert not re.search(r"<[^>]* on[a-z]+=", page)


def test_ids_are_unique_and_every_link_has_its_target(page: str) -> None:
    """No id occurs twice; every link within the page leads somewhere."""
    ids = re.findall(r' id="([^"]*)"', page)
    assert len(ids) == len(set(ids))
    links = set(re.findall(r'href="#([^"]+)"', page))
    assert links <= set(ids)
    labels = re.findall(r'aria-labelledby="([^"]*)"', page)
    assert labels
    assert set(labels) <= set(ids)


def test_markup_in_the_data_stays_text(hostile_page: str) -> None:
    """Ids and titles that try to be markup are escaped, in the sheet and images too."""
    assert HOSTILE not in hostile_page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in hostile_page
    assert "<b onclick" not in hostile_page
    assert hostile_page.count("<script>") == 1
    assert hostile_page.count("</style>") == 1


def test_persons_are_not_called_simulated(hostile_page: str) -> None:
    """A report of persons carries no label of simulation."""
    assert "Simulated participants" not in hostile_page
    assert "2 persons" in hostile_page


def test_simulation_is_named_wherever_results_stand(page: str) -> None:
    """Banner, contents, print footer and table exports say that participants are simulated."""
    label = "Simulated participants, N = 8"
    banner = re.search(r'<div class="banner".*?</div>', page, flags=re.DOTALL)
    contents = re.search(r"<nav.*?</nav>", page, flags=re.DOTALL)
    footer = re.search(r"@bottom-left\{content:\"([^\"]*)\"", page)
    assert banner
    assert f"{label}, seeds 500 to 507" in banner[0]
    assert "attention_tiles 3" in banner[0]
    assert contents
    assert label in contents[0]
    assert footer
    assert footer[1] == label
    embedded = re.findall(r"data:text/csv;charset=utf-8;base64,([A-Za-z0-9+/=]+)", page)
    assert embedded
    for coded in embedded:
        lines = base64.b64decode(coded).decode().splitlines()
        assert all(label in line for line in lines[1:])


def test_headline_follows_from_the_interval(page: str, results: StudyResults) -> None:
    """The headline states the computed estimate, and a difference only if zero is outside."""
    primary = results.primary
    assert isinstance(primary, EffectResult)
    assert primary.interval is not None
    assert primary.estimate is not None
    sentence = html.unescape(
        re.search(r'<p class="headline">(.*?)</p>', page)[1]  # type: ignore[index]
    )
    assert f"{abs(primary.estimate):.1f} points a trial" in sentence
    assert ("No difference" in sentence) == primary.interval.holds(0.0)


def test_refusals_are_printed_with_their_reason(hostile_page: str) -> None:
    """With two participants the report says in words why nothing was tested."""
    assert "Team reward was not tested. 2 participants have data" in hostile_page
    assert "not computed." in hostile_page
    assert "at least 3" in hostile_page


def test_every_problem_is_listed(page: str) -> None:
    """Torn file, incomplete session, foreign file and deviation stand under data quality."""
    section = re.search(r'<section id="quality".*?</section>', page, flags=re.DOTALL)
    assert section
    assert "practice_repeated" not in section[0]
    for text in ("P08", "P07", "window closed", "notes.mcap", "Practice was repeated"):
        assert text in section[0]


def test_assumptions_and_hashes_are_printed(page: str, results: StudyResults) -> None:
    """Assumptions of the protocol and the SHA-256 of protocol and files are in the report."""
    assert "The source gives no rate; 8 keeps a dwell near two seconds." in page
    assert results.study.first.opened.protocol_sha256 in page
    assert all(session.recording.sha256 in page for session in results.study.sessions)


def test_command_writes_report_and_tables(study_folder: Path, tmp_path: Path) -> None:
    """`analysis report` writes both, says where, and replaces what is there."""
    runner = CliRunner()
    folder = tmp_path / "out"
    for _ in range(2):
        result = runner.invoke(command.app, ["report", str(study_folder), "-o", str(folder)])
        assert result.exit_code == 0
        assert str(folder / "report.html") in result.output.replace("\n", "")
    assert (folder / "report.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert (folder / "tables" / "trials.csv").is_file()
    assert not list(folder.glob(".*"))


def test_command_names_a_mistake_without_traceback(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder without recordings is one message on stderr and exit code 2."""
    monkeypatch.setattr("sys.argv", ["analysis", "tables", str(tmp_path), "-o", str(tmp_path)])
    with pytest.raises(SystemExit) as caught:
        command.main()
    assert caught.value.code == 2
    shown = capsys.readouterr().err
    assert "no recording" in shown
    assert "Traceback" not in shown
