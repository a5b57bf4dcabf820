"""Learned scorers: heat maps over the map, and the measures of fit."""

from __future__ import annotations

import dataclasses

from analysis.figures.heat_maps import LOW_HEALTH, colour_bar, heat_map_row
from analysis.figures.score_maps import ScoreMap, score_map, shared_limit
from analysis.figures.scorer_accuracy import Accuracy, accuracy_dots
from analysis.figures.svg import Drawing
from analysis.formatting import counted, in_words, listed, number
from analysis.recordings import Session
from analysis.results import StudyResults
from analysis.statistics.by_trial import mean_over_trials
from analysis.tables.fits import applied_fits
from study.events.codes import Phase
from study.events.events import FitApplied

METRIC_HEADINGS = {
    "choices": ("Choices", 0),
    "held_out_choices": ("Held-out choices", 0),
    "held_out_top1": ("Held-out top-1", 2),
    "held_out_log_likelihood_per_choice": ("Held-out log-lik.", 2),
    "held_out_chance_log_likelihood": ("Chance log-lik.", 2),
    "held_out_calibration_error": ("Calibration error", 3),
    "top1": ("Top-1, in sample", 2),
}


@dataclasses.dataclass(frozen=True, slots=True)
class QualityTable:
    """Measures of fit, one row a scorer.

    Attributes:
        headings: of the measures.
        rows: participant, scorer, and the measures as written.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, str, tuple[str, ...]], ...]


def used_scorer(session: Session) -> FitApplied | None:
    """Return the fitted scorer with a score grid that phase three used, or else the last."""
    fits = [fit for fit in applied_fits(session).values() if fit.kind == "scorer"]
    fits = [fit for fit in fits if fit.score_grid.size]
    used = {t.scorer_id for t in session.trials.values() if t.phase == Phase.THREE and t.scorer_id}
    chosen = [fit for fit in fits if fit.artefact_id in used] or fits
    return chosen[-1] if chosen else None


def maps(results: StudyResults) -> list[ScoreMap]:
    """Compute the maps of all participants that have one."""
    made: list[ScoreMap] = []
    for session in results.study.sessions:
        fit, grid = used_scorer(session), session.task.map_grid
        if fit is None or grid is None:
            continue
        cells = len(grid.healths) * len(grid.headings) * len(grid.ys) * len(grid.xs)
        if fit.score_grid.size == cells and any("1" in row for row in grid.free):
            made.append(score_map(session.opened.participant, fit.score_grid, grid))
    return made


def figures(results: StudyResults) -> tuple[list[tuple[str, Drawing]], Drawing | None]:
    """Draw a row of maps for each participant, and the scale they share."""
    computed = maps(results)
    if not computed:
        return [], None
    limit = shared_limit(computed)
    sessions = {session.opened.participant: session for session in results.study.sessions}
    rows: list[tuple[str, Drawing]] = []
    for place, scores in enumerate(computed):
        task = sessions[scores.participant].task
        if task.map_grid is not None:
            drawing = heat_map_row(f"map{place}", scores, task.scene, task.map_grid, limit)
            rows.append((scores.participant, drawing))
    return rows, colour_bar("map-scale", limit)


def peak_finding(results: StudyResults) -> str:
    """Say what stands nearest to the highest peak of each map."""
    near: dict[str, int] = {}
    computed = maps(results)
    sessions = {session.opened.participant: session for session in results.study.sessions}
    for scores in computed:
        if scores.peaks:
            peak = scores.peaks[0]
            discs = sessions[scores.participant].task.scene.discs
            if discs:
                nearest = min(
                    discs, key=lambda d: ((d.x - peak.x) ** 2 + (d.y - peak.y) ** 2, d.role)
                )
                near[nearest.role] = near.get(nearest.role, 0) + 1
    names = {
        "goal": "the goal",
        "health_pack": "a health pack",
        "start": "the start",
        "wall": "an obstacle",
    }
    order = sorted(near, key=lambda role: (-near[role], role))
    if not order:
        return "No map has a peak."
    called = [names.get(role, role) for role in order]
    total = sum(near.values())
    if len(order) == 1:
        maps_text = "the one map" if total == 1 else f"each of {counted(total, 'map')}"
        return f"The landmark nearest to the highest peak of {maps_text} is {called[0]}."
    shown = [f"{name} for {near[role]}" for name, role in zip(called, order, strict=True)]
    return (
        f"Of {counted(total, 'map')}, the landmark nearest to the highest peak is {listed(shown)}."
    )


def has_health(results: StudyResults) -> bool:
    """Whether maps are drawn at several levels of health."""
    grids = [session.task.map_grid for session in results.study.sessions]
    return any(len(grid.healths) > 1 for grid in grids if grid)


def shows_low_health(results: StudyResults) -> bool:
    """Whether a map is drawn at a health that participants see a cue for."""
    grids = [session.task.map_grid for session in results.study.sessions]
    levels = [grid.healths for grid in grids if grid and len(grid.healths) > 1]
    return any(health < LOW_HEALTH for each in levels for health in each)


def accuracies(results: StudyResults) -> list[Accuracy]:
    """Return the held-out accuracy of the scorer that each participant's phase three used."""
    rows = results.tables.frame("fit_metrics")
    rows = rows[(rows["kind"] == "scorer")]
    trials = results.tables.frame("held_out_trials")
    found: list[Accuracy] = []
    for session in results.study.sessions:
        who, fit = session.opened.participant, used_scorer(session)
        own = rows[rows["participant"] == who]
        if fit is None:
            continue
        own = own[own["request_id"] == fit.request_id]
        seen = trials[trials["session"].astype(str) == session.opened.session_id]
        seen = seen[seen["request_id"] == fit.request_id]
        values = {str(m): float(v) for m, v in zip(own["metric"], own["value"], strict=True)}
        if "held_out_top1" in values:
            robots = {t.robots for t in session.trials.values() if t.phase == Phase.TWO}
            held_out = values.get("held_out_choices")
            choices = values.get("choices")
            found.append(
                Accuracy(
                    participant=who,
                    scorer=fit.artefact_id,
                    top1=values["held_out_top1"],
                    held_out=None if held_out is None else round(held_out),
                    choices=None if choices is None else round(choices),
                    chance=values.get(
                        "held_out_chance_top1", 1 / robots.pop() if len(robots) == 1 else None
                    ),
                    over_trials=mean_over_trials(
                        seen["top1"].to_numpy(), seen["choices"].to_numpy(dtype="float64")
                    )[1]
                    if len(seen)
                    else None,
                )
            )
    return found


def accuracy_figure(results: StudyResults) -> Drawing | None:
    """Draw the accuracies; None if none was recorded."""
    rows = accuracies(results)
    return accuracy_dots("accuracy", rows) if rows else None


def accuracy_finding(results: StudyResults) -> str:
    """Say how many scorers beat chance, as far as that can be told."""
    rows = accuracies(results)
    judged = [row for row in rows if row.beats_chance is not None]
    if not judged:
        return "How many choices were held out is not recorded, so no interval is drawn."
    better = sum(row.beats_chance is True for row in judged)
    worse = [row.participant for row in judged if row.below_chance]
    doubtful = [row.participant for row in judged if not row.beats_chance and not row.below_chance]
    count = f"{in_words(better, capital=True)} of {in_words(len(judged))}"
    text = f"{count} scorers that phase three used beat chance"
    if doubtful and len(doubtful) <= 4:
        text += f"; {listed(doubtful)} cannot be told from it"
    if worse and len(worse) <= 4:
        # Choices of trials that a scorer was not fitted on can be unlike those that it was.
        text += f"; {listed(worse)} did worse than chance"
    return f"{text}."


def quality(results: StudyResults) -> QualityTable | None:
    """Lay out the measures of fit of every scorer; None if none was fitted."""
    metrics = results.tables.frame("fit_metrics")
    metrics = metrics[metrics["kind"] == "scorer"]
    if not len(metrics):
        return None
    present = set(metrics["metric"])
    shown = [name for name in METRIC_HEADINGS if name in present]
    shown = shown or sorted(present)
    values: dict[tuple[str, str], dict[str, float]] = {}
    columns = ("participant", "artefact_id", "metric", "value")
    for who, artefact, metric, value in zip(*(metrics[c] for c in columns), strict=True):
        values.setdefault((str(who), str(artefact)), {})[str(metric)] = float(value)
    rows = tuple(
        (who, artefact, tuple(_written(found, name) for name in shown))
        for (who, artefact), found in sorted(values.items())
    )
    headings = tuple(METRIC_HEADINGS.get(n, (n.replace("_", " "), 2))[0] for n in shown)
    return QualityTable(headings, rows)


def _written(found: dict[str, float], name: str) -> str:
    if name not in found:
        return ""
    return number(found[name], METRIC_HEADINGS.get(name, (name, 2))[1])
