"""From a locked plan by way of recordings to what the report calls its results."""

from __future__ import annotations

import html
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from analysis.commands.report import write_report
from protocols import variant
from study.commands import main as command
from study.commands.simulating import simulate_session, simulated_assignments
from study.errors import StudyError
from study.loading import load_protocol


def record(protocol: Path, place: int, folder: Path) -> Path:
    """Record one simulated participant."""
    assignment = simulated_assignments(load_protocol(str(protocol)), 2, seed=5)[place]
    return simulate_session(str(protocol), assignment, 5, folder)


def test_a_plan_is_confirmatory_until_it_changes(tmp_path: Path) -> None:
    """Locked before the first record: confirmatory. Changed since: refused, or pooled aloud."""
    protocol, recordings = variant(tmp_path), tmp_path / "recordings"
    assert CliRunner().invoke(command.app, ["lock", str(protocol)]).exit_code == 0
    record(protocol, 0, recordings)
    page = write_report([recordings], tmp_path / "first").read_text()
    assert '<span class="badge confirmatory">Confirmatory, simulated data</span>' in page
    assert "are as they were locked on" in page
    assert "before the first record, and have not changed since" in page

    text = protocol.read_text()
    protocol.write_text(text.replace("timesteps_per_second = 10.0", "timesteps_per_second = 9.0"))
    assert protocol.read_text() != text
    record(protocol, 1, recordings)
    with pytest.raises(StudyError, match="2 different protocols"):
        write_report([recordings], tmp_path / "second")
    console = Console(record=True, width=200, stderr=True)
    page = html.unescape(
        write_report([recordings], tmp_path / "pooled", console, pool=True).read_text()
    )
    assert "WARNING: 2 different protocols are pooled" in console.export_text()
    assert "2 different protocols are pooled, as asked." in page
    assert "badge confirmatory" not in page.split("</style>")[1]
    assert "-timesteps_per_second = 10.0" in page
    assert "+timesteps_per_second = 9.0" in page
