"""An environment of Gymnasium as a whole study: simulated, replayed, analysed, and live."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pygame
import pytest
from typer.testing import CliRunner

from analysis.commands.main import app as analysis_app
from operated_window import OperatedWindow, go_through
from protocols import FASTER_CARTS, SHORT_CARTS, variant
from study.commands.composing import session_opened
from study.commands.simulating import simulate_session, simulated_assignments
from study.events.codes import ActionSource
from study.events.events import Timestep
from study.events.fields import Record
from study.events.inputs import FleetObserved
from study.events.shell import PicturesTaken, TrialTiming
from study.foxglove.export import export
from study.loading import LoadedProtocol, load_protocol
from study.recording.reader import read_recording
from study.screens import FleetScreen
from study.shell.drawing.fleet_places import tile_places
from study.shell.picture_records import PictureRecords
from study.verification import verify

pytest.importorskip("gymnasium")


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedProtocol:
    """The shipped protocol of carts, shorter."""
    folder = tmp_path_factory.mktemp("protocol")
    return load_protocol(str(variant(folder, *SHORT_CARTS, base="cart_pole")))


@pytest.fixture(scope="module")
def recordings(loaded: LoadedProtocol, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two simulated participants."""
    folder = tmp_path_factory.mktemp("recordings")
    for assignment in simulated_assignments(loaded, 2, seed=5):
        simulate_session(str(loaded.path), assignment, 5, folder)
    return folder


def test_sessions_replay_and_step_anew(recordings: Path) -> None:
    """The events follow from the inputs, and the environment repeats its states to the bit."""
    for path in sorted(recordings.glob("*.mcap")):
        verdict = verify(path, resimulate=True)
        assert verdict.matches, verdict.difference
        assert verdict.resimulated > 150
        assert verdict.largest_deviation == 0.0


def test_only_keys_demonstrate(loaded: LoadedProtocol, recordings: Path) -> None:
    """Both keys are among the demonstrations; waiting is none, and no policy's action."""
    idle = loaded.description.idle_action
    shown: dict[int, set[int]] = {source: set() for source in ActionSource}
    for path in sorted(recordings.glob("*.mcap")):
        for _, row in read_recording(path).records("event/timestep"):
            assert isinstance(row, Timestep)
            for action, source in zip(row.actions, row.action_sources, strict=True):
                shown[int(source)].add(int(action))
    assert shown[ActionSource.OPERATOR] == {0, 1}
    assert shown[ActionSource.POLICY] == {0, 1}
    assert shown[ActionSource.OPERATOR_IDLE] == {idle}


def test_the_report_is_made(recordings: Path, tmp_path: Path) -> None:
    """Nothing of the analysis needs a map: tables, tests and figures are there, and no heat map."""
    done = CliRunner().invoke(analysis_app, ["report", str(recordings), "-o", str(tmp_path / "r")])
    assert done.exit_code == 0, done.output
    page = (tmp_path / "r" / "report.html").read_text(encoding="utf-8")
    assert "gymnasium:CartPole-v1" in page
    assert page.count("<svg") > 3


def test_foxglove_has_no_scene_of_it(recordings: Path, tmp_path: Path) -> None:
    """A recording without places is exported, and it is said why no robots are drawn."""
    done = export(min(recordings.glob("*.mcap")), tmp_path / "x.mcap", 5.0, lambda *_: None)
    assert done.records > 100
    assert done.without_scene


class _ColourWindow(OperatedWindow):
    """A window that counts the colours of the first tile's picture."""

    def __init__(self) -> None:
        super().__init__((1280, 960), seed=5)
        self.colours: list[int] = []

    def present(self) -> None:
        """Count the colours of the first tile's picture, then present."""
        super().present()
        if isinstance(self.screen, FleetScreen) and self.screen.tiles:
            place = tile_places(self._painter.canvas, self.screen)[0].map  # type: ignore[attr-defined]
            pixels = pygame.surfarray.array2d(self._surface.subsurface(place))[::5, ::5]
            self.colours.append(len(np.unique(pixels)))


class _Kept:
    """A recorder that keeps records in memory."""

    durable_sequence = sent_sequence = 0

    def __init__(self) -> None:
        self.records: list[Record] = []

    def write(self, record: Record, log_time_ns: int) -> int:
        self.records.append(record)
        return len(self.records)

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        self.records += [record for record, _ in records]
        return len(self.records)

    def ensure_durable(self, timeout_s: float) -> bool:
        return True

    def check(self, now_ns: int) -> None:
        return None

    def take_remarks(self) -> list[str]:
        return []


@pytest.mark.acceptance
def test_a_live_session_shows_moving_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the real clock, in a window, tiles show the carts; timesteps do not wait for pictures.

    Nor do they for their recording.
    """
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    loaded = load_protocol(str(variant(tmp_path, *SHORT_CARTS, FASTER_CARTS, base="cart_pole")))
    (assignment,) = simulated_assignments(loaded, 1, seed=5)
    recorder = _Kept()
    with closing(_ColourWindow()) as window:
        session = go_through(
            window, loaded, session_opened(loaded, assignment), recorder,
            picture_records=PictureRecords(lambda: True),
        )  # fmt: skip
    assert session.complete
    # A cart on its track, a pole: never words or an empty tile.
    assert len(window.colours) > 100
    assert np.mean(np.array(window.colours) > 10) > 0.95
    timings = [r for r in recorder.records if isinstance(r, TrialTiming) and r.timesteps > 20]
    assert timings
    for timing in timings:
        # On a quiet machine 0.05; what else runs takes its share.
        assert 0.045 < timing.timestep_mean < 0.1
    taken = [record for record in recorder.records if isinstance(record, PicturesTaken)]
    answers = {record.t_ns for record in recorder.records if isinstance(record, FleetObserved)}
    assert {record.t_ns for record in taken} <= answers
    assert len(taken) > 150
    assert {(record.robots, len(record.shown)) for record in taken} >= {(1, 1), (6, 6), (6, 1)}
