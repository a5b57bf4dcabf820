"""Five how-tos on adding something, each proved by running what its page says.

What a page calls a file of the program is put beside the program's own files for the test alone:
the family's folder gets a second place to be looked for.
"""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from analysis.recordings import load_recordings
from analysis.statistics.result import EffectResult, Refusal
from analysis.tables.study_tables import StudyTables
from protocols import variant
from study.commands.simulating import simulate_session, simulated_assignments
from study.events.events import FitApplied, TrialStarted
from study.families import known_members
from study.loading import LoadedProtocol, load_protocol
from study.recording.reader import read_recording
from study.verification import verify

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "docs" / "how-to"
FILE = re.compile(
    r"`(?P<name>[\w/.]+\.(?:py|toml))`:\n\n```(?:python|toml)\n(?P<text>.*?)^```", re.S | re.M
)
BLOCK = re.compile(r"^```(?P<language>\w+)\n(?P<text>.*?)^```", re.S | re.M)


def files(page: str) -> dict[str, str]:
    """Return the files that a page gives in full, by their names."""
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    return {found["name"]: found["text"] for found in FILE.finditer(text)}


def blocks(page: str, language: str) -> list[str]:
    """Return a page's blocks of a language, those of whole files included."""
    text = (PAGES / f"{page}.md").read_text(encoding="utf-8")
    return [b["text"] for b in BLOCK.finditer(text) if b["language"] == language]


@pytest.fixture
def add(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], str]]:
    """Put a page's files where the program looks for members, until the test is over."""
    added: list[str] = []

    def put(page: str) -> str:
        for name, text in files(page).items():
            _, family, file = name.split("/")
            package = importlib.import_module(f"study.{family}")
            folder = tmp_path / family
            folder.mkdir(exist_ok=True)
            (folder / file).write_text(text, encoding="utf-8")
            if str(folder) not in package.__path__:
                monkeypatch.setattr(package, "__path__", [*package.__path__, str(folder)])
            added.append(f"study.{family}.{file.removesuffix('.py')}")
            importlib.invalidate_caches()
            assert file.removesuffix(".py") in known_members(f"study.{family}")
        return str(tmp_path)

    yield put
    for module in added:
        sys.modules.pop(module, None)


def contract(family: str) -> list[Callable[..., None]]:
    """Return the tests that every member of a family must pass."""
    path = ROOT / "tests" / "contracts" / f"test_{family}.py"
    spec = importlib.util.spec_from_file_location(f"contract_of_{family}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    tests = [test for name, test in vars(module).items() if name.startswith("test_")]
    assert len(tests) >= 4
    return tests


def keep_contract(family: str, name: str, tmp_path: Path, *, besides: tuple[str, ...] = ()) -> int:
    """Run a family's contract on one member; return how many tests ran.

    Args:
        family: of which.
        name: of the member.
        tmp_path: for those that write.
        besides: tests that start a process of their own, which does not see the page's files.
    """
    ran = 0
    for test in contract(family):
        if test.__name__ in besides:
            continue
        given: dict[str, Any] = {"name": name, "tmp_path": tmp_path, "count": 12}
        wanted = inspect.signature(test).parameters
        try:
            test(**{key: value for key, value in given.items() if key in wanted})
            ran += 1
        except pytest.skip.Exception:
            continue
    return ran


def replaced(text: str, table: str, new: str) -> str:
    """Return a protocol with one table, and those within it, in place of what was there."""
    pattern = re.compile(
        rf"^\[{re.escape(table)}(\.\w+)*\]\n.*?(?=^\[(?!{re.escape(table)}\.)|\Z)", re.S | re.M
    )
    assert pattern.search(text), table
    found = pattern.sub("", text)
    return f"{found.rstrip()}\n\n{new}"


def simulated(path: Path, folder: Path) -> tuple[LoadedProtocol, Path]:
    """Run one simulated participant."""
    loaded = load_protocol(str(path))
    (assignment,) = simulated_assignments(loaded, 1, seed=5)
    return loaded, simulate_session(str(path), assignment, 5, folder)


def test_add_a_task(add: Callable[[str], str], tmp_path: Path) -> None:
    """The corridor keeps the contract, and a study with it runs, replays and repeats itself."""
    add("add-a-task")
    assert keep_contract("tasks", "corridor", tmp_path) >= 6
    path = variant(tmp_path)
    path.write_text(replaced(path.read_text(), "task", blocks("add-a-task", "toml")[0]))
    loaded, recording = simulated(path, tmp_path / "recordings")
    assert loaded.description.name == "corridor"
    assert loaded.description.scene.width == 12.0
    verdict = verify(recording, resimulate=True)
    assert verdict.matches, verdict.difference
    robots = StudyTables(load_recordings([recording])).frame("robots")
    driven = robots[robots["action_source"] == "operator"]
    # The simulated participant turns robots that show no heading: one key is enough here.
    assert set() < set(driven["action"]) <= {"go left", "go right"}
    assert robots["reward"].max() >= 0.9


def test_add_a_scorer_or_a_policy(add: Callable[[str], str], tmp_path: Path) -> None:
    """Both keep their contracts; in a study both are fitted, and the scorer decides."""
    page = "add-a-scorer-or-policy"
    add(page)
    elsewhere = ("test_acting_needs_no_torch", "test_scoring_needs_no_torch")
    assert keep_contract("policies", "most_often", tmp_path, besides=elsewhere) == 4
    assert keep_contract("scorers", "linear", tmp_path, besides=elsewhere) == 3
    assert not any("torch" in text for text in files(page).values())
    path = variant(tmp_path, ('scorer = "luce"', 'scorer = "linear"'))
    text = path.read_text()
    for table in ("policy", "scorers.luce", "scorers.classifier"):
        text = replaced(text, table, "")
    path.write_text(f"{text}\n{blocks(page, 'toml')[0]}")
    _, recording = simulated(path, tmp_path / "recordings")
    read = read_recording(recording)
    fits = {record.artefact_id for _, record in read.records("event/fit_applied")
            if isinstance(record, FitApplied)}  # fmt: skip
    used = {record.scorer_id for _, record in read.records("event/trial_started")
            if isinstance(record, TrialStarted)}  # fmt: skip
    assert any("linear" in name for name in fits)
    assert any("linear" in name for name in used)
    assert verify(recording).matches


def test_linear_scorer_finds_what_made_the_choices(add: Callable[[str], str]) -> None:
    """Choices of the robot with the least health give that field a weight below zero."""
    import numpy as np

    from study.families import load_member
    from study.tasks import navigation

    add("add-a-scorer-or-policy")
    module, description = load_member("study.scorers", "scorer", "linear"), navigation.describe({})
    random = np.random.default_rng(0)
    states = random.uniform((0, 0, -3, 0), (20, 15, 3, 100), (300, 4, 4)).astype(np.float32)
    choices = {
        "states": states,
        "available": np.ones((300, 4), bool),
        "chosen": states[..., 3].argmin(axis=1).astype(np.int32),
        "trials": np.arange(300) // 10,
    }
    fitted = module.fit(choices, description, {}, 0)
    assert fitted.metrics["top1"] > 0.9
    assert fitted.metrics["held_out_log_likelihood_per_choice"] > -0.7
    scores = module.load(fitted.weights, description).scores(states.reshape(-1, 4))
    assert np.corrcoef(scores, states[..., 3].ravel())[0, 1] < -0.9


def test_add_a_questionnaire(tmp_path: Path) -> None:
    """The page's file is asked where the page says, answered, and scored by the page's scale."""
    use, scale = (text for text in blocks("add-a-questionnaire", "toml")[1:])
    ((name, text),) = files("add-a-questionnaire").items()
    folder = tmp_path / "questionnaires"
    folder.mkdir()
    (folder / Path(name).name).write_text(f"{text}\n{scale}", encoding="utf-8")
    path = variant(tmp_path)
    path.write_text(f"{path.read_text()}\n{use}")
    _, recording = simulated(path, tmp_path / "recordings")
    tables = StudyTables(load_recordings([recording]))
    responses = tables.frame("responses")
    asked = responses[responses["questionnaire"] == "workload"]
    assert sorted(set(asked["item"])) == ["hurried", "mental", "relaxed"]
    assert set(asked["occasion"]) == {"before_reveal"}
    scores = tables.frame("scores")
    found = scores[scores["questionnaire"] == "workload"]
    assert len(found) == 2
    for _, row in found.iterrows():
        block = asked[asked["condition"] == row["condition"]].set_index("item")["answer"]
        # Relaxed is worded the other way: 1 stands for 7.
        felt = block["mental"] + block["hurried"] + 8 - block["relaxed"]
        assert row["score"] == pytest.approx(felt / 3)


@pytest.fixture(scope="module")
def study_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with four simulated participants where the pages look for recordings."""
    folder = tmp_path_factory.mktemp("own")
    path = str(variant(folder))
    for assignment in simulated_assignments(load_protocol(path), 4, seed=5):
        simulate_session(path, assignment, 5, folder / "recordings" / "demo")
    return folder


def run_page(page: str) -> dict[str, Any]:
    """Run a page's Python, block after block; return what it made."""
    names: dict[str, Any] = {}
    for block in blocks(page, "python"):
        exec(block, names)  # noqa: S102 - the page is ours
    return names


def test_add_a_statistic(
    study_folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The page's function gives numbers on recordings, and refuses in words."""
    monkeypatch.chdir(study_folder)
    names = run_page("add-a-statistic")
    printed = capsys.readouterr().out
    assert re.search(r"Hodges-Lehmann shift of team_reward: -?[\d.]+, p = ", printed)
    assert "Hodges-Lehmann shift of takeovers: " in printed
    shift = names["hodges_lehmann"]
    whole = shift(names["scored"], "team_reward", ("manual", "assisted"))
    assert isinstance(whole, EffectResult)
    assert whole.participants == ("S01", "S02", "S03", "S04")
    few = names["scored"][names["scored"]["participant"].isin(["S01", "S02"])]
    refused = shift(few, "team_reward", ("manual", "assisted"))
    assert isinstance(refused, Refusal)
    assert "2 have both conditions" in refused.reason


def test_add_a_figure(study_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The page's figure has a dot a participant and condition; its page needs nothing else."""
    monkeypatch.chdir(study_folder)
    names = run_page("add-a-figure")
    drawn = str(names["stays"](names["shown"], names["conditions"]).markup())
    pairs = names["shown"].groupby(["condition", "participant"]).ngroups
    assert drawn.count("<circle") == pairs > 4
    page = study_folder / "reports" / "stays.html"
    text = page.read_text(encoding="utf-8")
    assert drawn in text
    assert "interventions of 4 participants" in text
    assert not re.search(r"(?:src|href)=\"(?!data:|#)", text)
    assert page.stat().st_mode & 0o077 == 0
    # Every class that the figure uses is one of the report's style.
    style = text.partition("<style>")[2].partition("</style>")[0]
    for word in {word for group in re.findall(r'class="([^"]+)"', drawn) for word in group.split()}:
        assert f".{word}" in style, word
    empty = names["stays"](names["shown"].query("condition == 'nobody'"), ("manual",)).markup()
    assert ">none</text>" in str(empty)
