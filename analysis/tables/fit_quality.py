"""How good fits are on held-out trials: by trial, by bin of prediction, and what gates decided."""

from __future__ import annotations

import re
from collections.abc import Iterator

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.fits import BIN_METRIC, TRIAL_METRIC, applied_fits
from study.events.events import FitApplied
from study.events.fit_events import FitGateJudged, WarmStarted

BINS = 10
"""Bins of predicted probability, of equal width."""

FIT_COLUMNS = (
    *SESSION_COLUMNS,
    Column("request_id", "integer", "number of the fit's request"),
    Column("artefact_id", "label", "name of what was fitted"),
)

CALIBRATION_COLUMNS = (
    *FIT_COLUMNS,
    Column("bin", "integer", "number of the bin, from 1"),
    Column("low", "number", "lowest predicted probability in it"),
    Column("high", "number", "highest predicted probability in it"),
    Column("robots", "integer", "robots that could be chosen, over all held-out choices"),
    Column("predicted", "number", "their mean predicted probability of being chosen"),
    Column("chosen", "number", "share of them that was chosen"),
)

HELD_OUT_COLUMNS = (
    *FIT_COLUMNS,
    Column("trial_id", "integer", "the fleet run that the scorer had not seen"),
    Column("choices", "integer", "its choices"),
    Column("log_likelihood", "number", "mean log-likelihood of a choice", unit="nats"),
    Column("chance_log_likelihood", "number", "that of equal chances", unit="nats"),
    Column("top1", "number", "share of choices that fell on the highest score"),
    Column("chance_top1", "number", "that of equal chances"),
)

GATE_COLUMNS = (
    *FIT_COLUMNS,
    Column("attempt", "integer", "attempt, from 1"),
    Column("attempts", "integer", "how many there are at most"),
    Column("warm", "boolean", "whether the fit went on from one made in the background"),
    Column("passed", "boolean", "whether it reached every threshold"),
    Column("decision", "label", "what followed: use, repeat, go_on, fallback or end"),
    Column("fallback", "label", "what took its place: manual, a scorer, or empty"),
    Column("likelihood_gain", "number", "held-out, a choice, above chance", unit="nats"),
    Column("min_likelihood_gain", "number", "its threshold", unit="nats"),
    Column("top1_gain", "number", "held-out, above chance"),
    Column("min_top1_gain", "number", "its threshold"),
    Column("calibration_error", "number", "held-out expected calibration error"),
    Column("max_calibration_error", "number", "its threshold"),
    Column("reason", "text", "why it did not pass, in words"),
)


def build_calibration(study: StudyRecordings) -> Table:
    """Build the reliability table: predicted probabilities against shares chosen."""
    rows = [
        {
            **fit,
            "bin": number,
            "low": (number - 1) / BINS,
            "high": number / BINS,
            "robots": round(values["robots"]),
            "predicted": values["predicted"],
            "chosen": values["chosen"],
        }
        for fit, number, values in _numbered(study, BIN_METRIC)
    ]
    text = "One row a bin of predicted probability of a fit, over its held-out choices."
    return Table.from_rows("calibration", text, CALIBRATION_COLUMNS, rows)


def build_held_out(study: StudyRecordings) -> Table:
    """Build the table of held-out trials."""
    rows = [
        {
            **fit,
            "trial_id": trial_id,
            "choices": round(values["choices"]),
            "log_likelihood": values["log_likelihood_per_choice"],
            "chance_log_likelihood": values["chance_log_likelihood"],
            "top1": values["top1"],
            "chance_top1": values["chance_top1"],
        }
        for fit, trial_id, values in _numbered(study, TRIAL_METRIC)
    ]
    text = "One row a trial held out from a fit."
    return Table.from_rows("held_out_trials", text, HELD_OUT_COLUMNS, rows)


def build_gates(study: StudyRecordings) -> Table:
    """Build the table of what gates found and decided."""
    names = [
        column.name for column in GATE_COLUMNS[len(SESSION_COLUMNS) :] if column.name != "warm"
    ]
    rows = []
    for session in study.sessions:
        warm = {
            record.request_id
            for _, record in session.recording.records(WarmStarted.topic)
            if isinstance(record, WarmStarted)
        }
        for _, record in session.recording.records(FitGateJudged.topic):
            if isinstance(record, FitGateJudged):
                rows.append(
                    {
                        "participant": session.opened.participant,
                        "session": session.opened.session_id,
                        "warm": record.request_id in warm,
                        **{name: getattr(record, name) for name in names},
                    }
                )
    text = "One row each time that a scorer was held against its gate."
    return Table.from_rows("fit_gates", text, GATE_COLUMNS, rows)


def _numbered(
    study: StudyRecordings, pattern: re.Pattern[str]
) -> Iterator[tuple[dict[str, object], int, dict[str, float]]]:
    """Yield the measures whose names have a number in them: of which fit, the number, and them."""
    for session in study.sessions:
        for fit in applied_fits(session).values():
            found: dict[int, dict[str, float]] = {}
            for name, value in zip(fit.metric_names, fit.metric_values.tolist(), strict=True):
                match = pattern.fullmatch(name)
                if match:
                    found.setdefault(int(match[1]), {})[match[2]] = value
            for number, values in sorted(found.items()):
                yield _keys(session, fit), number, values


def _keys(session: Session, fit: FitApplied) -> dict[str, object]:
    return {
        "participant": session.opened.participant,
        "session": session.opened.session_id,
        "request_id": fit.request_id,
        "artefact_id": fit.artefact_id,
    }
