"""Minari data sets: loaded back, they hold what the recordings hold, to the byte."""

from __future__ import annotations

import dataclasses
import stat
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from analysis.commands.main import app
from analysis.export import minari_data
from analysis.recordings import StudyRecordings, load_recordings
from protocols import variant
from study.commands.simulating import simulate_session, simulated_assignments
from study.errors import StudyError
from study.events.codes import ActionSource, Outcome
from study.events.events import EpisodeEnded, Timestep
from study.events.inputs import FleetObserved
from study.loading import load_protocol
from study.recording.reader import read_recording
from study.training_sets import demonstrations

minari = pytest.importorskip("minari")
pytest.importorskip("h5py")

NAME = "smoke"


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two simulated participants of the smoke study."""
    folder = tmp_path_factory.mktemp("recordings")
    path = str(variant(tmp_path_factory.mktemp("protocol")))
    for assignment in simulated_assignments(load_protocol(path), 2, seed=5):
        simulate_session(path, assignment, 5, folder)
    return folder


@pytest.fixture(scope="module")
def exported(recordings: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Their export, by the command."""
    folder: Path = tmp_path_factory.mktemp("minari_export") / "out"
    done = CliRunner().invoke(app, ["export", str(recordings), "-o", str(folder), "--minari"])
    assert done.exit_code == 0, done.output
    return folder


@pytest.fixture
def load(exported: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Minari's own way to load a data set, from where the export says that it lies."""
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(exported / "minari"))
    return lambda kind: minari.load_dataset(f"{NAME}/{kind}-v0")


@dataclasses.dataclass
class Seen:
    """An episode as the records tell it one by one."""

    participant: str
    trial_id: int
    robot: int
    states: list[bytes] = dataclasses.field(default_factory=list)
    actions: list[int] = dataclasses.field(default_factory=list)
    rewards: list[float] = dataclasses.field(default_factory=list)
    sources: list[int] = dataclasses.field(default_factory=list)
    last: bytes = b""
    outcome: int = Outcome.RUNNING


def told(path: Path) -> Iterator[Seen]:
    """Yield the episodes of a recording from its records, in order of trial, robot and time."""
    running: dict[int, Seen] = {}
    done: list[Seen] = []
    answer: FleetObserved | None = None
    recording = read_recording(path)
    participant = path.stem.split("_")[1]
    trial = -1
    for _, record in recording.records(FleetObserved.topic, Timestep.topic):
        if isinstance(record, FleetObserved):
            answer = record
            continue
        assert isinstance(record, Timestep)
        assert answer is not None
        if record.trial_id != trial:
            done += running.values()
            running, trial = {}, record.trial_id
        for robot, source in enumerate(record.action_sources):
            if source == ActionSource.INACTIVE:
                continue
            seen = running.setdefault(robot, Seen(participant, trial, robot))
            seen.states.append(record.states[robot].tobytes())
            seen.actions.append(int(record.actions[robot]))
            seen.rewards.append(float(record.rewards[robot]))
            seen.sources.append(int(source))
            seen.last = answer.states[robot].tobytes()
            seen.outcome = int(record.outcomes[robot])
            if seen.outcome != Outcome.RUNNING:
                done.append(running.pop(robot))
    done += running.values()
    by_robot = sorted(range(len(done)), key=lambda k: (done[k].trial_id, done[k].robot, k))
    yield from (done[k] for k in by_robot)


def test_episodes_are_the_recording_s(recordings: Path, load: Any) -> None:
    """Every state, action, reward and source of every robot, in order; nothing else."""
    data = load("episodes")
    expected = [seen for path in sorted(recordings.glob("*.mcap")) for seen in told(path)]
    assert data.total_episodes == len(expected) > 100
    notes = list(data.storage.get_episode_metadata(range(data.total_episodes)))
    for episode, note, seen in zip(data, notes, expected, strict=True):
        steps = len(seen.actions)
        assert episode.observations.dtype == np.float32
        assert [row.tobytes() for row in episode.observations] == [*seen.states, seen.last]
        assert episode.actions.tolist() == seen.actions
        assert episode.rewards.tolist() == seen.rewards
        assert episode.infos["action_source"].tolist() == [*seen.sources, minari_data.NOBODY]
        ended = seen.outcome in (Outcome.GOAL, Outcome.LOST)
        assert episode.terminations.tolist() == [False] * (steps - 1) + [ended]
        assert episode.truncations.tolist() == [False] * (steps - 1) + [not ended]
        told_of = (note["participant"], note["trial_id"], note["robot"] - 1)
        assert told_of == (seen.participant, seen.trial_id, seen.robot)
        assert note["outcome"] == Outcome(seen.outcome).name.lower()
    assert {seen.outcome for seen in expected} >= {Outcome.RUNNING, Outcome.TIME_UP}


def test_ended_episodes_earn_what_was_recorded(recordings: Path, load: Any) -> None:
    """The reward of an episode that ended is that of its event, by number of the episode."""
    earned = {}
    for path in sorted(recordings.glob("*.mcap")):
        for _, record in read_recording(path).records(EpisodeEnded.topic):
            assert isinstance(record, EpisodeEnded)
            place = (path.stem.split("_")[1], record.trial_id, record.robot + 1, record.episode)
            earned[place] = (record.length, record.episode_reward)
    data = load("episodes")
    notes = data.storage.get_episode_metadata(range(data.total_episodes))
    found = {
        (n["participant"], n["trial_id"], n["robot"], n["episode"]): e
        for e, n in zip(data, notes, strict=True)
    }
    assert len(earned) > 50
    for place, (length, reward) in earned.items():
        assert len(found[place]) == length
        assert float(found[place].rewards.astype(np.float64).sum()) == pytest.approx(reward)


def test_demonstrations_are_those_that_a_policy_is_fitted_to(recordings: Path, load: Any) -> None:
    """The same states and actions as `study.training_sets` takes, and nobody else's."""
    expected = []
    for path in sorted(recordings.glob("*.mcap")):
        rows = [row for _, row in read_recording(path).records(Timestep.topic)]
        taken = demonstrations(rows, 4)  # type: ignore[arg-type]
        expected += [
            (state.tobytes(), int(action))
            for state, action in zip(taken.states, taken.actions, strict=True)
        ]
    data = load("demonstrations")
    shown = []
    for episode in data:
        assert set(episode.infos["action_source"][:-1].tolist()) == {ActionSource.OPERATOR}
        assert np.diff(episode.infos["timestep"]).tolist() == [1] * len(episode)
        shown += [
            (state.tobytes(), int(action))
            for state, action in zip(episode.observations[:-1], episode.actions, strict=True)
        ]
    assert len(expected) > 100
    assert sorted(shown) == sorted(expected)
    # The same can be had from whole episodes by who acted.
    filtered = []
    for episode in load("episodes"):
        mine = episode.infos["action_source"][:-1] == ActionSource.OPERATOR
        filtered += [
            (state.tobytes(), int(action))
            for state, action in zip(
                episode.observations[:-1][mine], episode.actions[mine], strict=True
            )
        ]
    assert sorted(filtered) == sorted(expected)


def test_data_sets_say_where_they_come_from(recordings: Path, load: Any) -> None:
    """Protocol and recordings by their hashes, participants by pseudonym, names of all numbers."""
    about = load("episodes").storage.metadata
    study = load_recordings([recordings])
    assert about["protocol_sha256"] == list(study.protocol_hashes)
    assert about["recordings_sha256"] == {
        path.name: read_recording(path).sha256 for path in recordings.glob("*.mcap")
    }
    assert about["participants"] == ["S01", "S02"]
    assert about["operator_kinds"] == ["simulated"]
    assert about["state_names"] == ["x", "y", "heading", "health"]
    assert about["action_names"][about["idle_action"]] == "idle"
    assert load("episodes").observation_space.contains(load("episodes")[0].observations[0])
    assert load("episodes").action_space.n == len(about["action_names"])


def test_files_are_private(exported: Path) -> None:
    """They tell of participants: their owner alone can read them, and no half-made one is left."""
    inside = [exported / "minari", *(exported / "minari").rglob("*")]
    assert len(inside) >= 8
    for path in inside:
        assert stat.S_IMODE(path.stat().st_mode) in (0o600, 0o700), path
    assert not list(exported.glob(".minari*"))


def test_a_relative_folder_is_below_the_present_one(
    recordings: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Minari would look for it below its own."""
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["export", str(recordings), "-o", "out", "--minari"])
    assert done.exit_code == 0, done.output
    monkeypatch.setenv("MINARI_DATASETS_PATH", "out/minari")
    assert minari.load_dataset(f"{NAME}/episodes-v0").total_episodes > 0


def test_an_export_is_made_anew(recordings: Path, tmp_path: Path) -> None:
    """A second one replaces the first, and holds the same."""
    study = load_recordings([recordings])
    assert minari_data.export(study, tmp_path) == minari_data.export(study, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["minari"]


def test_missing_records_cut_an_episode(recordings: Path) -> None:
    """Where an answer of the fleet is missing no step is made up."""
    whole = load_recordings([recordings]).first
    blocks = whole.recording.columns("event/timestep")
    lost = int(blocks[0]["t_ns"][3])

    class Holed:
        def columns(self, topic: str) -> Any:
            found = whole.recording.columns(topic)
            if topic == FleetObserved.topic:
                kept = [block["t_ns"] != lost for block in found]
                return [
                    {name: values[rows] for name, values in block.items()}
                    for block, rows in zip(found, kept, strict=True)
                ]
            return found

    holed = dataclasses.replace(whole, recording=Holed())  # type: ignore[arg-type]
    before = [part for part, _ in minari_data.episodes_of(whole)]
    after = [part for part, _ in minari_data.episodes_of(holed)]
    assert sum(len(part.actions) for part in before) - 1 == sum(len(p.actions) for p in after)
    assert len(after) == len(before) + 1
    assert all(len(part.states) == len(part.actions) + 1 for part in after)


def test_without_minari_it_is_said_what_to_install(
    study: StudyRecordings, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The packages are an extra."""
    monkeypatch.setitem(sys.modules, "minari", None)
    with pytest.raises(StudyError, match='extra "minari"'):
        minari_data.export(study, tmp_path)
    assert not list(tmp_path.iterdir())


def test_different_tasks_do_not_make_one_data_set(study: StudyRecordings, tmp_path: Path) -> None:
    """Pooled recordings of different tasks have no common space."""
    first, second, *rest = study.sessions
    opened = dataclasses.replace(second.opened, task_json=second.opened.task_json + " ")
    odd = dataclasses.replace(
        study, sessions=(first, dataclasses.replace(second, opened=opened), *rest)
    )
    with pytest.raises(StudyError, match="2 different tasks"):
        minari_data.export(odd, tmp_path)
