"""How long a protocol takes: dwell in seconds, minutes by stage."""

from __future__ import annotations

from study.protocol import Condition, Occasion, Protocol

PAGE_S = 30.0
READY_S = 4.0
SURVEY_S = 20.0
REVEAL_S = 10.0
CONSENT_S = 90.0
QUESTION_S = 15.0
"""Of a comprehension check, which is passed at once."""
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
    practice = protocol.practice.timesteps / rate + READY_S
    seconds = [
        ("Welcome and practice", _before_practice_s(protocol) + 2 * PAGE_S + practice),
        ("Phase one", PAGE_S + one.episodes * (0.5 * horizon / rate + READY_S)),
        ("Phase two", PAGE_S + two.trials * (two.trial_timesteps / rate + READY_S) + FIT_S),
    ]
    if round_ := protocol.correction_round:
        trials = round_.trials * (round_.trial_timesteps / rate + READY_S)
        seconds.append(("Correction round", PAGE_S + trials + FIT_S))
    for condition in protocol.conditions:
        trials = three.trials * (three.trial_timesteps / rate + READY_S)
        asking = _surveys_s(protocol, "before_reveal", "after_reveal") + REVEAL_S
        rest = _breaks_s(protocol, three.trials)
        seconds.append((f"Phase three, {condition.name}", PAGE_S + rest + trials + asking))
    if protocol.phase_four:
        four = protocol.phase_four
        runs = (len(protocol.conditions) + 1) * four.trials * four.trial_timesteps
        seconds.append(("Phase four", runs / EVALUATION_TIMESTEPS_PER_SECOND))
    end = _surveys_s(protocol, "at_end") + (PAGE_S if protocol.debrief else 0.0)
    if end:
        seconds.append(("Questions and debrief", end))
    return [(stage, value / 60.0) for stage, value in seconds]


def _before_practice_s(protocol: Protocol) -> float:
    """Return how long consent, first questionnaires and the comprehension check take."""
    consent = CONSENT_S if protocol.consent else 0.0
    check = protocol.comprehension
    questions = len(check.questions) * QUESTION_S if check else 0.0
    return consent + _surveys_s(protocol, "at_start") + questions


def _surveys_s(protocol: Protocol, *occasions: Occasion) -> float:
    """Return how long the questionnaires take that are asked on some occasions."""
    return SURVEY_S * sum(
        occasion in use.when for use in protocol.questionnaires for occasion in occasions
    )


def _breaks_s(protocol: Protocol, trials: int) -> float:
    """Return how long the breaks before and within a block take; each as long as suggested."""
    breaks = protocol.breaks
    if breaks is None:
        return 0.0
    within = (trials - 1) // breaks.every_trials if breaks.every_trials else 0
    return (1 + within) * float(max(breaks.seconds, breaks.minimum_seconds))
