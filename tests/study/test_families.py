"""Members of a family are its files, and nothing else can be loaded as one."""

from __future__ import annotations

from pathlib import Path

import pytest

import study
import study.scorers
from protocols import variant
from study.errors import StudyError, UnknownNameError
from study.families import known_members, load_member
from study.loading import load_protocol

FAMILIES = {"study.tasks": "task", "study.policies": "policy", "study.scorers": "scorer"}


@pytest.mark.parametrize("package", FAMILIES)
def test_members_are_the_files(package: str) -> None:
    """Every public file but the contract is a member, and can be loaded."""
    folder = Path(study.__file__ or "").parent / package.split(".")[1]
    stems = {path.stem for path in folder.glob("*.py")} - {"base"}
    assert known_members(package) == sorted(stem for stem in stems if stem[0] != "_")
    for name in known_members(package):
        assert load_member(package, FAMILIES[package], name).__name__ == f"{package}.{name}"


def test_a_file_that_stands_for_many_is_asked_for_one() -> None:
    """What follows a colon is the file's business; files that stand for one know no colon."""
    with pytest.raises(UnknownNameError):
        load_member("study.tasks", "task", "navigation:three_rooms")
    with pytest.raises(UnknownNameError):
        load_member("study.tasks", "task", "gym:CartPole-v1")


@pytest.mark.parametrize(
    "name", ["base", "__init__", "_network", "", "os", "..errors", "a/b", "Luce"]
)
def test_other_names_are_refused_with_those_there_are(name: str) -> None:
    """No path, no private file and no module from elsewhere can be named."""
    with pytest.raises(UnknownNameError) as caught:
        load_member("study.scorers", "scorer", name)
    assert "classifier, lowest_health, luce" in str(caught.value)


@pytest.mark.parametrize(
    ("text", "said"),
    [("def fit(:\n", "SyntaxError"), ("import nowhere_at_all\n", "ModuleNotFoundError")],
)
def test_a_file_that_cannot_be_imported_is_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, said: str
) -> None:
    """Whatever is wrong with somebody's own scorer, it is named with its file."""
    (tmp_path / "my_broken.py").write_text(text)
    monkeypatch.setattr(study.scorers, "__path__", [*study.scorers.__path__, str(tmp_path)])
    with pytest.raises(StudyError, match=rf'"my_broken" cannot be imported: {said}') as caught:
        load_member("study.scorers", "scorer", "my_broken")
    assert "study/scorers/my_broken.py" in caught.value.hint


def test_a_file_without_parameters_is_one_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A protocol that names it is refused, with what it lacks."""
    (tmp_path / "my_hollow.py").write_text('"""Nothing."""\n')
    monkeypatch.setattr(study.scorers, "__path__", [*study.scorers.__path__, str(tmp_path)])
    path = variant(tmp_path, ('name = "luce"', 'name = "my_hollow"'))
    with pytest.raises(StudyError, match='"my_hollow" has no class Parameters'):
        load_protocol(str(path))
