"""A plan on disk: its report, and its tables as CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from analysis.files import make_folder, write_json, write_text
from analysis.planning.page import origin, render_plan
from analysis.planning.plan import Plan
from analysis.planning.power import Cell
from analysis.planning.stated import PlannedStudy, Stated
from study.whatif_files import FORMULA_SIGNS

_POWER = {
    "participants": ("whole", "", "participants who begin"),
    "trials": ("whole", "", "trials of each participant under each condition"),
    "minutes": ("number", "min", "length of one participant's trials"),
    "power": ("number", "share", "simulated studies that found something"),
    "low": ("number", "share", "lower end of its 95 % Monte-Carlo interval (Wilson)"),
    "high": ("number", "share", "upper end"),
    "closed_form": ("number", "share", "power by the closed form; empty where there is none"),
    "exact": ("boolean", "", "whether the closed form is that of the very test"),
    "studies": ("whole", "", "simulated studies"),
    "found": ("whole", "", "of which the primary test's p was below the level"),
    "wrong_sign": ("whole", "", "of which the estimate's sign was not that of the effect"),
    "refused": ("whole", "", "studies without a test"),
    "by_model": ("whole", "", "studies in which trials were missing, for the mixed model"),
    "exaggeration": ("number", "", "mean estimate of those that found something, by the truth"),
}
COLUMNS: Mapping[str, Mapping[str, tuple[str, str, str]]] = {
    "power": {
        "role": ("text", "", "grid, check (simulated afresh) or failed (fell short afresh)"),
        "named": ("boolean", "", "whether it is the size that the plan names"),
        **_POWER,
    },
    "otherwise": {"assumed": ("text", "", "what else were true"), **_POWER},
    "assumptions": {
        "assumption": ("text", "", "what is assumed"),
        "option": ("text", "", "that gives it"),
        "value": ("number", "as in unit", "the number"),
        "unit": ("text", "", "of value and interval"),
        "low": ("number", "as in unit", "lower end of the pilot's 95 % interval"),
        "high": ("number", "as in unit", "upper end"),
        "source": ("text", "", "where it comes from"),
    },
}


def write_plan(plan: Plan, study: PlannedStudy, stated: Sequence[Stated], folder: Path) -> Path:
    """Write ``report.html`` and ``tables/``; return the report's path.

    Raises:
        StudyError: a file cannot be written.
    """
    tables = folder / "tables"
    make_folder(tables)
    label = origin(plan)
    roles = [("grid", cell) for cell in plan.cells]
    roles += [("failed", cell) for cell in plan.failed]
    roles += [("check", plan.check)] if plan.check is not None else []
    named = plan.chosen.design if plan.chosen is not None else None
    rows: dict[str, list[Sequence[Any]]] = {
        "power": [(role, cell.design == named, *_cell(cell, study)) for role, cell in roles],
        "otherwise": [(row.text, *_cell(row.cell, study)) for row in plan.variations],
        "assumptions": [
            (
                row.text,
                row.option.removeprefix("--"),
                row.value,
                row.unit,
                *((row.interval.low, row.interval.high) if row.interval else (None, None)),
                row.source,
            )
            for row in stated
        ],
    }
    for name, columns in COLUMNS.items():
        write_text(tables / f"{name}.csv", _csv((*columns, "data"), rows[name], label))
    meaning = {
        name: {
            column: {"type": kind, "unit": unit, "meaning": text}
            for column, (kind, unit, text) in columns.items()
        }
        for name, columns in COLUMNS.items()
    }
    write_json(tables / "columns.json", {"data": label, "tables": meaning})
    path = folder / "report.html"
    write_text(path, render_plan(plan, study, stated))
    return path


def _cell(cell: Cell, study: PlannedStudy) -> Sequence[Any]:
    counts, bounds, formula = cell.counts, cell.interval, cell.formula
    return (
        cell.design.participants,
        cell.design.trials,
        study.minutes(cell.design.trials),
        cell.power,
        bounds.low,
        bounds.high,
        formula.power if formula else None,
        formula.exact if formula else None,
        counts.studies,
        counts.found,
        counts.wrong,
        counts.refused,
        counts.by_model,
        cell.exaggeration,
    )


def _csv(head: Sequence[str], rows: Sequence[Sequence[Any]], label: str) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([*(_written(value) for value in row), label] for row in rows)
    return stream.getvalue()


def _written(value: object) -> object:
    if value is None:
        return ""
    if isinstance(value, str) and value.startswith(FORMULA_SIGNS):
        return f"'{value}"
    return str(value).lower() if isinstance(value, bool) else value
