"""Pictures are compressed and unpacked at their size; what is no such picture is none."""

from __future__ import annotations

import random

import numpy as np
import numpy.typing as npt
import pygame
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from study.recording.pictures import MAX_BYTES, MAX_SIDE
from study.shell import jpeg
from study.shell.jpeg import from_jpeg, jpeg_size, to_jpeg


def smooth(width: int, height: int) -> npt.NDArray[np.uint8]:
    """Return a picture whose colours change slowly, uint8 [height, width, 3]."""
    across = np.linspace(0, 200, width)[None, :, None]
    down = np.linspace(0, 55, height)[:, None, None]
    colours = across + down + np.array([0, 20, 40])
    return np.asarray(colours % 256, np.uint8)


def frame_at(data: bytes) -> int:
    """Return where a picture's frame header begins."""
    return data.index(b"\xff\xc0")


def of_size(data: bytes, width: int, height: int) -> bytes:
    """Return a picture whose header states another size."""
    place = frame_at(data) + 5
    size = height.to_bytes(2, "big") + width.to_bytes(2, "big")
    return data[:place] + size + data[place + 4 :]


@settings(max_examples=40, deadline=None)
@given(st.integers(1, 90), st.integers(1, 90))
def test_every_size_comes_back(width: int, height: int) -> None:
    """Of any size, a picture comes back as large as it was, and nearly as it was."""
    before = np.full((height, width, 3), (40, 120, 200), np.uint8)
    data = to_jpeg(before)
    assert jpeg_size(data) == (width, height)
    after = from_jpeg(data, (width, height))
    assert after is not None
    assert (after.shape, after.dtype) == (before.shape, before.dtype)
    assert np.abs(after.astype(int) - before).max() <= 4


def test_colours_and_places_are_kept() -> None:
    """Neither axes nor colours are swapped."""
    before = smooth(160, 120)
    before[10:40, 100:150] = (250, 10, 10)
    after = from_jpeg(to_jpeg(before), (160, 120))
    assert after is not None
    assert np.abs(after.astype(int) - before).mean() < 5
    assert after[25, 125, 0] > 200
    assert after[25, 125, 2] < 60


def test_the_same_picture_has_the_same_bytes() -> None:
    """Nothing of the time or place goes into it."""
    assert to_jpeg(smooth(64, 48)) == to_jpeg(smooth(64, 48))


def test_too_large_ones_are_not_compressed() -> None:
    """What could not be read again is not written."""
    with pytest.raises(ValueError, match=f"at most {MAX_SIDE}"):
        to_jpeg(np.zeros((1, MAX_SIDE + 1, 3), np.uint8))


@pytest.mark.parametrize(
    ("width", "height"), [(65535, 65535), (MAX_SIDE + 1, 8), (64, 49), (0, 0), (48, 64)]
)
def test_the_size_is_looked_at_before_anything_is_unpacked(
    width: int, height: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A header of another size than the record's costs no memory at all."""

    def refuse(*_: object) -> None:
        raise AssertionError("it was unpacked")

    data = to_jpeg(smooth(64, 48))
    monkeypatch.setattr(pygame.image, "load", refuse)
    with pytest.raises(AssertionError, match="was unpacked"):
        from_jpeg(data, (64, 48))
    assert from_jpeg(of_size(data, width, height), (64, 48)) is None
    if max(width, height) > MAX_SIDE:
        assert from_jpeg(of_size(data, width, height), (width, height)) is None


def test_other_kinds_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Progressive ones, with as many passes as they like, PNG, nothing, and much of it."""
    data = to_jpeg(smooth(64, 48))
    place = frame_at(data)
    progressive = data[: place + 1] + b"\xc2" + data[place + 2 :]
    twice = data[:place] + data[place : place + 19] + data[place:]
    for other in (progressive, twice, b"", b"\x89PNG\r\n\x1a\n" + data, data[: place + 6]):
        assert jpeg_size(other) is None
        assert from_jpeg(other, (64, 48)) is None
    assert from_jpeg(data + bytes(MAX_BYTES), (64, 48)) is None


def test_mutated_pictures_are_none_or_as_large_as_they_should_be() -> None:
    """Whatever a file says, the answer is a picture of the size asked for, or none."""
    data = to_jpeg(smooth(64, 48))
    chance, refused = random.Random(3), 0
    for _ in range(600):
        changed = bytearray(data[: chance.randrange(1, len(data) + 1)])
        for _ in range(chance.randrange(4)):
            # Headers are where it hurts.
            where = chance.randrange(min(len(changed), chance.choice([40, 700, len(data)])))
            changed[where] = chance.randrange(256)
        found = from_jpeg(bytes(changed), (64, 48))
        refused += found is None
        assert found is None or found.shape == (48, 64, 3)
    assert refused > 100


def test_what_is_loaded_is_measured_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that reads another size out of a picture than its header says is not believed."""
    monkeypatch.setattr(jpeg, "jpeg_size", lambda _: (64, 48))
    assert from_jpeg(to_jpeg(smooth(32, 48)), (64, 48)) is None
