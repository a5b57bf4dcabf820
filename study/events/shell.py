"""Shell observations: what the shell noticed of itself. Never replayed."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.fields import (
    Record,
    blob,
    boolean,
    double,
    doubles,
    fixed64,
    ints,
    record,
    sfixed32,
    string,
)


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


@record("shell", "trial_timing")
class TrialTiming(Record):
    """How punctual one fleet run was, stated at its end.

    A key was pressed at most one poll gap before its time: this bounds a reaction time's error.
    Numbers without values to compute them from are NaN.
    """

    t_ns: int = fixed64(1, "time of the observation", unit="ns")
    trial_id: int = sfixed32(2, "fleet run")
    period: float = double(3, "between two pictures of the display", unit="s")
    frames: int = sfixed32(4, "intervals between pictures")
    late_frames: int = sfixed32(5, "those longer than 1.2 periods")
    frame_mean: float = double(6, "mean interval between pictures", unit="s")
    frame_sd: float = double(7, "standard deviation of the same", unit="s")
    frame_p99: float = double(8, "99th percentile of the same", unit="s")
    frame_max: float = double(9, "longest of the same", unit="s")
    timesteps: int = sfixed32(10, "intervals between timesteps, pauses left out")
    timestep_mean: float = double(11, "mean interval between timesteps", unit="s")
    timestep_sd: float = double(12, "standard deviation of the same", unit="s")
    timestep_p99: float = double(13, "99th percentile of the same", unit="s")
    timestep_max: float = double(14, "longest of the same", unit="s")
    polls: int = sfixed32(15, "intervals between readings of the keys")
    poll_gap_median: float = double(16, "median interval between readings of the keys", unit="s")
    poll_gap_p99: float = double(17, "99th percentile of the same", unit="s")
    poll_gap_max: float = double(18, "longest of the same", unit="s")


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


@record("shell", "pictures")
class PicturesTaken(Record):
    """The pictures of the robots on the screen, compressed; only where the protocol asks for them.

    A picture that did not change since it was last recorded in the same fleet run is not repeated.
    """

    t_ns: int = fixed64(1, "time of the input/fleet_observed that they came with", unit="ns")
    trial_id: int = sfixed32(2, "fleet run; -1 if none")
    timestep: int = sfixed32(3, "timestep shown with them; -1 if none")
    robots: int = sfixed32(4, "number of robots, n")
    width: int = sfixed32(5, "width of each picture", unit="px")
    height: int = sfixed32(6, "height of each picture", unit="px")
    encoding: str = string(7, '"jpeg"')
    shown: npt.NDArray[np.int32] = ints(8, "robots shown, from 0, ascending", shape="k")
    changed: npt.NDArray[np.int32] = ints(
        9, "those of them whose picture is in this record, ascending", shape="c"
    )
    lengths: npt.NDArray[np.int32] = ints(10, "lengths of these pictures", unit="bytes", shape="c")
    data: bytes = blob(11, "these pictures, one after another")


ShellObservation = (
    ClockPair
    | DisplayOpened
    | FrameIntervals
    | TrialTiming
    | WriterHealth
    | Note
    | LslClockPair
    | PicturesTaken
)
