"""A page for each participant: what they did, what came of it, and what went otherwise."""

from __future__ import annotations

import dataclasses

import numpy as np
import pandas as pd

from analysis.figures.participant_trials import participant_trials
from analysis.figures.ratings import item_label
from analysis.figures.svg import Drawing
from analysis.formatting import counted, number
from analysis.recordings import Session
from analysis.results import StudyResults, rated_items
from analysis.sections import scored
from study.events.codes import Phase


@dataclasses.dataclass(frozen=True, slots=True)
class ConditionRow:
    """What a participant did under one condition; numbers as written."""

    label: str
    trials: int
    reward: str
    goals: int
    lost: int
    takeovers: str
    intervention: str
    answers: str


@dataclasses.dataclass(frozen=True, slots=True)
class Page:
    """One participant.

    Attributes:
        key: id of the page's section.
        participant: whose it is.
        facts: (name, value), in order.
        figure: team reward by trial; None without a trial.
        rows: by condition, the reference first.
        notes: what went otherwise, and what the experimenter noted, in words.
    """

    key: str
    participant: str
    facts: tuple[tuple[str, str], ...]
    figure: Drawing | None
    rows: tuple[ConditionRow, ...]
    notes: tuple[str, ...]


def pages(results: StudyResults) -> list[Page]:
    """Make a page for every session analysed or left out."""
    tables = results.tables
    frames = {
        name: tables.frame(name) for name in ("trials", "interventions", "responses", "scores")
    }
    return [
        _page(place, session, results, frames)
        for place, session in enumerate(results.study.sessions, start=1)
    ]


def _page(
    place: int, session: Session, results: StudyResults, frames: dict[str, pd.DataFrame]
) -> Page:
    who = session.opened.participant
    own = {name: frame[frame["participant"] == who] for name, frame in frames.items()}
    three = own["trials"]
    three = three[(three["phase"] == Phase.THREE) & three["scored"]]
    facts = results.facts
    order = " then ".join(facts.label(name) for name in session.opened.order)
    entries = [
        ("Order", order),
        ("Started, UTC", session.opened.started_utc[:16].replace("T", " ")),
        ("Session", "complete" if session.complete else "not complete"),
        ("Primary test", _entered(who, results)),
    ]
    drawing = None
    if len(three):
        drawing = participant_trials(
            f"trials{place}", who, three, session.opened.order, facts.levels, results.labels
        )
    return Page(
        key=f"participant-{place}",
        participant=who,
        facts=tuple(entries),
        figure=drawing,
        rows=tuple(_row(level, own, three, results) for level in facts.levels),
        notes=tuple(_notes(session, results)),
    )


def _entered(who: str, results: StudyResults) -> str:
    for item in results.cells.excluded:
        if item.participant == who:
            return f"left out: {item.reason}"
    if who not in results.cells.participants:
        return "not entered"
    place = results.cells.participants.index(who)
    means = results.cells.means[place]
    if means.size != 2:
        return "entered"
    return f"entered; difference {number(float(means[1] - means[0]))} points"


def _row(
    level: str, own: dict[str, pd.DataFrame], three: pd.DataFrame, results: StudyResults
) -> ConditionRow:
    trials = three[(three["condition"] == level) & three["complete"]]
    spans = own["interventions"]
    spans = spans[(spans["phase"] == Phase.THREE) & (spans["condition"] == level)]
    answers = _answers(level, own, results)
    reward = float(trials["team_reward"].mean()) if len(trials) else None
    takeovers = float(trials["takeovers"].mean()) if len(trials) else None
    return ConditionRow(
        label=results.facts.label(level),
        trials=len(trials),
        reward="–" if reward is None else number(reward),
        goals=int(trials["goals"].sum()),
        lost=int(trials["lost"].sum()),
        takeovers="–" if takeovers is None else number(takeovers, 1),
        intervention="–" if not len(spans) else f"{np.median(spans['length']):g}",
        answers=", ".join(answers) or "–",
    )


def _answers(level: str, own: dict[str, pd.DataFrame], results: StudyResults) -> list[str]:
    """Write the ratings given under a condition, then the scores: "Q1 5", "SUS 72.5"."""
    asked, rated = own["responses"], rated_items(results.facts)
    asked = asked[asked["condition"] == level]
    columns = (asked["questionnaire"], asked["item"], asked["occasion"], asked["answer"])
    found = [
        f"{item_label(str(item), str(when))} {answer}"
        for questionnaire, item, when, answer in zip(*columns, strict=True)
        if (questionnaire, item) in rated or questionnaire not in results.facts.instruments
    ]
    scores = own["scores"]
    scores = scores[scores["condition"] == level]
    names = ("questionnaire", "scale", "occasion", "score")
    for questionnaire, scale, when, score in zip(*(scores[n] for n in names), strict=True):
        mark = "*" if when == "after_reveal" else ""
        written = number(float(score)).rstrip("0").rstrip(".")
        found.append(f"{scored.scale_name(str(questionnaire), str(scale))}{mark} {written}")
    return found


def _notes(session: Session, results: StudyResults) -> list[str]:
    who = session.opened.participant
    notes = [row.text for row in results.deviations if row.participant == who]
    taken = results.tables.frame("notes")
    taken = taken[taken["participant"] == who]
    notes += [
        f"Experimenter, {_clock(float(t))} after the start: “{text}”"
        for t, text in zip(taken["t"], taken["text"], strict=True)
    ]
    typed = results.tables.frame("texts")
    typed = typed[(typed["participant"] == who) & (typed["text"] != "")]
    notes += [
        f"Answer to {questionnaire}, {item}: “{text}”"
        for questionnaire, item, text in zip(
            typed["questionnaire"], typed["item"], typed["text"], strict=True
        )
    ]
    notes += session.recording.problems
    departed = results.data.departures
    departed = departed[departed["participant"] == who]
    if len(departed):
        trials = counted(len(departed), "trial")
        notes.append(f"{trials} did not run as assigned; see “as treated”")
    return notes


def _clock(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    return f"{minutes}:{rest:02}"
