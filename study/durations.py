"""How long a protocol takes: dwell in seconds, minutes by stage."""

from __future__ import annotations

from study.protocol import Condition, Protocol

PAGE_S = 30.0
READY_S = 4.0
SURVEY_S = 20.0
REVEAL_S = 10.0
FIT_S = 3.0
EVALUATION_TIMESTEPS_PER_SECOND = 500.0
"""Phase four runs as fast as the fleet answers; a modest machine."""


def dwell_seconds(protocol: Protocol) -> list[tuple[Condition, float]]:
    """Return each assisted condition with its dwell in seconds."""
    rate = protocol.timing.timesteps_per_second
    return [(c, c.dwell / rate) for c in protocol.conditions if c.dwell]


def expected_minutes(protocol: Protocol, horizon: int) -> list[tuple[str, float]]:
    """Return (stage, minutes) in order; episodes are taken to last half their horizon.

    Args:
        protocol: the study.
        horizon: longest episode of the task, timesteps.
    """
    rate = protocol.timing.timesteps_per_second
    one, two, three = protocol.phase_one, protocol.phase_two, protocol.phase_three
    asked = sum(len(use.when) for use in protocol.questionnaires)
    seconds = [
        ("Welcome and practice", 2 * PAGE_S + protocol.practice.timesteps / rate + READY_S),
        ("Phase one", PAGE_S + one.episodes * (0.5 * horizon / rate + READY_S)),
        ("Phase two", PAGE_S + two.trials * (two.trial_timesteps / rate + READY_S) + FIT_S),
    ]
    if round_ := protocol.correction_round:
        trials = round_.trials * (round_.trial_timesteps / rate + READY_S)
        seconds.append(("Correction round", PAGE_S + trials + FIT_S))
    for condition in protocol.conditions:
        trials = three.trials * (three.trial_timesteps / rate + READY_S)
        asking = asked * SURVEY_S + REVEAL_S
        seconds.append((f"Phase three, {condition.name}", PAGE_S + trials + asking))
    if protocol.phase_four:
        four = protocol.phase_four
        runs = (len(protocol.conditions) + 1) * four.trials * four.trial_timesteps
        seconds.append(("Phase four", runs / EVALUATION_TIMESTEPS_PER_SECOND))
    return [(stage, value / 60.0) for stage, value in seconds]
