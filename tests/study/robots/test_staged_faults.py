"""Lines that make faults of a twin's robots."""

from __future__ import annotations

import pytest

from study.errors import StudyError

pytest.importorskip("mujoco", reason="the extra jetbot is not installed")

from study.arena.course import TWO_BUCKETS
from study.arena.physics import ArenaPhysics
from study.robots.staged_faults import StagedFaults


@pytest.fixture
def faults() -> StagedFaults:
    """Three robots of which nothing is wrong."""
    return StagedFaults(ArenaPhysics(TWO_BUCKETS, 3, motor_lag_s=0.06), 3)


def test_robots_are_numbered_as_on_the_screen(faults: StagedFaults) -> None:
    """The first robot is 1, the last of three is 3; what was switched on can be switched off."""
    for line in ("pose_lost 1 on", "camera_frozen 3 on", "camera_dead 2 on", "battery 3 0.05"):
        assert faults.command(line)
    assert (faults.unseen, faults.frozen, faults.dead) == ({0}, {2}, {1})
    assert faults.batteries == [1.0, 1.0, 0.05]
    for line in ("pose_lost 1 off", "camera_frozen 3 off", "camera_dead 2 off", "battery 3 1", ""):
        assert faults.command(line)
    assert (faults.unseen, faults.frozen, faults.dead) == (set(), set(), set())
    assert faults.batteries == [1.0] * 3


def test_a_robot_is_put_elsewhere(faults: StagedFaults) -> None:
    """Where and how it then stands is where it was put."""
    faults.command("put 2 0.5 0.25 1.5")
    assert faults._physics.poses()[1] == pytest.approx((0.5, 0.25, 1.5))


def test_quit_ends_it(faults: StagedFaults) -> None:
    """It is the only line after which no other is read."""
    assert not faults.command("quit\n")


@pytest.mark.parametrize(
    "line",
    ["pose_lost 0 on", "pose_lost 4 on", "pose_lost two on", "pose_lost 1 maybe", "pose_lost 1",
     "battery 1 nan", "battery 1 full", "put 1 inf 0 0", "put 1 0 0", "dance 1"],
)  # fmt: skip
def test_a_line_that_is_none_is_told_with_those_that_are(faults: StagedFaults, line: str) -> None:
    """The message names what was said, all that may be, and the robots that there are."""
    before = faults._physics.poses().tolist()
    with pytest.raises(StudyError) as caught:
        faults.command(line)
    assert f'"{line}"' in str(caught.value)
    assert "pose_lost ROBOT on|off" in caught.value.hint
    assert "ROBOT is 1 to 3" in caught.value.hint
    assert faults._physics.poses().tolist() == before
    assert not faults.unseen
    assert faults.batteries == [1.0] * 3
