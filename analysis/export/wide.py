"""One row a participant: what JASP, jamovi and SPSS want for repeated measures."""

from __future__ import annotations

import re
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
    responses = results.tables.frame("responses")
    left_out = {item.participant: item.reason for item in results.cells.excluded}
    columns: list[Column] = [
        Column("participant", "text", "pseudonymous id of the participant"),
        Column("order", "text", "conditions of phase three in the order run"),
        Column("included", "boolean", "whether the participant entered the primary test"),
        Column("left_out_because", "text", "why not; empty if included"),
    ]
    people = [session.opened.participant for session in study.sessions]
    data: dict[str, Any] = {
        "participant": people,
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
    keys = sorted(set(zip(responses["item"], responses["occasion"], strict=True)))
    for item, occasion in keys:
        for level in facts.levels:
            rows = responses[
                (responses["item"] == item)
                & (responses["occasion"] == occasion)
                & (responses["condition"] == level)
            ]
            name = f"{_word(item)}_{_word(occasion)}_{_word(level)}"
            text = f"answer to {item}, {occasion.replace('_', ' ')}, {facts.label(level)}"
            columns.append(Column(name, "number", text))
            answers = rows.groupby(rows["participant"].astype("str"))["answer"].mean()
            data[name] = _by_person(answers, people)
    return Table("wide", "One row a participant.", columns, data)


def _by_person(values: pd.Series[Any], people: list[str]) -> list[float]:
    found = values.to_dict()
    return [float(found.get(who, float("nan"))) for who in people]


def _word(text: str) -> str:
    """Return a name that every program takes for a column."""
    return re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_").lower() or "x"
