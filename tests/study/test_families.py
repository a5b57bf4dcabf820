"""Members of a family are its files, and nothing else can be loaded as one."""

from __future__ import annotations

from pathlib import Path

import pytest

import study
from study.errors import UnknownNameError
from study.families import known_members, load_member

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
