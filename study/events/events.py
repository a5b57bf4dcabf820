"""Events: all that the session derives from its inputs. Replayable, byte for byte.

``t_ns`` of an event is the time of the input that caused it. A *trial id* numbers every
fleet run of a session from 0, practice and phase four included; ``trial`` is its number
within its block, from 1.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from study.events.experimenter_records import ExperimenterNoted
from study.events.fields import (
    Record,
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
from study.events.fit_events import FitGateJudged, PreparationRequested, WarmStarted
from study.events.participant_events import (
    AnswerChanged,
    ComprehensionChecked,
    ConsentGiven,
    InstrumentScored,
    PracticeChecked,
    TextAnswered,
)


@record("event", "session_started")
class SessionStarted(Record):
    """The session accepted its protocol and assignment."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    participant: str = string(2, "pseudonymous id")
    order: tuple[str, ...] = strings(3, "conditions of phase three in the order run")
    stages: int = sfixed32(4, "number of stages planned")


@record("event", "stage_entered")
class StageEntered(Record):
    """A stage began: a screen or a state of the interface."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    stage: int = sfixed32(2, "place in the sequence, from 0")
    kind: str = string(
        3,
        '"pages", "trial", "fit", "preparation", "survey", "reveal", "break", "check"; '
        '"skipped" if the case that it was planned for did not arise',
    )
    name: str = string(4, 'which one: "instructions", "phase_three", ...')
    phase: int = sfixed32(5, "codes.Phase")
    block: int = sfixed32(6, "number of the block within its phase, from 1; 0 outside")
    condition: str = string(7, "name of the condition, or empty")


@record("event", "trial_started")
class TrialStarted(Record):
    """A fleet run began: its place, its policy and its scorer."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "number of the fleet run in the session, from 0")
    phase: int = sfixed32(3, "codes.Phase")
    block: int = sfixed32(4, "number of the block within its phase, from 1")
    condition: str = string(5, "name of the condition, or empty")
    trial: int = sfixed32(6, "number within the block, from 1")
    robots: int = sfixed32(7, "number of robots, n")
    timesteps: int = sfixed32(8, "planned length", unit="timesteps")
    allocation: str = string(
        9, '"correction", "manual", "correction_round", "suggested", "assisted" or "none"'
    )
    view: str = string(10, '"tiles", "operated_only" or "enlarged"')
    dwell: int = sfixed32(11, "timesteps between automatic switches; 0 if none", unit="timesteps")
    policy_id: str = string(12, 'which policy drives: "uniform_random" or a fit\'s artefact id')
    scorer_id: str = string(13, "which scorer is computed, or empty")
    scored: bool = boolean(14, "whether its reward counts (practice does not)")
    states: npt.NDArray[np.float32] = floats(15, "start states", shape="n,d")


@record("event", "timestep")
class Timestep(Record):
    """One step of the fleet and the choice made at it."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    due_ns: int = fixed64(2, "time at which the step was due", unit="ns")
    trial_id: int = sfixed32(3, "which fleet run")
    timestep: int = sfixed32(4, "number within the trial, from 0")
    robots: int = sfixed32(5, "number of robots, n")
    operated: int = sfixed32(6, "index of the operated robot, from 0; -1 if none")
    choice_source: int = sfixed32(7, "codes.ChoiceSource")
    choice_flag: int = sfixed32(8, "codes.ChoiceFlag")
    states: npt.NDArray[np.float32] = floats(9, "states before the step", shape="n,d")
    actions: npt.NDArray[np.int32] = ints(10, "executed actions", shape="n")
    action_sources: npt.NDArray[np.int32] = ints(11, "codes.ActionSource", shape="n")
    rewards: npt.NDArray[np.float32] = floats(12, "rewards of the step", shape="n")
    outcomes: npt.NDArray[np.int32] = ints(13, "codes.Outcome after the step", shape="n")
    available: npt.NDArray[np.int32] = ints(14, "1 if the robot could be chosen", shape="n")
    scores: npt.NDArray[np.float64] = doubles(
        15, "scores of the states before the step; empty if no scorer", shape="n or 0"
    )


@record("event", "suggestion")
class Suggestion(Record):
    """What was suggested at a timestep: one row a timestep where the allocation suggests."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    timestep: int = sfixed32(3, "number within the trial, from 0")
    suggested: int = sfixed32(4, "index of the suggested robot, from 0; -1 if none")


@record("event", "timestep_skipped")
class TimestepSkipped(Record):
    """A timestep was due but the fleet had not yet answered the one before."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    timestep: int = sfixed32(3, "number of the timestep still awaited")


@record("event", "switched")
class Switched(Record):
    """Another robot is operated from now on: a takeover, unless ``to_robot`` is -1."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    timestep: int = sfixed32(3, "the first timestep that it applies to")
    from_robot: int = sfixed32(4, "index from 0; -1 if none")
    to_robot: int = sfixed32(5, "index from 0; -1 if none")
    source: int = sfixed32(6, "codes.ChoiceSource")
    cause: str = string(
        7, '"number", "tab", "pointer", "accept", "dwell", "ended", "start" or "offer"'
    )


@record("event", "switch_announced")
class SwitchAnnounced(Record):
    """The screen began to announce that the scorer chooses anew."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    timestep: int = sfixed32(3, "the timestep that follows")
    seconds: float = double(4, "how long before the choice", unit="s")


@record("event", "grace_demonstration")
class GraceDemonstration(Record):
    """A demonstration made so soon after an automatic switch that it may be a slip."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    timestep: int = sfixed32(3, "at which timestep it was executed")
    since_switch_ns: int = fixed64(4, "from the switch to the step's being due", unit="ns")


@record("event", "episode_ended")
class EpisodeEnded(Record):
    """A robot reached the goal, was lost, or its time was up."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    robot: int = sfixed32(3, "index from 0")
    episode: int = sfixed32(4, "number of the robot's episode within the trial, from 1")
    timestep: int = sfixed32(5, "the last timestep of the episode")
    length: int = sfixed32(6, "number of timesteps", unit="timesteps")
    outcome: int = sfixed32(7, "codes.Outcome")
    episode_reward: float = double(8, "sum of the episode's rewards", unit="points")


@record("event", "trial_ended")
class TrialEnded(Record):
    """A fleet run is over."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    trial_id: int = sfixed32(2, "which fleet run")
    timesteps: int = sfixed32(3, "timesteps executed", unit="timesteps")
    team_reward: float = double(4, "sum over robots and timesteps", unit="points")
    complete: bool = boolean(5, "false if it was broken off")


@record("event", "fit_requested")
class FitRequested(Record):
    """A policy or a scorer is to be fitted."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    request_id: int = sfixed32(2, "number of the request")
    artefact_id: str = string(3, "name of what is fitted")
    kind: str = string(4, '"policy" or "scorer"')
    algorithm: str = string(5, 'name in the protocol: "nearest_neighbor", "luce", ...')
    rows: int = sfixed32(6, "demonstrations or choice rows used")
    data_sha256: str = string(7, "SHA-256 of the training data, hexadecimal")


@record("event", "fit_applied")
class FitApplied(Record):
    """A fit took effect."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    request_id: int = sfixed32(2, "number of the request")
    artefact_id: str = string(3, "name of what was fitted")
    kind: str = string(4, '"policy" or "scorer"')
    weights_sha256: str = string(5, "SHA-256 of the weights, hexadecimal")
    metric_names: tuple[str, ...] = strings(6, "names of the measures of fit")
    metric_values: npt.NDArray[np.float64] = doubles(7, "their values", shape="metrics")
    score_grid: npt.NDArray[np.float64] = doubles(
        8,
        "scorer's value over the task's map grid; empty for policies",
        shape="healths,headings,rows,columns or 0",
    )


@record("event", "question_answered")
class QuestionAnswered(Record):
    """An answer was confirmed."""

    t_ns: int = fixed64(1, "time of confirmation", unit="ns")
    questionnaire: str = string(2, "name of the questionnaire")
    item: str = string(3, "id of the item")
    value: int = sfixed32(4, "the answer")
    phase: int = sfixed32(5, "codes.Phase")
    block: int = sfixed32(6, "number of the block within its phase, from 1")
    condition: str = string(7, "name of the condition")
    occasion: str = string(8, '"before_reveal", "after_reveal", "at_start", "at_end"')
    latency_ns: int = fixed64(
        9, "from the screen's entry to the last change of the answer", unit="ns"
    )
    changes: int = sfixed32(10, "how often the answer was changed before confirmation")


@record("event", "reward_revealed")
class RewardRevealed(Record):
    """The participant was shown the reward of a block."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    phase: int = sfixed32(2, "codes.Phase")
    block: int = sfixed32(3, "number of the block within its phase, from 1")
    condition: str = string(4, "name of the condition")
    block_reward: float = double(5, "sum of the block's team rewards", unit="points")


@record("event", "paused")
class Paused(Record):
    """The session stands still."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    reason: str = string(2, '"operator", "focus lost", "experimenter", "window resized", ...')


@record("event", "resumed")
class Resumed(Record):
    """The session goes on."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    paused_ns: int = fixed64(2, "how long it stood still", unit="ns")


@record("event", "deviation")
class Deviation(Record):
    """Something did not go as the protocol says; analysis can exclude by its code."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    code: str = string(2, '"fit_failed", "ended_early", "recording_interrupted", ...')
    text: str = string(3, "what happened, in words")
    trial_id: int = sfixed32(4, "which fleet run; -1 if none")


@record("event", "session_ended")
class SessionEnded(Record):
    """The last event."""

    t_ns: int = fixed64(1, "time of the cause", unit="ns")
    complete: bool = boolean(2, "whether every stage was passed")
    reason: str = string(3, '"complete", "window closed", ...')


Event = (
    SessionStarted
    | StageEntered
    | TrialStarted
    | Timestep
    | Suggestion
    | TimestepSkipped
    | Switched
    | SwitchAnnounced
    | GraceDemonstration
    | PracticeChecked
    | ComprehensionChecked
    | ConsentGiven
    | AnswerChanged
    | TextAnswered
    | InstrumentScored
    | EpisodeEnded
    | TrialEnded
    | FitRequested
    | FitApplied
    | PreparationRequested
    | WarmStarted
    | FitGateJudged
    | QuestionAnswered
    | RewardRevealed
    | Paused
    | Resumed
    | Deviation
    | ExperimenterNoted
    | SessionEnded
)
