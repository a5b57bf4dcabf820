"""Shell observations: what the shell noticed of itself. Never replayed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.fields import Record, boolean, double, doubles, fixed64, record, sfixed32, string


@record("shell", "clock")
class ClockPair(Record):
    """The monotonic and the wall clock, read together."""

    t_ns: int = fixed64(1, "monotonic time since the session opened", unit="ns")
    utc_ns: int = fixed64(2, "wall time since 1970, UTC", unit="ns")


@record("shell", "display")
class DisplayOpened(Record):
    """The window that the participant got."""

    t_ns: int = fixed64(1, "time of the observation", unit="ns")
    driver: str = string(2, 'SDL\'s video driver: "x11", "dummy", ...')
    width: int = sfixed32(3, "width of the window", unit="px")
    height: int = sfixed32(4, "height of the window", unit="px")
    refresh_hz: float = double(5, "rate at which pictures are drawn", unit="Hz")
    fullscreen: bool = boolean(6, "whether it fills the screen")


@record("shell", "frame_intervals")
class FrameIntervals(Record):
    """Intervals between pictures, in batches."""

    t_ns: int = fixed64(1, "time of the last picture", unit="ns")
    trial_id: int = sfixed32(2, "fleet run shown; -1 if none")
    intervals: npt.NDArray[np.float64] = doubles(
        3, "intervals between pictures", unit="s", shape="k"
    )


@record("shell", "writer_health")
class WriterHealth(Record):
    """How far the recording has reached the disk."""

    t_ns: int = fixed64(1, "time of the observation", unit="ns")
    durable_sequence: int = fixed64(2, "last record known to be on disk")
    sent_sequence: int = fixed64(3, "last record sent to the writer")


@record("shell", "note")
class Note(Record):
    """A remark of the shell, in words."""

    t_ns: int = fixed64(1, "time of the observation", unit="ns")
    text: str = string(2, "the remark")


@record("shell", "lsl_clock")
class LslClockPair(Record):
    """The session's clock and that of Lab Streaming Layer, read together."""

    t_ns: int = fixed64(1, "monotonic time since the session opened", unit="ns")
    lsl_seconds: float = double(2, "Lab Streaming Layer's clock on this computer", unit="s")
    uncertainty_ns: int = fixed64(3, "how far apart the two may have been read, at most", unit="ns")


ShellObservation = ClockPair | DisplayOpened | FrameIntervals | WriterHealth | Note | LslClockPair
