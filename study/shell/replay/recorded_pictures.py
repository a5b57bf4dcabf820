"""The pictures that a recording holds, found again by the time of what they came with.

Where each is, is read once, when the recording is opened; the pictures themselves are read as they
are shown: those of an hour are more than fits into memory.
"""

from __future__ import annotations

import bisect
from array import array
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from study.errors import RecordingError
from study.events.shell import PicturesTaken
from study.recording.parts import SessionRecording
from study.recording.pictures import pictures_in
from study.recording.reader import RawRecord
from study.recording.wire import decode
from study.shell.jpeg import from_jpeg

Picture = npt.NDArray[np.uint8]


class RecordedPictures:
    """Finds pictures of a session's robots.

    Args:
        recording: with its first part.

    Raises:
        RecordingError: the recording cannot be read.
    """

    def __init__(self, recording: SessionRecording) -> None:
        self._recording = recording
        # Of each record that can be used: session time, sequence number and log time.
        self._t_ns, self._sequences, self._log_times = array("Q"), array("Q"), array("Q")
        # Of each robot, numbers of the records that hold a picture of it, ascending.
        self._holding: dict[int, array[int]] = {}
        # Numbers of the records that follow one that cannot be used.
        self._breaks = array("Q")
        self._unpacked: dict[int, tuple[int, Picture | None]] = {}
        for raw in _raw(recording):
            self._take(raw)

    @property
    def moments(self) -> int:
        """At how many moments there are pictures."""
        return len(self._t_ns)

    def at(self, t_ns: int, robots: int) -> list[Picture | None] | None:
        """Return the newest picture of each robot.

        Args:
            t_ns: session time of the fleet's answer that is shown.
            robots: how many there are, n.

        Returns:
            uint8 [height, width, 3] a robot, None for one that was not shown or whose picture
            cannot be unpacked. None where the pictures of that answer were not recorded: older ones
            would be wrong.

        Raises:
            RecordingError: the recording cannot be read any more.
        """
        number = bisect.bisect_right(self._t_ns, t_ns) - 1
        if number < 0 or self._t_ns[number] != t_ns:
            return None
        shown = self._open(number)
        if shown is None or shown[0].robots != robots:
            return None
        holding = [-1] * robots
        for robot in shown[0].shown.tolist():
            holding[robot] = self._newest(robot, number)
        self._unpacked = {
            robot: kept
            for robot, kept in self._unpacked.items()
            if robot < robots and kept[0] == holding[robot]
        }
        size = shown[0].width, shown[0].height
        for each in sorted(set(holding) - {-1}):
            wanted = [r for r in range(robots) if holding[r] == each and r not in self._unpacked]
            if not wanted:
                continue
            # One record at a time: together they may be large.
            opened = shown if each == number else self._open(each)
            for robot in wanted:
                data = b"" if opened is None else opened[1].get(robot, b"")
                self._unpacked[robot] = each, from_jpeg(data, size)
        return [self._unpacked.get(robot, (-1, None))[1] for robot in range(robots)]

    def _take(self, raw: RawRecord) -> None:
        """Take note of where a record is, and of whom it holds pictures."""
        opened, number = _opened(raw), len(self._t_ns)
        if opened is None or (number and opened[0].t_ns < self._t_ns[-1]):
            self._breaks.append(number)
            return
        self._t_ns.append(opened[0].t_ns)
        self._sequences.append(raw.sequence)
        self._log_times.append(raw.log_time_ns)
        for robot in opened[1]:
            self._holding.setdefault(robot, array("Q")).append(number)

    def _newest(self, robot: int, number: int) -> int:
        """Return the last record up to a number that holds a robot's picture; -1 if unknown."""
        holding = self._holding.get(robot, array("Q"))
        place = bisect.bisect_right(holding, number) - 1
        if place < 0:
            return -1
        # What lies before a record that cannot be used may have been replaced by it.
        broken = bisect.bisect_right(self._breaks, number) - 1
        unknown = broken >= 0 and holding[place] < self._breaks[broken]
        return -1 if unknown else holding[place]

    def _open(self, number: int) -> tuple[PicturesTaken, dict[int, bytes]] | None:
        """Read a record again; None if it is not there any more."""
        raw = self._recording.find(
            PicturesTaken.topic, self._sequences[number], self._log_times[number]
        )
        return None if raw is None else _opened(raw)


def _raw(recording: SessionRecording) -> Iterator[RawRecord]:
    """Yield the records of pictures, up to the first record that is lost: a replay ends there."""
    if not any(part.counts.get(PicturesTaken.topic) for part in recording.parts):
        return
    before = recording.losses[0].first if recording.losses else None
    for raw in recording.raw("shell"):
        if before is not None and raw.sequence >= before:
            return
        if raw.topic == PicturesTaken.topic:
            yield raw


def _opened(raw: RawRecord) -> tuple[PicturesTaken, dict[int, bytes]] | None:
    """Return a record and its compressed pictures by robot; None if it holds none as it should."""
    try:
        taken = decode(raw.topic, raw.data)
    except RecordingError:
        return None
    if not isinstance(taken, PicturesTaken):
        return None
    held = pictures_in(taken)
    return None if held is None else (taken, held)
