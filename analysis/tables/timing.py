"""One row a fleet run: how punctual timesteps and pictures were."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from analysis.recordings import Session, StudyRecordings, timestep_blocks
from analysis.tables.columns import SESSION_COLUMNS, Column, Table
from analysis.tables.trial_columns import TRIAL_COLUMNS, trial_keys
from study.events.events import TimestepSkipped
from study.events.shell import DisplayOpened, FrameIntervals, TrialTiming

LATE_PERIODS = 1.2
"""A picture later than this many periods of the display after the one before is late."""

COLUMNS = (
    *SESSION_COLUMNS,
    *TRIAL_COLUMNS,
    Column("timesteps", "integer", "timesteps executed", unit="timesteps"),
    Column("skipped", "integer", "timesteps due while the fleet had not answered"),
    Column("interval_median", "number", "between timesteps", unit="s"),
    Column("interval_max", "number", "longest between timesteps", unit="s"),
    Column("late_median", "number", "timestep after its deadline", unit="s"),
    Column("late_p99", "number", "99th percentile of the same", unit="s"),
    Column("late_max", "number", "largest of the same", unit="s"),
    Column("frames", "integer", "intervals between pictures recorded"),
    Column("frame_median", "number", "between pictures; missing without a window", unit="s"),
    Column("frame_p99", "number", "99th percentile of the same", unit="s"),
    Column("frame_max", "number", "largest of the same", unit="s"),
    Column("frames_late", "integer", "pictures later than 1.2 of the display's periods"),
    Column("frames_late_share", "number", "those as a share of all; missing without a window"),
    Column("poll_gap_median", "number", "between readings of the keys", unit="s"),
    Column("poll_gap_p99", "number", "99th percentile of the same", unit="s"),
    Column(
        "poll_gap_max", "number", "largest of the same: no reaction time errs by more", unit="s"
    ),
)


def build(study: StudyRecordings) -> Table:
    """Build the table from the recordings."""
    rows = [row for session in study.sessions for row in _rows(session)]
    return Table.from_rows("timing", "One row a fleet run.", COLUMNS, rows)


def _rows(session: Session) -> list[dict[str, object]]:
    times = _times(session)
    frames: dict[int, list[npt.NDArray[np.float64]]] = {}
    skipped: dict[int, int] = {}
    stated: dict[int, TrialTiming] = {}
    refresh_hz = math.nan
    topics = (
        DisplayOpened.topic, FrameIntervals.topic, TimestepSkipped.topic, TrialTiming.topic
    )  # fmt: skip
    for _, record in session.recording.records(*topics):
        if isinstance(record, DisplayOpened):
            refresh_hz = record.refresh_hz
        elif isinstance(record, TrialTiming):
            stated[record.trial_id] = record
        elif isinstance(record, FrameIntervals):
            frames.setdefault(record.trial_id, []).append(record.intervals)
        elif isinstance(record, TimestepSkipped):
            skipped[record.trial_id] = skipped.get(record.trial_id, 0) + 1
    nothing = np.zeros(0)
    rows: list[dict[str, object]] = []
    for trial_id in sorted(session.trials):
        t, late = times.get(trial_id, (nothing, nothing))
        intervals = np.diff(t)
        pictures = np.concatenate(frames[trial_id]) if trial_id in frames else nothing
        late_frames = int(np.count_nonzero(pictures > LATE_PERIODS / refresh_hz))
        own = stated.get(trial_id)
        rows.append(
            {
                **trial_keys(session, trial_id),
                "timesteps": int(t.size),
                "skipped": skipped.get(trial_id, 0),
                "interval_median": _quantile(intervals, 0.5),
                "interval_max": _quantile(intervals, 1.0),
                "late_median": _quantile(late, 0.5),
                "late_p99": _quantile(late, 0.99),
                "late_max": _quantile(late, 1.0),
                "frames": int(pictures.size),
                "frame_median": _quantile(pictures, 0.5),
                "frame_p99": _quantile(pictures, 0.99),
                "frame_max": _quantile(pictures, 1.0),
                "frames_late": late_frames,
                "frames_late_share": late_frames / pictures.size if pictures.size else math.nan,
                "poll_gap_median": own.poll_gap_median if own else math.nan,
                "poll_gap_p99": own.poll_gap_p99 if own else math.nan,
                "poll_gap_max": own.poll_gap_max if own else math.nan,
            }
        )
    return rows


def _times(
    session: Session,
) -> dict[int, tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]]:
    """Return each fleet run's times and latenesses, in seconds and in order of time."""
    parts: dict[int, list[npt.NDArray[np.int64]]] = {}
    for block in timestep_blocks(session):
        trial = block["trial_id"].astype(np.int64)
        pair = np.stack([block["t_ns"].astype(np.int64), block["due_ns"].astype(np.int64)])
        for trial_id in np.unique(trial):
            parts.setdefault(int(trial_id), []).append(pair[:, trial == trial_id])
    found = {}
    for trial_id, pieces in parts.items():
        joined = np.concatenate(pieces, axis=1)
        t, due = joined[:, np.argsort(joined[0], kind="stable")]
        found[trial_id] = (t / 1e9, (t - due) / 1e9)
    return found


def _quantile(values: npt.NDArray[np.float64], level: float) -> float:
    return float(np.quantile(values, level)) if values.size else math.nan
