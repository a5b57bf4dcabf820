"""Settings that are valid, and yet to be thought of: to be told, not refused."""

from __future__ import annotations

from collections.abc import Iterator

from study.protocol import Protocol


def remarks(protocol: Protocol, horizon: int) -> list[str]:
    """Return one sentence for each setting that nothing can come of, with its key path.

    Args:
        protocol: valid.
        horizon: longest episode of the task, timesteps.
    """
    return [
        *_dwells(protocol),
        *_exclusions(protocol, horizon),
        *_switching(protocol),
        *_never_reached(protocol, horizon),
        *_analyses(protocol),
    ]


def remark_on_consent(protocol: Protocol) -> str:
    """Return where else consent is to be asked for if the protocol has no text; empty if it has.

    Apart from `remarks`, since nothing is amiss: paper is as good.
    """
    if protocol.consent is not None:
        return ""
    return (
        "consent: there is none, so participants are asked on paper; to ask on the screen see "
        "docs/how-to/run-a-session-with-a-person.md"
    )


def _dwells(protocol: Protocol) -> Iterator[str]:
    length = protocol.phase_three.trial_timesteps
    for each in protocol.conditions:
        if each.dwell >= length:
            what = (
                "the robot is never switched"
                if each.allocation == "assisted"
                else "a suggestion is never renewed"
            )
            yield (
                f"conditions.{each.name}.dwell: {each.dwell} given, and a trial has {length} "
                f"timesteps: {what} within one"
            )


def _exclusions(protocol: Protocol, horizon: int) -> Iterator[str]:
    """Look for rules that leave out everybody, or nobody, whatever is recorded."""
    most = _most(protocol, horizon)
    for rule in protocol.exclusions:
        path = f"exclusions.{rule.name}.at_least"
        if rule.at_least > most[rule.measure]:
            what = rule.measure.replace("_", " ")
            yield (
                f"{path}: {rule.at_least:g} given, and a session has at most {most[rule.measure]} "
                f"{what}: everybody is left out"
            )
        elif rule.at_least <= 0:
            yield f"{path}: {rule.at_least:g} given, and no count is below it: nobody is left out"


def _most(protocol: Protocol, horizon: int) -> dict[str, int]:
    """Return the largest count of each measure that a session can come to."""
    one, two, three = protocol.phase_one, protocol.phase_two, protocol.phase_three
    gates = [part.gate for part in protocol.scorers.values() if part.gate]
    repeats = max([(gate.attempts - 1) * gate.repeat_trials for gate in gates], default=0)
    choosing = (two.trials + repeats) * two.trial_timesteps
    if part := protocol.correction_round:
        choosing += part.trials * part.trial_timesteps
    trials = len(protocol.conditions) * three.trials
    episode = min(one.episode_timesteps or horizon, horizon)
    driving = one.episodes * episode + choosing + trials * three.trial_timesteps
    # One choice and one demonstration a timestep at most: one robot is operated.
    return {"complete_trials": trials, "choices": choosing, "demonstrations": driving}


def _switching(protocol: Protocol) -> Iterator[str]:
    rate, settings = protocol.timing.timesteps_per_second, protocol.switching
    for each in protocol.conditions:
        if each.allocation != "assisted":
            continue
        seconds = each.dwell / rate
        for name, given, what in (
            ("cue_seconds", settings.cue_seconds, "the next switch is announced all the time"),
            ("grace_seconds", settings.grace_seconds, "every demonstration is flagged"),
        ):
            if given >= seconds:
                yield (
                    f"switching.{name}: {given:g} s given, and the dwell of {each.name} is "
                    f"{seconds:.2f} s: {what}"
                )


def _never_reached(protocol: Protocol, horizon: int) -> Iterator[str]:
    one, practice, rests = protocol.phase_one, protocol.practice, protocol.breaks
    if one.episode_timesteps > horizon:
        yield (
            f"phase_one.episode_timesteps: {one.episode_timesteps} given, and the task ends an "
            f"episode after {horizon}: it is never reached"
        )
    if practice.goals and not practice.timesteps:
        yield f"practice.goals: {practice.goals} given, but practice.timesteps is 0: there is none"
    if rests is not None and rests.every_trials >= protocol.phase_three.trials:
        yield (
            f"breaks.every_trials: {rests.every_trials} given, and a block has "
            f"{protocol.phase_three.trials} trials: there is no break within one"
        )
    if rests is not None and rests.minimum_seconds > rests.seconds:
        yield (
            f"breaks.minimum_seconds: {rests.minimum_seconds} given, more than the suggested "
            f"{rests.seconds} s: the timer is over before anybody may go on"
        )


def _analyses(protocol: Protocol) -> Iterator[str]:
    planned = protocol.analysis.planned
    if "phase_four" in planned and protocol.phase_four is None:
        yield 'analysis.planned: "phase_four" given, but there is no [phase_four]'
    for name in ("likert", "instruments"):
        if name in planned and not protocol.questionnaires:
            yield f'analysis.planned: "{name}" given, but no questionnaire is asked'
