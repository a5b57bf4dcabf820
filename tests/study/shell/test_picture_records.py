"""Pictures on their way to the recording: left out while the disk is behind, never in the way."""

from __future__ import annotations

import numpy as np
import pytest

from study.events.shell import Note, PicturesTaken
from study.session.effects import StartFleet, StepFleet
from study.shell.fleet_host import FleetAnswer, FleetNews
from study.shell.picture_packing import Packed, Packer
from study.shell.picture_records import PictureRecords

ROBOTS = 2


class PaintedFleet:
    """A fleet whose robots show a grey each; it only keeps and packs pictures."""

    def __init__(self) -> None:
        self.packer = Packer()
        self.packed: list[Packed] = []
        self.taken = True

    def show(self, request_id: int, *greys: int) -> None:
        """Answer a request with pictures."""
        pictures = np.zeros((len(greys), 8, 8, 3), np.uint8)
        pictures += np.array(greys, np.uint8)[:, None, None, None]
        self.packer.keep(request_id, pictures if self.taken else None)

    def pack(self, robots: tuple[int, ...], *, anew: bool) -> None:
        """Pack at once."""
        self.packed.append(self.packer.pack(robots, anew=anew))

    def request(self, *_: object, **__: object) -> None:
        """Nothing is stepped."""

    def add_artefact(self, *_: str | bytes) -> None:
        """Nothing is fitted."""

    def poll(self, seconds: float = 0.0) -> FleetAnswer | FleetNews | Packed | None:
        """Nothing is waited for."""
        return None

    def close(self) -> None:
        """Nothing is held."""


def start(request_id: int) -> StartFleet:
    """Return a request to start the fleet."""
    seeds = np.arange(ROBOTS, dtype=np.uint64)
    return StartFleet(request_id, 0, ROBOTS, seeds, "uniform_random", 1, "")


def step(request_id: int) -> StepFleet:
    """Return a request to step the fleet."""
    none = np.zeros(ROBOTS, np.bool_)
    return StepFleet(request_id, np.zeros(ROBOTS, np.int32), ~none, none, np.zeros(ROBOTS, "u8"))


def answer(request_id: int) -> FleetAnswer:
    """Return an answer without pictures."""
    numbers = np.zeros(ROBOTS, np.float32)
    codes = np.zeros(ROBOTS, np.int32)
    return FleetAnswer(request_id, numbers[:, None], numbers, codes, codes, np.zeros(0))


class Disk:
    """Says whether there is room."""

    room = True

    def has_room(self) -> bool:
        """Return what was set."""
        return self.room


@pytest.fixture
def disk() -> Disk:
    """A disk that keeps up until it does not."""
    return Disk()


def record(
    records: PictureRecords, fleet: PaintedFleet, effect: StartFleet | StepFleet, *greys: int
) -> PicturesTaken | Note | None:
    """Go through one request; return what is to be recorded of it."""
    seen = records.asked(effect, seen=True)
    if seen:
        fleet.show(effect.request_id, *greys)
    records.answered(answer(effect.request_id), 10 * effect.request_id, 4, None, fleet)
    return records.packed(fleet.packed.pop(), 999) if fleet.packed else None


def test_each_answer_has_its_time(disk: Disk) -> None:
    """A record has the time of the answer, not that at which its pictures came."""
    records, fleet = PictureRecords(disk.has_room), PaintedFleet()
    first = record(records, fleet, start(1), 10, 20)
    second = record(records, fleet, step(2), 10, 90)
    assert isinstance(first, PicturesTaken)
    assert isinstance(second, PicturesTaken)
    assert (first.t_ns, first.trial_id, first.changed.tolist()) == (10, 4, [0, 1])
    assert (second.t_ns, second.shown.tolist(), second.changed.tolist()) == (20, [0, 1], [1])
    assert not records.awaited


def test_a_fleet_run_begins_with_all(disk: Disk) -> None:
    """No record leans on one of a fleet run before, even if its first pictures are left out."""
    records, fleet = PictureRecords(disk.has_room), PaintedFleet()
    assert record(records, fleet, start(1), 10, 20) is not None
    disk.room = False
    assert record(records, fleet, start(2), 10, 20) is None
    disk.room = True
    later = record(records, fleet, step(3), 10, 20)
    assert isinstance(later, PicturesTaken)
    assert later.changed.tolist() == [0, 1]


def test_a_disk_that_is_behind_is_asked_for_nothing(disk: Disk) -> None:
    """Pictures are left out meanwhile; what is the same as before the gap is not repeated."""
    records, fleet = PictureRecords(disk.has_room), PaintedFleet()
    assert record(records, fleet, start(1), 10, 20) is not None
    disk.room = False
    assert record(records, fleet, step(2), 30, 20) is None
    assert not fleet.packed
    assert not records.awaited
    disk.room = True
    later = record(records, fleet, step(3), 30, 20)
    assert isinstance(later, PicturesTaken)
    assert later.changed.tolist() == [0]


def test_what_nobody_sees_is_not_kept(disk: Disk) -> None:
    """While a screen asks to wait, nothing is packed."""
    records, fleet = PictureRecords(disk.has_room), PaintedFleet()
    assert not records.asked(start(1), seen=False)
    records.answered(answer(1), 10, 4, None, fleet)
    assert not fleet.packed


def test_an_answer_that_was_overtaken_has_none(disk: Disk) -> None:
    """If the session asks for more before its answer is looked at, the pictures are gone."""
    records, fleet = PictureRecords(disk.has_room), PaintedFleet()
    assert records.asked(step(1), seen=True)
    assert records.asked(start(2), seen=True)
    records.answered(answer(1), 10, 4, None, fleet)
    assert not fleet.packed
    assert not records.awaited


def test_a_failure_is_told_once(disk: Disk) -> None:
    """What keeps pictures off the recording is noted; the session goes on without them."""
    records, fleet = PictureRecords(disk.has_room), PaintedFleet()
    fleet.taken = False
    told = record(records, fleet, start(1), 10, 20)
    assert isinstance(told, Note)
    assert told.text == "no more pictures are recorded: the task took none"
    assert record(records, fleet, step(2), 10, 20) is None
    assert not records.awaited
