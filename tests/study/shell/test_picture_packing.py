"""What is packed of a fleet's pictures: those asked for that changed, within bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.events.shell import PicturesTaken
from study.recording.pictures import MAX_PIXELS, MAX_ROBOTS, MAX_SIDE, pictures_in
from study.shell import picture_packing
from study.shell.jpeg import from_jpeg
from study.shell.picture_packing import Packed, Packer


def fleet(*greys: int, size: tuple[int, int] = (32, 24)) -> npt.NDArray[np.uint8]:
    """Return a picture of one grey a robot, uint8 [n, height, width, 3]."""
    pictures = np.zeros((len(greys), size[1], size[0], 3), np.uint8)
    pictures += np.array(greys, np.uint8)[:, None, None, None]
    return pictures


def taken(packed: Packed, **changes: Any) -> PicturesTaken:
    """Return the record of what was packed, with some of it changed."""
    values: dict[str, Any] = {
        "t_ns": 1,
        "trial_id": 0,
        "timestep": 0,
        "robots": packed.robots,
        "width": packed.size[0],
        "height": packed.size[1],
        "encoding": "jpeg",
        "shown": packed.shown,
        "changed": packed.changed,
        "lengths": packed.lengths,
        "data": packed.data,
    }
    return PicturesTaken(**{**values, **changes})


def greys(packed: Packed) -> dict[int, int]:
    """Return the grey of each robot packed."""
    held = pictures_in(taken(packed))
    assert held is not None
    found = {}
    for robot, data in held.items():
        pixels = from_jpeg(data, packed.size)
        assert pixels is not None
        found[robot] = round(float(pixels.mean()))
    return found


def test_what_changed_is_packed() -> None:
    """First all, then those that are others than when they were last packed."""
    packer = Packer()
    packer.keep(1, fleet(10, 20, 30))
    first = packer.pack((0, 1, 2), anew=True)
    assert (first.request_id, first.robots, first.size, first.failure) == (1, 3, (32, 24), "")
    assert greys(first) == {0: 10, 1: 20, 2: 30}
    packer.keep(2, fleet(10, 90, 30))
    second = packer.pack((0, 1, 2), anew=False)
    assert second.shown.tolist() == [0, 1, 2]
    assert greys(second) == {1: 90}
    assert greys(packer.pack((0, 1, 2), anew=False)) == {}
    assert greys(packer.pack((0, 1, 2), anew=True)) == {0: 10, 1: 90, 2: 30}


def test_robots_out_of_sight_are_packed_when_they_come_into_it() -> None:
    """What a robot showed while nobody saw it is not packed; what it shows later is."""
    packer = Packer()
    packer.keep(1, fleet(10, 20))
    assert greys(packer.pack((0,), anew=True)) == {0: 10}
    packer.keep(2, fleet(50, 20))
    assert greys(packer.pack((1,), anew=False)) == {1: 20}
    packer.keep(3, fleet(50, 20))
    assert greys(packer.pack((0, 1), anew=False)) == {0: 50}


def test_of_several_pictures_the_last_is_packed() -> None:
    """A task with a picture for each tic has one in the recording: that at its end."""
    packer = Packer()
    packer.keep(1, np.stack([fleet(0, 0), fleet(5, 6), fleet(70, 80)], axis=1))
    assert greys(packer.pack((0, 1), anew=True)) == {0: 70, 1: 80}


def test_later_changes_of_an_array_are_noticed() -> None:
    """A task may hand out the same memory again."""
    packer, pictures = Packer(), fleet(10, 20)
    packer.keep(1, pictures)
    packer.pack((0, 1), anew=True)
    pictures[1] += 60
    packer.keep(2, pictures)
    assert greys(packer.pack((0, 1), anew=False)) == {1: 80}


def test_what_cannot_be_packed_is_said() -> None:
    """No pictures, robots that are not there, too many pixels or bytes: words, and no error."""
    packer = Packer()
    assert "took none" in packer.pack((0,), anew=True).failure
    packer.keep(1, fleet(10))
    assert packer.pack((0, 1), anew=True).failure
    packer.keep(1, np.zeros((1, 1, MAX_SIDE + 1, 3), np.uint8))
    assert f"at most {MAX_SIDE}" in packer.pack((0,), anew=True).failure
    wide = np.broadcast_to(np.uint8(0), (MAX_PIXELS // MAX_SIDE + 1, 1, MAX_SIDE, 3))
    packer.keep(1, wide)
    assert f"more than {MAX_PIXELS} pixels" in packer.pack((0,), anew=True).failure


def test_a_record_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    """A record larger than any that is read is not made, and what it had counts as not packed."""
    packer = Packer()
    packer.keep(1, fleet(10, 20))
    with monkeypatch.context() as bound:
        bound.setattr(picture_packing, "MAX_DATA", 700)
        assert "more than 700 bytes" in packer.pack((0, 1), anew=True).failure
    assert greys(packer.pack((0, 1), anew=False)) == {0: 10, 1: 20}


def refused(**changes: Any) -> bool:
    """Say whether a record of two pictures is refused once something of it is changed."""
    packer = Packer()
    packer.keep(1, fleet(10, 20))
    packed = packer.pack((0, 1), anew=True)
    return pictures_in(taken(packed, **changes)) is None


def test_absurd_records_are_refused() -> None:
    """Nothing is taken from a record whose numbers do not fit together, or are too large."""
    assert not refused()
    sizes = [(0, 24), (32, -1), (MAX_SIDE + 1, 1), (2**31 - 1, 2**31 - 1)]
    assert all(refused(width=width, height=height) for width, height in sizes)
    assert all(refused(robots=many) for many in (0, 1, -1, MAX_ROBOTS + 1, 2**31 - 1))
    assert refused(robots=MAX_ROBOTS, width=MAX_SIDE, height=MAX_SIDE)
    assert refused(encoding="png")
    assert all(refused(shown=np.array(shown, np.int32)) for shown in ([0], [0, 1, 2], [-1, 0, 1]))
    for robots in ([1, 0], [0, 0], [-1, 1], [0, 2], [0], [0, 1, 2]):
        assert refused(changed=np.array(robots, np.int32))
    for lengths in ([1, 1], [0, 5], [-1, 3], [2**31 - 1, 2**31 - 1], []):
        assert refused(lengths=np.array(lengths, np.int32))
    assert refused(data=b"")


@settings(max_examples=200, deadline=None)
@given(
    st.integers(-5, 2000),
    st.tuples(st.integers(-5, 5000), st.integers(-5, 5000)),
    st.lists(st.integers(-(2**31), 2**31 - 1) | st.integers(0, 5), max_size=5),
    st.lists(st.integers(-(2**31), 2**31 - 1) | st.integers(0, 9), max_size=5),
    st.binary(max_size=40),
)
def test_any_record_is_taken_apart_within_its_bounds(
    robots: int, size: tuple[int, int], changed: list[int], lengths: list[int], data: bytes
) -> None:
    """Whatever it says, what comes out are pieces of its own data, a robot each."""
    record = taken(
        Packed(1, robots, size, data=data),
        shown=np.array(changed, np.int32),
        changed=np.array(changed, np.int32),
        lengths=np.array(lengths, np.int32),
    )
    found = pictures_in(record)
    if found is not None:
        assert all(0 <= robot < robots for robot in found)
        assert b"".join(found.values()) == data
        assert robots * size[0] * size[1] <= MAX_PIXELS
