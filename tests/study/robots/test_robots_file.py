"""The list of robots: what is wrong with it is said in the words of whoever wrote it."""

from __future__ import annotations

from pathlib import Path

import pytest

from command_line import study
from extras import need
from robots_list import KEY, LIST, OTHER
from study.errors import StudyError
from study.robots.keys import make_keys, read_public
from study.robots.robots_file import read_robots_file
from twin_process import running_twin

need("zmq", "mujoco")


def listed(folder: Path, text: str) -> Path:
    """Write a list."""
    path = folder / "robots.toml"
    path.write_text(text)
    return path


def test_the_list_of_the_docs_is_read(tmp_path: Path) -> None:
    """Two robots, poses by motion capture."""
    given = read_robots_file(listed(tmp_path, LIST))
    assert [robot.name for robot in given.robots] == ["robot1", "robot2"]
    assert given.poses.kind == "natnet"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (KEY, "short", "robot1.public_key: no key; 40 characters"),
        (
            "tcp://192.168.1.22:5555",
            "192.168.1.22",
            'robot2.address: "192.168.1.22" given',
        ),
        ('"natnet"', '"natnett"', 'kind "natnett" given; allowed: "twin", "natnet"'),
        ('name = "robot2"', 'nmae = "robot2"', 'nmae: unknown key; did you mean "name"?'),
        ('name = "robot2"', 'name = "robot1"', "name robot1 is that of two robots"),
        ("192.168.1.22", "192.168.1.21", "tcp://192.168.1.21:5555 is that of two robots"),
        (OTHER, KEY, f"public_key {KEY} is that of two robots"),
        ("[11, 12]", "[11]", "one id for each robot"),
        ("[poses]", "[poses", "not TOML"),
    ],
)
def test_mistakes_are_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    """Each where it is, by the robot's name, with what is allowed."""
    assert old in LIST
    with pytest.raises(StudyError) as caught:
        read_robots_file(listed(tmp_path, LIST.replace(old, new)))
    assert said in str(caught.value)


def test_public_keys_are_no_operator_s_key(tmp_path: Path) -> None:
    """The wrong file is called that; it is not to be made private first."""
    make_keys(tmp_path / "keys", ["operator", "robot1"])
    text = LIST.replace("keys/operator.toml", "keys/public_keys.toml")
    done = study("robot-stop", listed(tmp_path, text))
    assert done.returncode == 2
    assert "not a private key file" in done.stderr
    assert "chmod" not in done.stderr


def test_a_list_of_real_robots_is_not_replaced_by_a_twin(tmp_path: Path) -> None:
    """A rehearsal must not cost the list that an emergency stop needs; a twin's own may go."""
    make_keys(tmp_path / "keys", ["operator", "motion_capture", "robot1"])
    path = listed(tmp_path, LIST)
    command = ("robot-twin", tmp_path / "keys", "--robots", "1", "--no-cameras", "--write", path)
    done = study(*command)
    assert done.returncode == 2
    assert "no twin wrote it" in done.stderr
    assert path.read_text() == LIST
    path.unlink()
    for _ in range(2):
        assert study(*command).returncode == 0
        assert read_robots_file(path).poses.kind == "twin"


def test_a_stop_that_nobody_answers_says_so(tmp_path: Path) -> None:
    """With another operator's key nothing is stopped: that is said, and what to do."""
    with running_twin(tmp_path / "twin", robots=1) as twin:
        make_keys(tmp_path / "others", ["operator"])
        text = twin.robots_file.read_text()
        ours = str(tmp_path / "twin" / "operator.toml")
        assert ours in text
        wrong = tmp_path / "wrong.toml"
        wrong.write_text(text.replace(ours, str(tmp_path / "others" / "operator.toml")))
        done = study("robot-stop", wrong)
        assert done.returncode == 2
        assert "not known to be stopped" in done.stderr
        assert "Switch them off" in done.stderr
        stopped = study("robot-stop", twin.robots_file)
        assert f"study robot-release {twin.robots_file}" in stopped.stdout.replace("\n", "")


def test_git_ignores_keys(tmp_path: Path) -> None:
    """Whatever repository the folder is in: nothing of it is added."""
    make_keys(tmp_path / "keys", ["operator"])
    assert (tmp_path / "keys" / ".gitignore").read_text() == "*\n"
    assert set(read_public(tmp_path / "keys" / "public_keys.toml")) == {"operator"}
