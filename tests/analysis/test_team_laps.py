"""Laps in the report: from recordings alone, the same as counted again from places and gates."""

from __future__ import annotations

import dataclasses

import pytest

from analysis.figures.team_laps import team_laps
from analysis.laps import lap_rows, points_of_a_lap
from analysis.recordings import StudyRecordings, load_recordings
from analysis.report import render_report
from analysis.results import StudyResults, compute_results
from analysis.tables.study_tables import StudyTables
from extras import need
from protocols import lap_study
from study.arena.course import Bucket, Course, Gate, StartRegion
from study.arena.laps import Progress, advance
from study.commands.simulating import simulate_study
from study.events.events import EpisodeEnded, Timestep, TrialStarted
from study.events.inputs import FleetObserved
from study.events.scene import Scene
from study.verification import verify

need("mujoco")


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> StudyRecordings:
    """One simulated participant with trials long enough for laps."""
    folder = tmp_path_factory.mktemp("laps")
    path = lap_study(folder, None)
    text = path.read_text()
    for old, new in (
        ("episode_timesteps = 30", "episode_timesteps = 400"),
        ("trials = 2\ntrial_timesteps = 60", "trials = 1\ntrial_timesteps = 600"),
        ("at_least = 4", "at_least = 2"),
    ):
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    (session,) = simulate_study(str(path), 1, 5, folder / "out", 1)
    assert verify(session.path).matches
    return load_recordings([folder / "out"])


@pytest.fixture(scope="module")
def results(study: StudyRecordings) -> StudyResults:
    return compute_results(study, StudyTables(study))


def course_of(scene: Scene) -> Course:
    """Build the course from the map as recorded."""
    return Course(
        scene.width,
        scene.height,
        tuple(Bucket(d.x, d.y, d.radius) for d in scene.discs if d.role == "wall"),
        tuple(Gate(*dataclasses.astuple(gate)) for gate in scene.gates),
        StartRegion(0, 0, 0, 0, 0),
    )


def counted_again(study: StudyRecordings) -> dict[str, int]:
    """Count laps from recorded places and the gates of the recorded map."""
    (session,) = study.sessions
    course = course_of(session.task.scene)
    progress: list[Progress] = []
    places: list[tuple[float, float]] = []
    laps: dict[str, int] = {}
    trial: TrialStarted | None = None
    after: FleetObserved | None = None
    topics = (TrialStarted.topic, FleetObserved.topic, Timestep.topic, EpisodeEnded.topic)
    for _, record in session.recording.records(*topics):
        if isinstance(record, TrialStarted):
            trial = record
            progress = [Progress()] * record.robots
            places = [(float(x), float(y)) for x, y in record.states[:, :2]]
        elif isinstance(record, FleetObserved):
            after = record
        elif isinstance(record, EpisodeEnded):
            progress[record.robot] = Progress()
        elif isinstance(record, Timestep) and trial is not None and after is not None:
            for robot in range(record.robots):
                x, y = map(float, after.states[robot, :2])
                now = advance(course, progress[robot], places[robot], (x, y))
                more = now.laps - progress[robot].laps
                laps[trial.condition] = laps.get(trial.condition, 0) + more
                progress[robot], places[robot] = now, (x, y)
    return laps


def test_laps_are_those_counted_again(study: StudyRecordings, results: StudyResults) -> None:
    """Points say as many laps as the recorded places do, and there are some."""
    again = counted_again(study)
    rows = lap_rows(results)
    assert {row.label.lower(): row.total for row in rows} == {
        name: again[name] for name in ("manual", "assisted")
    }
    assert sum(row.total for row in rows) >= 2
    for row in rows:
        assert row.trials == 1
        assert row.per_trial == row.total
        assert row.laps == {"S01": (row.total,)}


def test_the_report_shows_both_conditions(results: StudyResults) -> None:
    """Team laps by condition, and phi over the arena with its buckets and finish line."""
    page = render_report(results)
    assert '<section id="laps"' in page
    drawing = str(team_laps("laps", lap_rows(results)).markup())
    assert "Manual" in drawing
    assert "Assisted" in drawing
    assert "By heading<" in page
    assert "dashed, the finish line" in page
    assert "health pack" not in page


def test_without_laps_no_word_of_them(results: StudyResults) -> None:
    """A lap that earns nothing, or not alone, cannot be told from points."""
    task = results.study.first.task
    assert points_of_a_lap(task) == 1.0
    (term,) = task.rewards
    worthless = dataclasses.replace(task, rewards=(dataclasses.replace(term, value=0.0),))
    assert points_of_a_lap(worthless) is None
    other = dataclasses.replace(term, name="goal")
    assert points_of_a_lap(dataclasses.replace(task, rewards=(term, other))) is None
    open_map = dataclasses.replace(task, scene=dataclasses.replace(task.scene, gates=()))
    assert points_of_a_lap(open_map) is None
