"""An experiment's tables as CSV, and its summary as Markdown for docs/results."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from pathlib import Path

from analysis.experiment.contrasts import mean_of
from analysis.experiment.frames import Experiment
from analysis.experiment.page import (
    headline,
    in_percent,
    mean_text,
    origin,
    scorer_rows,
    size_rows,
    versions,
    world_rows,
)
from analysis.experiment.paper import beside_the_paper, in_words
from analysis.experiment.questions import hypotheses
from analysis.files import make_folder, write_json, write_text
from analysis.formatting import NO_BREAK, p_value
from study.trial_files import results_sha256
from study.trial_tables import COLUMNS

DIALS = {
    "temperature": "temperature, points",
    "choices": "choices in phase two",
    "hidden": "units a layer of V, smoothness of phi",
}


def write_experiment_tables(experiment: Experiment, folder: Path) -> None:
    """Write every table as CSV, and what their columns mean as ``columns.json``.

    Raises:
        StudyError: a file cannot be written.
    """
    make_folder(folder)
    label = origin(experiment)
    for name, table in experiment.tables.items():
        rows = ((*row, label) for row in table.astype(object).itertuples(index=False))
        write_text(folder / f"{name}.csv", _csv((*table.columns, "data"), rows))
    write_text(folder / "differences.csv", _differences(experiment))
    meaning = {
        name: {column: {"type": kind, "meaning": text} for column, (kind, text) in columns.items()}
        for name, columns in COLUMNS.items()
    }
    write_json(folder / "columns.json", {"data": label, "tables": meaning})


def markdown(experiment: Experiment, command: str, wall_time: str) -> str:
    """Return the summary tables with what made them.

    Args:
        experiment: the results.
        command: that ran it.
        wall_time: how long it took, in words.
    """
    head = experiment.results.head
    tests = hypotheses(experiment)
    made_with = ", ".join(f"{name} {version}" for name, version in versions(experiment))
    computing = sum(trial.seconds for trial in experiment.results.trials)
    sizes = size_rows(experiment)
    parts = [
        f"# {experiment.protocol['experiment']['title']}",
        f"{origin(experiment)}. The user is software; nothing here was measured with people.",
        f"```sh\n{command}\n```",
        _table(
            ("", ""),
            [
                ("worlds", f"{head.seeds.replace('_', '-')}, seed "
                           f"{experiment.protocol['seeds'][head.seeds]}"),
                ("trials", f"{experiment.trials} of {experiment.planned} planned"),
                ("wall time", wall_time),
                ("computing time", f"{computing / 60:.1f} minutes, added up over trials"),
                ("computed with", made_with),
                ("protocol, SHA-256", f"`{head.sha256}`"),
                ("results, SHA-256", f"`{results_sha256(experiment.results.trials)}`"),
            ],
        ),
        "## What came out",
        headline(tests),
        "\n".join(f"- {sentence}" for sentence in in_words(experiment, tests)),
        "## The paper and ours",
        _table(
            ("measure", "paper", "ours, mean [95 % CI]"),
            [
                (row.what, row.paper,
                 row.said if row.ours is None else mean_text(row.ours, row.decimals))
                for row in beside_the_paper(experiment)
            ],
        ),
        "## Measures",
        _table(
            ("scorer", "dwell", "team reward", "agreement, own states",
             "agreement, ground truth's states", "policy alone", "data impact"),
            [
                (row.label, str(row.dwell or "–"), mean_text(row.reward, 1), mean_text(row.own),
                 mean_text(row.reference), mean_text(row.policy, 1),
                 mean_text(row.impact, 1) if row.dwell else "–")
                for row in scorer_rows(experiment)
            ],
        ),
        "## Paired differences",
        "Agreement in percentage points; *p* of the paired *t* test, Holm within each heading; "
        "*ahead* is the part of the trials in which the first is ahead.",
    ]  # fmt: skip
    for heading, contrasts in tests.items():
        parts.append(f"### {heading}")
        parts.append(
            _table(
                ("difference", "measure", "mean [95 % CI]", "p", "ahead"),
                [
                    (
                        f"{experiment.label(test.first)} − {experiment.label(test.second)}",
                        test.measure,
                        mean_text(in_percent(test.mean) if test.unit == "share" else test.mean, 1),
                        p_value(test.p_adjusted),
                        f"{100 * test.better:.0f} %",
                    )
                    for test in contrasts
                ],
            )
        )
    parts += _sensitivity(experiment)
    if sizes[1]:
        parts += [
            "## Fleet size",
            "Points that one operator adds to a run of the fleet, mean [95 % CI].",
            _table(
                ("robots", *sizes[0]),
                [(str(row.robots), *(mean_text(g, 1) for g in row.gains)) for row in sizes[1]],
            ),
        ]
    parts += [
        "## Worlds",
        _table(
            ("", "mean [95 % CI]"),
            [(words, mean_text(mean, places)) for words, mean, places in world_rows(experiment)],
        ),
    ]
    return "\n\n".join(parts).replace(NO_BREAK, " ") + "\n"


def _sensitivity(experiment: Experiment) -> list[str]:
    """Return heading, sentence and table of agreement at each setting of each dial."""
    table = experiment.tables["sensitivity"]
    if table.empty:
        return []
    rows = [
        (
            DIALS.get(str(dial), str(dial)), f"{setting:g}", experiment.label(str(scorer)),
            mean_text(mean_of(own["own_agreement"])),
            mean_text(mean_of(own["reference_agreement"])),
        )
        for (dial, setting, scorer), own in table.groupby(
            ["dial", "setting", "scorer"], sort=False
        )
    ]  # fmt: skip
    trials = table["trial"].nunique()
    return [
        "## Sensitivity",
        f"Agreement with one dial turned at a time, the first {trials} trials, mean [95 % CI].",
        _table(("dial", "setting", "scorer", "own states", "ground truth's states"), rows),
    ]


def _differences(experiment: Experiment) -> str:
    columns = ("heading", "first", "second", "measure", "unit", "trials", "mean", "low", "high",
               "t", "p", "p_holm", "ahead")  # fmt: skip
    rows = [
        (heading, t.first, t.second, t.measure, t.unit, t.mean.n, t.mean.value,
         t.mean.interval.low if t.mean.interval else "",
         t.mean.interval.high if t.mean.interval else "",
         "" if t.t is None else t.t, t.p, t.p_adjusted, t.better)
        for heading, tests in hypotheses(experiment).items()
        for t in tests
    ]  # fmt: skip
    return _csv(columns, rows)


def _csv(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(["" if _missing(cell) else cell for cell in row] for row in rows)
    return stream.getvalue()


def _missing(cell: object) -> bool:
    return cell is None or (isinstance(cell, float) and cell != cell)  # noqa: PLR0124 - nan


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(
        f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines
    )
