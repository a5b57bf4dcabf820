"""Header, headline and quality strip."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from markupsafe import Markup

from analysis.formatting import (
    NO_BREAK,
    counted,
    effect,
    equation,
    equation_alone,
    in_words,
    listed,
    number,
    p_equation,
)
from analysis.places import drop_outs, holds_slot
from analysis.recordings import Session
from analysis.results import StudyResults
from analysis.sections import effects
from analysis.statistics.result import ALPHA, EffectResult, Refusal


@dataclasses.dataclass(frozen=True, slots=True)
class Tile:
    """One number of the quality strip.

    Attributes:
        value: the number.
        of: what it is compared with, or empty.
        name: what is counted.
        good: whether nothing needs a look.
        text: the state in words.
        link: id of the section that tells more.
    """

    value: str
    of: str
    name: str
    good: bool
    text: str
    link: str


def headline(results: StudyResults) -> str:
    """Say what was found about team reward, in one sentence with effect and interval."""
    test, labels = results.primary, results.labels
    if isinstance(test, Refusal):
        return f"Team reward was not tested. {test.reason}"
    if test.estimate is None or test.interval is None:
        if effects.effects(results):
            return effects.effects_in_words(results)
        if test.p < ALPHA:
            return f"Team reward differed between {listed(labels)}."
        return f"No difference in team reward was detected between {listed(labels)}."
    low, high = number(test.interval.low, 1), number(test.interval.high, 1)
    reach = f"95%{NO_BREAK}CI {low} to {high}"
    reference, other = (float(np.mean(np.sort(column))) for column in results.cells.means.T)
    if test.interval.holds(0.0):
        return (
            f"No difference in team reward was detected between {labels[0]} and {labels[1]}: "
            f"{number(test.estimate, 1)} points a trial, {reach}."
        )
    way = "higher" if test.estimate > 0 else "lower"
    return (
        f"Team reward was {number(abs(test.estimate), 1)} points a trial {way} under "
        f"{labels[1]} than under {labels[0]}, {_reach(test)}: "
        f"{number(other, 1)} against {number(reference, 1)}."
    )


def _reach(test: EffectResult) -> str:
    """Write the interval of a difference whose sign is said in words."""
    assert test.interval is not None  # noqa: S101 - the caller has seen it
    bounds = (test.interval.low, test.interval.high)
    low, high = sorted(abs(bound) for bound in bounds)
    return f"95%{NO_BREAK}CI {number(low, 1)} to {number(high, 1)}"


def evidence(results: StudyResults) -> Markup:
    """Give the primary test and who did otherwise, under the headline."""
    test = results.primary
    if isinstance(test, Refusal):
        return Markup("")
    if results.by_trial:
        kind = "Mixed model of trials, as some are missing"
    elif test.estimate is not None:
        kind = "Paired test on participant means"
    else:
        kind = "Repeated-measures ANOVA of all conditions on participant means"
    text = Markup("{}: {}, {}.").format(kind, equation(test), effect(test.effects[0]))
    departed = len(results.data.departures)
    if departed:
        text += Markup(" {} did not run as assigned.").format(counted(departed, "trial"))
    if effects.effects(results):
        shown = Markup("; ").join(
            Markup("{} {}, Holm-adjusted {}").format(
                found.name.removesuffix(", mixed model").lower(),
                equation_alone(found),
                p_equation(found.p if found.p_adjusted is None else found.p_adjusted),
            )
            for found in effects.effects(results)
        )
        return Markup("By factor: {}. {}").format(shown, text)
    if effects.pairs(results):
        return text + " " + effects.pairs_finding(results)
    if len(results.cells.levels) != 2:
        return text
    return text + " " + direction(results)


def direction(results: StudyResults) -> str:
    """Say how many participants did better under the second condition, and who did not."""
    cells, label = results.cells, results.labels[1]
    better = cells.means[:, 1] > cells.means[:, 0]
    if cells.n == 1:
        did = "did better" if better[0] else "did not do better"
        return f"{cells.participants[0]} {did} under {label}."
    count = in_words(int(better.sum()), capital=True) if better.any() else "None"
    text = f"{count} of {in_words(cells.n)} participants did better under {label}"
    others = [who for who, yes in zip(cells.participants, better, strict=True) if not yes]
    if not others or len(others) == cells.n:
        return f"{text}."
    if len(others) > 4:
        return f"{text}; {in_words(len(others))} did not."
    return f"{text}; {listed(others)} did not."


def recorded(results: StudyResults) -> str:
    """Say when the sessions took place."""
    dates = sorted(s.opened.started_utc[:10] for s in results.study.sessions)
    return dates[0] if dates[0] == dates[-1] else f"{dates[0]} to {dates[-1]}"


def design(results: StudyResults) -> str:
    """Describe the design in a phrase."""
    trials = results.facts.planned_trials
    amount = f", {counted(trials, 'trial')} a condition" if trials else ""
    if not results.labels:
        return "No complete trial under any condition."
    compared = effects.factors_in_words(results) or " against ".join(results.labels)
    orders = {order for order in results.data.orders.values() if order}
    return f"Within-subjects study: {compared}, {counted(len(orders), 'order')}{amount}."


def participants_fact(results: StudyResults) -> str:
    """Say how many participants this page is about, and how many were planned."""
    sessions, planned = results.study.sessions, results.facts.planned_participants
    gone = drop_outs(sessions)
    among = f", {counted(gone, 'drop-out')} among them" if gone else ""
    return f"{len(sessions)} in this report{among}" + (f", {planned} planned" if planned else "")


def sessions_fact(results: StudyResults) -> str:
    """Say how many of their sessions are complete, and how many files are not analysed."""
    study = results.study
    complete = sum(session.complete for session in study.sessions)
    parts = [f"{complete} of {len(study.sessions)} complete"]
    left_out = len(study.set_aside) - study.unreadable
    if left_out:
        parts.append(f"{counted(left_out, 'file')} left out")
    if study.unreadable:
        parts.append(f"{counted(study.unreadable, 'file')} unreadable")
    return ", ".join(parts)


def tiles(results: StudyResults) -> list[Tile]:
    """Count what a reader wants to know before trusting a result."""
    study, data, facts = results.study, results.data, results.facts
    sessions = study.sessions
    complete = sum(session.complete for session in sessions)
    gone = drop_outs(sessions)
    planned = facts.planned_participants or len(sessions) - gone
    conditions = max(facts.planned_conditions, len(facts.levels))
    expected = (facts.planned_trials or 0) * conditions * planned
    trials = len(data.trials)
    away = [session.opened.participant for session in sessions if not holds_slot(session)]
    of_drop_outs = int(data.trials["participant"].isin(away).sum())
    excluded = results.cells.excluded
    deviations = len(results.deviations)
    skipped = int(results.tables.frame("timing")["skipped"].sum())
    faulty = sum(bool(s.recording.problems) for s in sessions) + study.unreadable
    broken = len(data.broken_trials) + sum(s.left_out_trials for s in sessions)
    planned_for = trials - of_drop_outs
    return [
        Tile(
            str(complete),
            f"of {len(sessions)}",
            "sessions complete",
            complete == len(sessions) == planned,
            _sessions_in_words(sessions, planned),
            "quality",
        ),
        Tile(
            str(planned_for),
            f"of {expected} planned" if expected else "",
            "trials analysed",
            broken == of_drop_outs == 0 and (not expected or planned_for == expected),
            _trials_in_words(planned_for, expected, broken, of_drop_outs),
            "quality",
        ),
        Tile(
            str(len(excluded)),
            "",
            "participants left out",
            not excluded,
            f"{counted(len(facts.exclusions), 'rule')} applied" if not excluded else "named below",
            "quality",
        ),
        Tile(
            str(deviations),
            "",
            "deviations",
            deviations == 0,
            "none recorded" if deviations == 0 else "listed below",
            "quality",
        ),
        Tile(
            str(skipped),
            "",
            "timesteps skipped",
            skipped == 0,
            "all on time" if skipped == 0 else "by session below",
            "timing",
        ),
        Tile(
            str(faulty),
            "",
            "files with problems",
            faulty == 0,
            "all files whole" if faulty == 0 else "listed below",
            "quality",
        ),
    ]


def _trials_in_words(trials: int, expected: int, broken: int, of_drop_outs: int) -> str:
    """Hold the trials of those who hold a slot against the plan; give drop-outs' beside it."""
    if broken:
        found = f"{broken} broken off"
    elif trials < expected:
        found = f"{expected - trials} not there"
    elif expected and trials > expected:
        found = f"{trials - expected} more than planned"
    else:
        found = "none broken off"
    return f"{found}; {of_drop_outs} of drop-outs too" if of_drop_outs else found


def _sessions_in_words(sessions: Sequence[Session], planned: int) -> str:
    held = [session for session in sessions if holds_slot(session)]
    incomplete, gone = sum(not s.complete for s in held), len(sessions) - len(held)
    parts = [f"{incomplete} incomplete"] if incomplete else []
    if gone:
        parts.append(counted(gone, "drop-out"))
    if len(held) > planned:
        parts.append(f"{len(held) - planned} more than planned")
    elif len(held) < planned:
        parts.append(f"{planned - len(held)} of {planned} planned not recorded")
    return "; ".join(parts) or "all complete"
