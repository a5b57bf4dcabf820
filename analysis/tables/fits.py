"""One row a fit, and one row a measure of fit."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

from analysis.recordings import Session, StudyRecordings
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from study.events.events import FitApplied, FitRequested
from study.events.inputs import FitCompleted

COLUMNS = (
    *SESSION_COLUMNS,
    Column("request_id", "integer", "number of the request"),
    Column("artefact_id", "label", "name of what was fitted"),
    Column("kind", "label", "policy or scorer"),
    Column("algorithm", "label", "name in the protocol"),
    Column("rows", "integer", "demonstrations or choice rows used"),
    Column("applied", "boolean", "whether it took effect"),
    Column("seconds", "number", "time that the fit took; missing if it was not done", unit="s"),
    Column("data_sha256", "text", "SHA-256 of the training data, hexadecimal"),
    Column("weights_sha256", "text", "SHA-256 of the weights, hexadecimal"),
)

METRIC_COLUMNS = (
    *SESSION_COLUMNS,
    Column("request_id", "integer", "number of the request"),
    Column("artefact_id", "label", "name of what was fitted"),
    Column("kind", "label", "policy or scorer"),
    Column("algorithm", "label", "name in the protocol"),
    Column("rows", "integer", "demonstrations or choice rows used"),
    Column("metric", "label", "name of the measure"),
    Column("value", "number", "its value"),
)


BIN_METRIC = re.compile(r"held_out_calibration_bin_([0-9]{1,4})_(\w{1,40})")
"""Measures of one bin of predicted probability; they have a table of their own."""
TRIAL_METRIC = re.compile(r"held_out_trial_([0-9]{1,9})_(\w{1,40})")
"""Measures of one held-out trial; they have a table of their own."""


def build(study: StudyRecordings) -> Table:
    """Build the table of fits from the recordings."""
    rows = []
    for session in study.sessions:
        applied = applied_fits(session)
        seconds = {
            record.request_id: record.seconds
            for _, record in session.recording.records(FitCompleted.topic)
            if isinstance(record, FitCompleted)
        }
        for request in _requests(session):
            done = applied.get(request.request_id)
            rows.append(
                {
                    **_keys(session, request),
                    "applied": done is not None,
                    "seconds": seconds.get(request.request_id, math.nan),
                    "data_sha256": request.data_sha256,
                    "weights_sha256": done.weights_sha256 if done else "",
                }
            )
    return Table.from_rows("fits", "One row a fit.", COLUMNS, rows)


def build_metrics(study: StudyRecordings) -> Table:
    """Build the table of measures of fit from the recordings."""
    rows = []
    for session in study.sessions:
        applied = applied_fits(session)
        for request in _requests(session):
            done = applied.get(request.request_id)
            if done is not None:
                rows += [
                    {**_keys(session, request), "metric": name, "value": float(value)}
                    for name, value in zip(done.metric_names, done.metric_values, strict=True)
                    if not BIN_METRIC.fullmatch(name) and not TRIAL_METRIC.fullmatch(name)
                ]
    return Table.from_rows("fit_metrics", "One row a measure of fit.", METRIC_COLUMNS, rows)


def applied_fits(session: Session) -> dict[int, FitApplied]:
    """Return the fits that took effect, by request."""
    records = session.recording.records(FitApplied.topic)
    return {r.request_id: r for _, r in records if isinstance(r, FitApplied)}


def _requests(session: Session) -> Iterator[FitRequested]:
    for _, record in session.recording.records(FitRequested.topic):
        if isinstance(record, FitRequested):
            yield record


def _keys(session: Session, request: FitRequested) -> dict[str, object]:
    return {
        "participant": session.opened.participant,
        "session": session.opened.session_id,
        "request_id": request.request_id,
        "artefact_id": request.artefact_id,
        "kind": request.kind,
        "algorithm": request.algorithm,
        "rows": request.rows,
    }
