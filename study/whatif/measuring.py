"""From judged choices to the rows of the tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from study.whatif.named_scorers import Asked
from study.whatif.scoring import Judged
from study.whatif.sessions import ChoiceSession, FleetRun
from study.whatif_files import Columns
from study.whatif_tables import COLUMNS

BINS = 8
"""Bins of the range of a number of the state."""
TENTHS = 10
DECIMALS = 6
"""In the tables: a likelihood is not known any better."""

Mask = npt.NDArray[np.bool_]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Answers:
    """What one scorer says of the choices of one session.

    Attributes:
        asked: the scorer.
        session: whose choices.
        runs: fleet runs that it was asked about.
        judged: what it says of each.
        keep: bool [m] of each run, which choices count.
    """

    asked: Asked
    session: ChoiceSession
    runs: Sequence[FleetRun]
    judged: Sequence[Judged]
    keep: Sequence[Mask]

    def seen(self, run: FleetRun) -> Mask:
        """Return which choices of a run the scorer was fitted to, bool [m]."""
        fitted = self.session.fitted(run)
        mine = self.asked.fitted_to == self.session.participant
        return fitted if mine and self.asked.trials is None else np.zeros_like(fitted)


class TableBuilder:
    """Collects rows of one table, column by column."""

    def __init__(self, name: str) -> None:
        self._declared = COLUMNS[name]
        self.columns: Columns = {column: [] for column in self._declared}

    def add(self, rows: int, **values: Any) -> None:  # noqa: ANN401 - one value, or one a row
        """Append rows: each value is an array with one for each, or the same for all."""
        for column, (kind, _, _) in self._declared.items():
            value = values.pop(column)
            if not isinstance(value, np.ndarray):
                self.columns[column] += [value] * rows
                continue
            array = value.round(DECIMALS) if kind == "number" else value
            self.columns[column] += array.tolist()
        if values:
            raise ValueError(f"not declared: {sorted(values)}")


def run_keys(session: ChoiceSession, run: FleetRun) -> dict[str, Any]:
    """Return the columns that place a fleet run."""
    return {
        "participant": session.participant,
        "session": session.opened.session_id,
        "trial_id": run.trial_id,
        "phase": run.started.phase,
        "condition": run.started.condition,
        "trial": run.started.trial,
    }


def add_choices(table: TableBuilder, answers: Answers) -> None:
    """Append a row for each choice."""
    for run, judged, keep in zip(answers.runs, answers.judged, answers.keep, strict=True):
        offered = run.counts[keep]
        table.add(
            int(keep.sum()),
            **run_keys(answers.session, run),
            timestep=run.timesteps[keep],
            seconds=run.seconds[keep],
            robots=run.states.shape[1],
            available=offered,
            scorer=answers.asked.name,
            fitted=answers.session.fitted(run)[keep],
            seen=answers.seen(run)[keep],
            chosen=run.chosen[keep] + 1,
            first=judged.first[keep] + 1,
            rank=judged.rank[keep],
            log_likelihood=judged.log_likelihood[keep] if answers.asked.log_odds else None,
            chance_log_likelihood=-np.log(offered),
        )


def add_trials(table: TableBuilder, answers: Answers) -> None:
    """Append a row for each fleet run, two where its choices were seen in part."""
    for place, run in enumerate(answers.runs):
        judged, keep = answers.judged[place], answers.keep[place]
        fitted, seen = answers.session.fitted(run), answers.seen(run)
        for was_fitted in (True, False):
            which = keep & (fitted == was_fitted)
            if not which.any():
                continue
            offered = run.counts[which]
            table.add(
                1,
                **run_keys(answers.session, run),
                robots=run.states.shape[1],
                scorer=answers.asked.name,
                fitted=was_fitted,
                seen=bool(seen[which].any()),
                **_means([(run, judged, which)], answers.asked),
                rank=round(float(judged.rank[which].mean()), DECIMALS),
                chance_rank=round(float((offered + 1).mean() / 2), DECIMALS),
            )


def add_cells(
    table: TableBuilder, owner: str, answers: Answers, kinds: Sequence[bool] = (True, False)
) -> None:
    """Append the matrix's cells of a scorer and a participant.

    Args:
        table: of the matrix.
        owner: whose scorer.
        answers: what it says.
        kinds: a cell each: of choices that the participant's own scorer was fitted to, or not.
    """
    for was_fitted in kinds:
        parts = []
        for run, judged, keep in zip(answers.runs, answers.judged, answers.keep, strict=True):
            parts.append((run, judged, keep & (answers.session.fitted(run) == was_fitted)))
        if any(which.any() for _, _, which in parts):
            table.add(
                1,
                scorer_of=owner,
                participant=answers.session.participant,
                session=answers.session.opened.session_id,
                fitted=was_fitted,
                seen=was_fitted and any(answers.seen(run).any() for run in answers.runs),
                **_means(parts, answers.asked),
            )


def add_states(table: TableBuilder, answers: Answers) -> None:
    """Append a row for each bin of each number of the chosen robot's state."""
    parts = _comparable(answers)
    for place, field in enumerate(answers.session.task.state_fields):
        edges = np.linspace(field.low, field.high, BINS + 1)
        bins = [
            np.clip(np.searchsorted(edges, _chosen_states(run)[:, place], "right"), 1, BINS)
            for run, _, _ in parts
        ]
        for number, binned in _each_bin(parts, bins, BINS):
            table.add(
                1,
                scorer=answers.asked.name,
                participant=answers.session.participant,
                session=answers.session.opened.session_id,
                field=field.name,
                unit=field.unit,
                bin=number,
                low=round(float(edges[number - 1]), DECIMALS),
                high=round(float(edges[number]), DECIMALS),
                **_means(binned, answers.asked),
            )


def add_times(table: TableBuilder, answers: Answers) -> None:
    """Append a row for each tenth of the planned length of a fleet run."""
    parts = _comparable(answers)
    bins = [
        np.clip(run.timesteps * TENTHS // max(run.started.timesteps, 1), 0, TENTHS - 1) + 1
        for run, _, _ in parts
    ]
    for number, binned in _each_bin(parts, bins, TENTHS):
        table.add(
            1,
            scorer=answers.asked.name,
            participant=answers.session.participant,
            session=answers.session.opened.session_id,
            bin=number,
            **_means(binned, answers.asked),
        )


Part = tuple[FleetRun, Judged, Mask]


def _comparable(answers: Answers) -> list[Part]:
    """Return the choices that all scorers can be compared on: made after the own ones' fits.

    Cross-validated scorers are asked about those before. Where there are none after, what the
    scorer was not fitted to takes their place.
    """
    session = answers.session
    later = answers.asked.trials is None and any(
        not session.fitted(run).all() for run in session.runs
    )
    return [
        (run, judged, keep & ~answers.seen(run) & ~(session.fitted(run) & later))
        for run, judged, keep in zip(answers.runs, answers.judged, answers.keep, strict=True)
    ]


def _each_bin(
    parts: Sequence[Part], bins: Sequence[npt.NDArray[np.int64]], count: int
) -> Iterable[tuple[int, list[Part]]]:
    for number in range(1, count + 1):
        binned = [
            (run, judged, which & (own == number))
            for (run, judged, which), own in zip(parts, bins, strict=True)
        ]
        if any(which.any() for _, _, which in binned):
            yield number, binned


def _chosen_states(run: FleetRun) -> npt.NDArray[np.float32]:
    return run.states[run.rows, run.chosen]


def _means(parts: Sequence[Part], asked: Asked) -> dict[str, Any]:
    """Return the measures of all choices of some runs together."""
    offered = np.concatenate([run.counts[which] for run, _, which in parts])
    hits = np.concatenate([(j.first == run.chosen)[which] for run, j, which in parts])
    logs = np.concatenate([judged.log_likelihood[which] for _, judged, which in parts])
    return {
        "choices": len(hits),
        "agreement": round(float(hits.mean()), DECIMALS),
        "chance_agreement": round(float((1 / offered).mean()), DECIMALS),
        "log_likelihood": round(float(logs.mean()), DECIMALS) if asked.log_odds else None,
        "chance_log_likelihood": round(float(-np.log(offered).mean()), DECIMALS),
    }
