"""Inputs: all that reaches the session from outside, stamped by the shell.

Replaying these, in their recorded order, gives the recorded events byte for byte.
All times are nanoseconds of a monotonic clock since the session opened.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.experimenter_records import ExperimenterCommanded
from study.events.fields import (
    Record,
    blob,
    boolean,
    double,
    doubles,
    fixed64,
    floats,
    ints,
    record,
    sfixed32,
    string,
    strings,
)


@record("input", "session_opened")
class SessionOpened(Record):
    """The first input: all that the session is made of."""

    t_ns: int = fixed64(1, "time since the session opened: 0", unit="ns")
    session_id: str = string(2, "random identifier of this session")
    participant: str = string(3, "pseudonymous id of the participant")
    seed: int = fixed64(4, "session seed; every random stream is keyed from it")
    order: tuple[str, ...] = strings(5, "names of phase three's conditions in the order run")
    protocol_toml: str = string(6, "the protocol file, in full")
    protocol_sha256: str = string(7, "SHA-256 of the protocol file's bytes, hexadecimal")
    task_json: str = string(8, "description of the task: fields, actions, rewards, scene, map grid")
    operator_kind: str = string(9, '"person" or "simulated"')
    operator_json: str = string(10, "parameters of a simulated operator, JSON object")
    versions_json: str = string(11, "versions of what ran: name to version, JSON object")
    started_utc: str = string(12, "wall time of opening, ISO 8601, UTC")
    planned_index: int = sfixed32(13, "place of the participant in the plan, from 0; -1 if unknown")
    questionnaires_json: str = string(
        14, "the questionnaires asked, in full: name to questionnaire"
    )
    rules: int = sfixed32(
        15, "version of the session's rules; 0 in recordings from before they had one"
    )
    consent_sha256: str = string(16, "SHA-256 of the text agreed to, hexadecimal; empty if none")
    consented_utc: str = string(17, "wall time of agreeing, ISO 8601, UTC; empty if none")


@record("input", "key_changed")
class KeyChanged(Record):
    """A key went down or up. Auto-repeat is not an input."""

    t_ns: int = fixed64(1, "when it was taken from the queue", unit="ns")
    key: str = string(2, 'name of the key: "up", "1", "tab", "return", ...')
    down: bool = boolean(3, "true when pressed, false when released")
    poll_gap_ns: int = fixed64(4, "time since the queue was last read: bounds the error", unit="ns")


@record("input", "pointer_pressed")
class PointerPressed(Record):
    """A mouse button went down on the screen shown."""

    t_ns: int = fixed64(1, "when it was taken from the queue", unit="ns")
    x: float = double(2, "place from the left", unit="logical px")
    y: float = double(3, "place from the top", unit="logical px")
    target: str = string(4, 'what it hit: "robot:3", "answer:q1:5", "confirm", or "" for nothing')
    poll_gap_ns: int = fixed64(5, "time since the queue was last read: bounds the error", unit="ns")


@record("input", "focus_changed")
class FocusChanged(Record):
    """The window lost or regained the keyboard."""

    t_ns: int = fixed64(1, "when it was noticed", unit="ns")
    focused: bool = boolean(2, "whether keys reach the window now")


@record("input", "text_typed")
class TextTyped(Record):
    """Characters were typed where the screen takes text."""

    t_ns: int = fixed64(1, "when they were taken from the queue", unit="ns")
    text: str = string(2, "the characters")


@record("input", "window_changed")
class WindowChanged(Record):
    """The window was resized, minimised or restored."""

    t_ns: int = fixed64(1, "when it was noticed", unit="ns")
    change: str = string(2, '"resized", "minimised" or "restored"')
    width: int = sfixed32(3, "width of the window then", unit="px")
    height: int = sfixed32(4, "height of the window then", unit="px")


@record("input", "quit_requested")
class QuitRequested(Record):
    """The window was closed, or the process was asked to stop."""

    t_ns: int = fixed64(1, "when it was noticed", unit="ns")
    reason: str = string(2, '"window closed", "SIGTERM", "SIGINT", ...')


@record("input", "timestep_due")
class TimestepDue(Record):
    """The clock says that the next timestep is due."""

    t_ns: int = fixed64(1, "the shell's time, not the deadline", unit="ns")
    late_ns: int = fixed64(2, "how long after its deadline", unit="ns")


@record("input", "fleet_observed")
class FleetObserved(Record):
    """What starting or stepping the fleet returned, and what policy and scorer say of it."""

    t_ns: int = fixed64(1, "when the answer was taken", unit="ns")
    request_id: int = sfixed32(2, "which StartFleet or StepFleet is answered")
    robots: int = sfixed32(3, "number of robots, n")
    states: npt.NDArray[np.float32] = floats(4, "states after the step", shape="n,d")
    rewards: npt.NDArray[np.float32] = floats(5, "rewards of the step", shape="n")
    outcomes: npt.NDArray[np.int32] = ints(6, "codes.Outcome after the step", shape="n")
    policy_actions: npt.NDArray[np.int32] = ints(
        7, "what the policy in force would do in these states", shape="n"
    )
    scores: npt.NDArray[np.float64] = doubles(
        8, "the scorer's value of taking control in these states; empty if none", shape="n or 0"
    )


@record("input", "robot_reported")
class RobotReported(Record):
    """A robot was stopped by what watches over it, or one reason for that is gone."""

    t_ns: int = fixed64(1, "when the report was taken", unit="ns")
    robot: int = sfixed32(2, "the robot, from 0")
    stopped: bool = boolean(3, "false if the reason is gone")
    reason: str = string(4, '"link_lost", "pose_lost", "camera_stale", "emergency", ...')
    text: str = string(5, "what happened, in words")
    age_ns: int = fixed64(6, "how long before it had happened", unit="ns")


@record("input", "fit_completed")
class FitCompleted(Record):
    """A fit is done; it takes effect where the session waits for it."""

    t_ns: int = fixed64(1, "when the answer was taken", unit="ns")
    request_id: int = sfixed32(2, "which RequestFit is answered")
    artefact_id: str = string(3, 'name of what was fitted: "policy:2", "scorer:luce"')
    weights: bytes = blob(4, "safetensors: everything needed to use it")
    seconds: float = double(5, "time that the fit took", unit="s")
    metric_names: tuple[str, ...] = strings(6, "names of the measures of fit")
    metric_values: npt.NDArray[np.float64] = doubles(7, "their values", shape="metrics")
    score_grid: npt.NDArray[np.float64] = doubles(
        8,
        "scorer's value over the task's map grid; empty for policies",
        shape="healths,headings,rows,columns or 0",
    )
    preparation: bytes = blob(
        9, "safetensors: what a later fit can go on from; empty if there is nothing"
    )


@record("input", "fit_failed")
class FitFailed(Record):
    """A fit could not be done, with the reason in words."""

    t_ns: int = fixed64(1, "when the answer was taken", unit="ns")
    request_id: int = sfixed32(2, "which RequestFit is answered")
    reason: str = string(3, "what went wrong")


@record("input", "fit_timed_out")
class FitTimedOut(Record):
    """A fit ran over its budget."""

    t_ns: int = fixed64(1, "when it was given up", unit="ns")
    request_id: int = sfixed32(2, "which RequestFit is answered")
    budget_seconds: float = double(3, "the budget", unit="s")


@record("input", "recording_interrupted")
class RecordingInterrupted(Record):
    """The writer of the recording failed; what it had not acknowledged is kept and sent again."""

    t_ns: int = fixed64(1, "when it was noticed", unit="ns")
    reason: str = string(2, "what went wrong, in words")


@record("input", "recording_restored")
class RecordingRestored(Record):
    """A new part of the recording is under way, with all that was not acknowledged."""

    t_ns: int = fixed64(1, "when the new part was under way", unit="ns")
    part: int = sfixed32(2, "number of the new part; the first file is part 1")


@record("input", "session_resumed")
class SessionResumed(Record):
    """The session goes on in a new part, from a boundary, after a crash."""

    t_ns: int = fixed64(1, "when it went on, on the clock of the first part", unit="ns")
    part: int = sfixed32(2, "number of the new part")
    after_sequence: int = fixed64(
        3, "sequence number of the last record of earlier parts that belongs to the session"
    )
    gap_seconds: float = double(
        4, "wall time from the last record of earlier parts to the going on", unit="s"
    )


Input = (
    SessionOpened
    | KeyChanged
    | PointerPressed
    | FocusChanged
    | TextTyped
    | WindowChanged
    | QuitRequested
    | TimestepDue
    | FleetObserved
    | RobotReported
    | FitCompleted
    | FitFailed
    | FitTimedOut
    | RecordingInterrupted
    | RecordingRestored
    | SessionResumed
    | ExperimenterCommanded
)
