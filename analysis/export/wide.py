"""One row a participant: what JASP, jamovi and SPSS want for repeated measures.

Columns are variables, so that none is the same in every row by design: who produced the data is
told for each participant by "operator", not by a sentence about the whole study.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import pandas as pd

from analysis.results import StudyResults
from analysis.tables.columns import Column, Table


def wide_table(results: StudyResults) -> Table:
    """Lay out means and answers with a column for each condition.

    Participants who were left out keep their row, marked, so that nothing vanishes.
    """
    study, facts = results.study, results.facts
    trials = results.data.all_trials
    left_out = {item.participant: item.reason for item in results.cells.excluded}
    columns: list[Column] = [
        Column("participant", "text", "pseudonymous id of the participant"),
        Column("operator", "label", "who took part: person or simulated"),
        Column("order", "text", "conditions of phase three in the order run"),
        Column("included", "boolean", "whether the participant entered the primary test"),
        Column("left_out_because", "text", "why not; empty if included"),
    ]
    people = [session.opened.participant for session in study.sessions]
    data: dict[str, Any] = {
        "participant": people,
        "operator": [session.opened.operator_kind for session in study.sessions],
        "order": [", ".join(session.opened.order) for session in study.sessions],
        "included": [who in results.cells.participants for who in people],
        "left_out_because": [left_out.get(who, "") for who in people],
    }
    for level in facts.levels:
        rows = trials[trials["condition"] == level]
        label = facts.label(level)
        name = f"team_reward_{_word(level)}"
        means = rows.groupby(rows["participant"].astype("str"))["team_reward"].mean()
        columns.append(Column(name, "number", f"mean of complete trials, {label}", "points"))
        data[name] = _by_person(means, people)
        name = f"trials_{_word(level)}"
        counts = rows["participant"].astype("str").value_counts()
        columns.append(Column(name, "integer", f"complete trials, {label}", "trials"))
        data[name] = [int(counts.get(who, 0)) for who in people]
    for part in (_answers(results), _scores(results)):
        for column, values in part:
            columns.append(column)
            data[column.name] = _by_person(values, people)
    return Table("wide", "One row a participant.", columns, data)


def _answers(results: StudyResults) -> Iterator[tuple[Column, pd.Series[Any]]]:
    """Yield a column for each item, occasion and condition; one where there was no condition."""
    responses = results.tables.frame("responses")
    names = ("questionnaire", "item", "occasion")
    shared = _shared(zip(responses["questionnaire"], responses["item"], strict=True))
    for questionnaire, item, occasion in _distinct(responses, names):
        rows = responses[
            (responses["questionnaire"] == questionnaire)
            & (responses["item"] == item)
            & (responses["occasion"] == occasion)
        ]
        about = f"answer to {item} of {questionnaire}, {occasion.replace('_', ' ')}"
        stem = f"{_word(questionnaire)}_{_word(item)}" if item in shared else _word(item)
        yield from _by_condition(results, rows, "answer", f"{stem}_{_word(occasion)}", about)


def _scores(results: StudyResults) -> Iterator[tuple[Column, pd.Series[Any]]]:
    """Yield a column for each scale, occasion and condition."""
    scores = results.tables.frame("scores")
    for questionnaire, scale, occasion in _distinct(scores, ("questionnaire", "scale", "occasion")):
        rows = scores[
            (scores["questionnaire"] == questionnaire)
            & (scores["scale"] == scale)
            & (scores["occasion"] == occasion)
        ]
        about = f"score {scale} of {questionnaire}, {occasion.replace('_', ' ')}"
        stem = f"score_{_word(questionnaire)}_{_word(scale)}_{_word(occasion)}"
        yield from _by_condition(results, rows, "score", stem, about)


def _by_condition(
    results: StudyResults, rows: pd.DataFrame, value: str, stem: str, about: str
) -> Iterator[tuple[Column, pd.Series[Any]]]:
    facts = results.facts
    for level in ("", *facts.levels):
        own = rows[rows["condition"] == level]
        if level == "" and not len(own):
            continue
        if level and (rows["condition"] == "").all():
            return
        name = f"{stem}_{_word(level)}" if level else stem
        text = f"{about}, {facts.label(level)}" if level else about
        means = own.groupby(own["participant"].astype("str"))[value].mean()
        yield Column(name, "number", text), means


def _distinct(frame: pd.DataFrame, names: Sequence[str]) -> list[tuple[str, ...]]:
    columns = [frame[name].astype("str") for name in names]
    return sorted(set(zip(*columns, strict=True)))


def _shared(pairs: Iterable[tuple[str, str]]) -> frozenset[str]:
    """Return items that several questionnaires have."""
    counts = Counter(item for _, item in set(pairs))
    return frozenset(str(item) for item, count in counts.items() if count > 1)


def _by_person(values: pd.Series[Any], people: list[str]) -> list[float]:
    found = values.to_dict()
    return [float(found.get(who, float("nan"))) for who in people]


def _word(text: str) -> str:
    """Return a name that every program takes for a column."""
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "x"
