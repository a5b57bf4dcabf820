"""What of a recording is missing, by its summary and by what was found in it."""

from __future__ import annotations

from collections import Counter

from study.recording import stated
from study.recording.findings import Findings, FoundChunk, count_by_channel
from study.recording.losses import Loss
from study.recording.mcap_summary import Summary

_ENDED_TOPIC = "event/session_ended"


def missing_by_topic(
    findings: Findings, summary: Summary | None, chunks: list[FoundChunk]
) -> dict[str, int] | None:
    """Return how many records are missing by topic; None if there is no summary that says."""
    if summary is None:
        return None
    channels = findings.channels
    missing: Counter[str] = Counter()
    held = count_by_channel(chunks)
    for number, count in summary.by_channel.items():
        if count > held[number]:
            missing[channels.get(number, f"channel {number}")] += count - held[number]
    missing.update(stated.by_topic(findings.metadata))
    return dict(missing)


def missing_end(
    chunks: list[FoundChunk],
    losses: list[Loss],
    findings: Findings,
    missing: dict[str, int] | None,
    *,
    damaged_end: bool,
) -> list[Loss]:
    """Return what is missing after the last chunk, as one loss or none."""
    first = int(chunks[-1].sequence[-1]) + 1 if chunks else 0
    after_ns = chunks[-1].last_ns if chunks else None
    if missing is not None:
        count = sum(missing.values()) - sum(loss.count or 0 for loss in losses)
        if count <= 0:
            return []
        # A later part begins anywhere: without any record of it nothing says where it ended.
        known = chunks or not findings.continues
        return [Loss(first, first + count - 1 if known else None, after_ns, None)]
    channels = findings.channels
    over = findings.ended or (
        bool(chunks) and _ENDED_TOPIC in {channels[number] for number in chunks[-1].by_channel}
    )
    return [] if over and not damaged_end else [Loss(first, None, after_ns, None)]
