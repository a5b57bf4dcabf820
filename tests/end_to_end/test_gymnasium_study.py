"""An environment of Gymnasium as a whole study: simulated, replayed, analysed, and live."""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pygame
import pytest
from typer.testing import CliRunner

from analysis.commands.main import app as analysis_app
from protocols import variant
from study.commands.composing import session_opened
from study.commands.recorded_scorers import recorded_weights
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
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.drawing.fleet import tile_places
from study.shell.fitting import InlineFitter
from study.shell.fleet import open_fleet
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.picture_records import PictureRecords
from study.shell.raw_inputs import RawInput, RawKey
from study.shell.window import Window
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import draw_parameters
from study.verification import verify

pytest.importorskip("gymnasium")

SHORTER = (
    ("episodes = 4", "episodes = 1"),
    ("timesteps = 200", "timesteps = 20"),
    ("trials = 2", "trials = 1"),
    ("trial_timesteps = 300", "trial_timesteps = 40"),
    ("epochs = 100", "epochs = 2"),
    ("at_least = 4", "at_least = 2"),
)


@pytest.fixture(scope="module")
def loaded(tmp_path_factory: pytest.TempPathFactory) -> LoadedProtocol:
    """The shipped protocol of carts, shorter."""
    folder = tmp_path_factory.mktemp("protocol")
    return load_protocol(str(variant(folder, *SHORTER, base="cart_pole")))


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


class _Hands(Window):
    """A window at which a simulated participant sits, in real time."""

    operator: SimulatedOperator
    clock: LiveClock
    colours: list[int]

    def poll(self) -> list[RawInput]:
        """Return what the participant presses at what is shown."""
        super().poll()
        screen = self.screen
        if screen is None:
            return []
        now = time.perf_counter_ns()
        strokes = self.operator.act(screen, self.clock.now())
        return [RawKey(stroke.key, stroke.down, now, 0) for stroke in strokes]

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


QUICK = {"words_per_second": 1000.0, "page_minimum_s": 0.05, "answer_delay_s": 0.05}


def test_a_live_session_shows_moving_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In a window, on the real clock, tiles show the carts, and timesteps are punctual.

    Recorded they are, too, and nothing is late for that.
    """
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    faster = (("timesteps_per_second = 10.0", "timesteps_per_second = 20.0"),)
    loaded = load_protocol(str(variant(tmp_path, *SHORTER, *faster, base="cart_pole")))
    (assignment,) = simulated_assignments(loaded, 1, seed=5)
    task, recorder, clock = loaded.protocol.task, _Kept(), LiveClock()
    fleet, fitter = (
        open_fleet(task.name, task.parameters),
        InlineFitter(loaded.description, recorded_weights(loaded)),
    )
    with closing(fleet), closing(fitter), closing(_Hands((1280, 960))) as window:
        parameters = draw_parameters(5, 0).model_copy(update=QUICK)
        window.operator, window.clock = SimulatedOperator(parameters, 1), clock
        window.colours = []
        conductor = Conductor(
            Session(), recorder, fleet, fitter,
            epoch_ns=0, waits_for_disk=False, on_pictures=window.pictures.take,
            picture_records=PictureRecords(lambda: True),
        )  # fmt: skip
        conductor.feed(session_opened(loaded, assignment))
        LiveLoop(conductor, window, recorder, clock).run()  # type: ignore[arg-type]
    assert conductor.session.complete
    # A cart on its track, a pole: never words or an empty tile.
    assert len(window.colours) > 100
    assert np.mean(np.array(window.colours) > 10) > 0.95
    timings = [r for r in recorder.records if isinstance(r, TrialTiming) and r.timesteps > 20]
    assert timings
    for timing in timings:
        assert timing.timestep_mean == pytest.approx(0.05, rel=0.2)
    taken = [record for record in recorder.records if isinstance(record, PicturesTaken)]
    answers = {record.t_ns for record in recorder.records if isinstance(record, FleetObserved)}
    assert {record.t_ns for record in taken} <= answers
    assert len(taken) > 150
    assert {(record.robots, len(record.shown)) for record in taken} >= {(1, 1), (6, 6), (6, 1)}
