"""Pictures go from the fleet's process to the window's through shared memory."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from extras import need
from study.session.effects import StartFleet
from study.shell import fleet as fleets
from study.shell.fleet_host import FleetAnswer, FleetHost
from study.shell.shared_pictures import Laid, PictureShelf, PictureTaker, can_share

pytestmark = pytest.mark.skipif(not can_share(), reason="Linux has such memory")
TASK, PARAMETERS = "gymnasium:FrozenLake-v1", {"options": {"is_slippery": False}}


@pytest.fixture
def ends() -> Iterator[tuple[PictureShelf, PictureTaker]]:
    """Both ends, in one process."""
    with closing(PictureShelf()) as shelf:
        yield shelf, PictureTaker()


@settings(deadline=None)
@given(
    shapes=st.lists(
        st.tuples(st.integers(0, 5), st.integers(1, 40), st.integers(1, 40), st.just(3)),
        min_size=1, max_size=8,
    )
)  # fmt: skip
def test_what_is_laid_is_taken(shapes: list[tuple[int, ...]]) -> None:
    """Of whatever sizes they come, one after the other; what was taken before stays as it was."""
    random = np.random.default_rng(1)
    taker = PictureTaker()
    before = []
    with closing(PictureShelf()) as shelf:
        for shape in shapes:
            pictures = random.integers(0, 256, shape, dtype=np.uint8)
            before.append((pictures, taker.take(shelf.lay(pictures))))
    for pictures, taken in before:
        np.testing.assert_array_equal(pictures, taken)
        assert pictures.shape == taken.shape


def test_nothing_of_it_has_a_name(ends: tuple[PictureShelf, PictureTaker]) -> None:
    """Whatever ends a process, nothing is left behind."""
    shelf, _ = ends
    laid = shelf.lay(np.zeros((2, 8, 8, 3), np.uint8))
    assert "(deleted)" in str(Path(laid.path).readlink())


def answered(fleet: fleets.Fleet, start: StartFleet) -> FleetAnswer:
    """Ask and wait."""
    fleet.request(start, pictures=True)
    until = time.monotonic() + 60
    while time.monotonic() < until:
        answer = fleet.poll(1.0)
        if isinstance(answer, FleetAnswer):
            return answer
    raise TimeoutError


def start_of(robots: int) -> StartFleet:
    """Return the start of a fleet."""
    return StartFleet(
        robots, 0, robots, np.arange(robots, dtype=np.uint64), "uniform_random", 1, ""
    )


@pytest.mark.parametrize("shared", [True, False])
def test_a_fleet_s_process_hands_over_what_it_took(
    shared: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of one robot, of more, and of one again: the same pictures as without another process."""
    need("gymnasium")
    if not shared:
        monkeypatch.setattr(fleets, "can_share", lambda: False)
    host = FleetHost(TASK, PARAMETERS)
    with closing(host), closing(fleets.ProcessFleet(TASK, PARAMETERS)) as fleet:
        for robots in (1, 5, 2):
            wanted = host.answer(start_of(robots), pictures=True).pictures
            assert wanted is not None
            given_pictures = answered(fleet, start_of(robots)).pictures
            assert given_pictures is not None
            np.testing.assert_array_equal(given_pictures, wanted)


def test_where_memory_cannot_be_opened_pictures_come_by_the_pipe(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One answer is without pictures; the session goes on, and the next one has some."""
    need("gymnasium")

    def refuse(taker: PictureTaker, laid: Laid) -> None:
        raise PermissionError

    monkeypatch.setattr(PictureTaker, "take", refuse)
    with closing(fleets.ProcessFleet(TASK, PARAMETERS)) as fleet:
        assert answered(fleet, start_of(2)).pictures is None
        assert answered(fleet, start_of(3)).pictures is not None
