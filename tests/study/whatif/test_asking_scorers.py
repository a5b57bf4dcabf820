"""What scorers say of recorded choices."""

from __future__ import annotations

import dataclasses
import math
import shutil
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
import safetensors.numpy
from hypothesis import given, settings
from hypothesis import strategies as st

from choosing_study import choosing_study, known_scorer
from study.commands.simulating import simulate_study
from study.commands.whatif import open_sessions
from study.errors import StudyError
from study.families import load_member
from study.loading import find_protocol
from study.recording.parts import read_session
from study.scorers.base import Scorer
from study.tasks import navigation
from study.training_sets import arrays_sha256
from study.whatif.fitting import parts_of_trials, training_choices
from study.whatif.named_scorers import asked_scorers, own_fit
from study.whatif.running import ask
from study.whatif.scoring import judge, judge_all, judge_runs, run_scores
from study.whatif.sessions import ChoiceSession, open_choices

NETWORK = known_scorer(0)


@pytest.fixture(scope="module")
def choosing_files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Six recordings, one a participant."""
    return choosing_study(tmp_path_factory.mktemp("choosing"), 6, trials=4, timesteps=40)


@pytest.fixture(scope="module")
def sessions(choosing_files: list[Path]) -> list[ChoiceSession]:
    """The choices in them."""
    return open_sessions(choosing_files)


def naive(scorer: Scorer, session: ChoiceSession) -> list[tuple[int, int, float]]:
    """Return (first, rank, log-likelihood) of each choice, one after the other."""
    found = []
    for run in session.runs:
        for row, chosen in zip(run.rows, run.chosen, strict=True):
            scores = scorer.scores(run.states[row])
            known = {i: scores[i] for i in range(len(scores)) if run.available[row, i]}
            first = max(known, key=lambda i: (known[i], -i))
            rank = 1 + sum(value > known[chosen] for value in known.values())
            total = sum(math.exp(value) for value in known.values())
            found.append((first, rank, float(known[chosen]) - math.log(total)))
    return found


def test_choices_are_judged_as_one_by_one(sessions: list[ChoiceSession]) -> None:
    """All at once gives what a loop over choices gives."""
    session = sessions[1]
    judged = judge_runs(NETWORK, session.runs)
    expected = naive(NETWORK, session)
    assert np.concatenate([j.first for j in judged]).tolist() == [f for f, _, _ in expected]
    assert np.concatenate([j.rank for j in judged]).tolist() == [r for _, r, _ in expected]
    logs = np.concatenate([j.log_likelihood for j in judged])
    assert logs == pytest.approx([each for _, _, each in expected], abs=1e-9)
    (again,) = judge_all([NETWORK], session.runs)
    assert np.array_equal(np.concatenate([j.rank for j in again]), [r for _, r, _ in expected])


@pytest.mark.parametrize("name", ["stuck_longest", "lowest_health"])
def test_a_scorer_that_remembers_sees_each_run_from_its_start(
    sessions: list[ChoiceSession], name: str
) -> None:
    """Runs laid end to end give the scores that each gives by itself."""
    task = sessions[0].task
    module = load_member("study.scorers", "scorer", name)
    scorer = module.load(module.fit({}, task, {}, 0).weights, task)
    runs = [run for session in sessions[:3] for run in session.runs]
    together = run_scores(scorer, runs)
    for run, scores in zip(runs, together, strict=True):
        alone = module.load(module.fit({}, task, {}, 0).weights, task)
        every = [alone.scores(states) for states in run.states]
        assert np.array_equal(scores, np.array(every)[run.rows])


@st.composite
def made_choices(
    draw: st.DrawFn,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.int64]]:
    """Scores without ties, who was offered, and who was chosen."""
    rows, robots = draw(st.integers(1, 6)), draw(st.integers(2, 7))
    random = np.random.default_rng(draw(st.integers(0, 2**32)))
    scores = random.permuted(np.arange(rows * robots) / 3.0).reshape(rows, robots)
    offered = random.random((rows, robots)) < 0.6
    chosen = random.integers(0, robots, rows)
    offered[np.arange(rows), chosen] = True
    return scores, offered, chosen


@given(made_choices(), st.randoms(use_true_random=False), st.floats(-50, 50))
@settings(max_examples=80, deadline=None)
def test_judging_hangs_on_neither_labels_nor_order_nor_level(
    made: tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.int64]],
    random: object,
    level: float,
) -> None:
    """Robots called otherwise, choices in another order, a constant added: nothing else changes."""
    scores, offered, chosen = made
    names = np.random.default_rng(len(scores)).permutation(scores.shape[1])
    rows = list(range(len(scores)))
    random.shuffle(rows)  # type: ignore[attr-defined]
    before = judge(scores, offered, chosen)
    after = judge(
        scores[rows][:, names] + level, offered[rows][:, names], np.argsort(names)[chosen[rows]]
    )
    assert np.array_equal(names[after.first], before.first[rows])
    assert np.array_equal(after.rank, before.rank[rows])
    assert after.log_likelihood == pytest.approx(before.log_likelihood[rows], abs=1e-9)


def test_scorers_come_by_name_and_from_files(
    sessions: list[ChoiceSession], choosing_files: list[Path], tmp_path: Path
) -> None:
    """Own, recorded name, control, another's recording and weights of one's own."""
    weights = tmp_path / "mine.safetensors"
    weights.write_bytes(known_scorer(3).to_bytes())
    notes: list[str] = []
    other = f"fourth={choosing_files[3]}"
    asked = asked_scorers(
        ["own", "luce", "lowest_health", other, str(weights)], sessions, 0, notes.append
    )
    assert not notes
    origins = {each.name: (each.origin, each.fitted_to, each.log_odds) for each in asked[1]}
    assert origins == {
        "own": ("recorded", "P02", True),
        "luce": ("recorded", "P02", True),
        "lowest_health": ("control", "", False),
        "fourth": ("file", "P04", True),
        "mine": ("file", "", True),
    }
    states = navigation.spread_states({}, np.random.default_rng(0), 50)
    fourth, mine = asked[1][3].scorer.scores(states), asked[1][4].scorer.scores(states)
    assert np.array_equal(fourth, mine)
    assert np.array_equal(fourth, known_scorer(3).scores(states))


def test_a_scorer_fitted_to_the_choices_has_seen_them(
    sessions: list[ChoiceSession], choosing_files: list[Path]
) -> None:
    """Choices before the fit count as seen by the own scorer and nobody else's."""
    tables = ask(sessions[:2], ["own", f"second={choosing_files[1]}"]).tables
    trials = tables["trials"]
    seen = {
        (who, scorer, phase == 2): value
        for who, scorer, phase, value in zip(
            trials["participant"], trials["scorer"], trials["phase"], trials["seen"], strict=True
        )
    }
    assert {key for key, value in seen.items() if value} == {
        ("P01", "own", True), ("P02", "own", True), ("P02", "second", True)
    }  # fmt: skip
    assert all(
        trials["fitted"][at] == (trials["phase"][at] == 2) for at in range(len(trials["phase"]))
    )


@pytest.mark.parametrize(
    ("given_scorer", "message"),
    [
        ("best", "unknown scorer"),
        ("nowhere.mcap", "no file"),
        ("=", "--scorer"),
        ("own=", "--scorer"),
    ],
)
def test_what_names_no_scorer_is_said_in_words(
    sessions: list[ChoiceSession], given_scorer: str, message: str
) -> None:
    """An unknown name or file is the user's to mend."""
    with pytest.raises(StudyError, match=message):
        asked_scorers([given_scorer], sessions, 0, lambda _: None)


def test_weights_of_another_task_are_refused(sessions: list[ChoiceSession], tmp_path: Path) -> None:
    """A network over other numbers, and a file that is none."""
    short = known_scorer(0)
    weights = short.tensors()
    weights["layer0.weight"] = weights["layer0.weight"][:, :2]
    (tmp_path / "short.safetensors").write_bytes(safetensors.numpy.save(weights))
    (tmp_path / "none.safetensors").write_bytes(b"\x00" * 40)
    for name in ("short", "none"):
        with pytest.raises(StudyError, match="no scorer of the task navigation"):
            asked_scorers([str(tmp_path / f"{name}.safetensors")], sessions, 0, lambda _: None)


def test_two_scorers_of_one_name_are_refused(
    sessions: list[ChoiceSession], choosing_files: list[Path], tmp_path: Path
) -> None:
    """The second would hide the first."""
    copy = tmp_path / choosing_files[0].name
    shutil.copy(choosing_files[1], copy)
    with pytest.raises(StudyError, match="two scorers are called"):
        asked_scorers([str(choosing_files[0]), str(copy)], sessions, 0, lambda _: None)


def test_parts_hold_out_every_trial_once() -> None:
    """Disjoint, and together all."""
    parts = parts_of_trials(np.array([7, 7, 3, 9, 12, 3], np.int32), 3)
    assert sorted(trial for part in parts for trial in part) == [3, 7, 9, 12]
    assert len(parts) == 3
    assert len(parts_of_trials(np.array([1, 1], np.int32), 5)) == 1


def test_cross_validation_asks_scorers_about_trials_they_never_saw(
    sessions: list[ChoiceSession],
) -> None:
    """Refitted scorers beat chance on held-out trials, and every choice is asked about once."""
    found = ask(sessions[:2], ["own"], parts=3)
    trials = found.tables["trials"]
    rows = [at for at, name in enumerate(trials["scorer"]) if name == "own, cross-validated"]
    assert {trials["phase"][at] for at in rows} == {2}
    assert not any(trials["seen"][at] for at in rows)
    assert sum(trials["choices"][at] for at in rows) == 2 * 3 * 40
    gain = np.mean([trials["log_likelihood"][a] - trials["chance_log_likelihood"][a] for a in rows])
    assert gain > 0.0
    origins = found.tables["scorers"]["origin"]
    assert origins.count("cross_validated") == 6


def test_choices_are_those_that_the_session_fitted(tmp_path: Path) -> None:
    """The data gathered from a simulated session have the hash of its own fit request."""
    (made,) = simulate_study(str(find_protocol("smoke")), 1, 11, tmp_path, 1, "planner")
    (session,) = open_sessions([made.path])
    fit = own_fit(session)
    assert fit is not None
    assert fit.artefact_id == "scorer:luce"
    assert arrays_sha256(training_choices(session).arrays()) == fit.data_sha256
    found = ask([session], ["own", "classifier", "novelty", "random"])
    assert not found.notes
    origins = dict(
        zip(found.tables["scorers"]["scorer"], found.tables["scorers"]["origin"], strict=True)
    )
    assert origins == {
        "own": "recorded", "classifier": "recorded", "novelty": "fitted", "random": "control"
    }  # fmt: skip


def test_where_they_part_is_told_of_the_same_choices(sessions: list[ChoiceSession]) -> None:
    """Every scorer's bins add up to the choices made after the fits; without a fit, to all."""
    found = ask(sessions[:1], ["own", "lowest_health"]).tables
    for table, bins in (("times", 1), ("states", 4)):
        for name in ("own", "lowest_health"):
            rows = [at for at, who in enumerate(found[table]["scorer"]) if who == name]
            assert sum(found[table]["choices"][at] for at in rows) == bins * 4 * 40
    bare = dataclasses.replace(sessions[0], fitted_ns=10**18)
    times = ask([bare], ["lowest_health"]).tables["times"]
    assert sum(times["choices"]) == (3 + 4) * 40
    low, high = found["states"]["low"], found["states"]["high"]
    assert all(one < other for one, other in zip(low, high, strict=True))


def test_recordings_without_choices_are_refused(sessions: list[ChoiceSession]) -> None:
    """There is nothing to ask about."""
    one = sessions[0]
    empty = open_choices(one.opened, one.source, one.files, {})
    with pytest.raises(StudyError, match="no choice of an operator's own"):
        ask([empty], ["own"])


def test_a_recording_without_scorers_is_a_note(sessions: list[ChoiceSession]) -> None:
    """Others are asked all the same; all choices count as unseen."""
    bare = dataclasses.replace(sessions[0], fits=(), fitted_ns=-1)
    found = ask([bare], ["own", "lowest_health"])
    assert found.notes == ("P01: the recording holds no scorer fitted to their choices.",)
    assert set(found.tables["trials"]["scorer"]) == {"lowest_health"}
    assert not any(found.tables["trials"]["fitted"])
    assert read_session(Path(one_file(sessions[0]))).sha256 == sessions[0].files[0][1]


def one_file(session: ChoiceSession) -> str:
    """Return the path of a session's recording."""
    return str(session.source.parts[0].path)  # type: ignore[attr-defined]
