"""What lost records mean for fleet runs: which are broken, which cannot be placed at all."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from analysis.source import RecordingSource
from study.events.events import Deviation, Timestep, TrialEnded
from study.events.fields import Record
from study.recording.losses import Loss


@dataclasses.dataclass(frozen=True, slots=True)
class KnownTrials:
    """A recording without what belongs to fleet runs whose beginning is missing.

    Nobody knows under which condition such a fleet run took place.

    Attributes:
        source: the recording.
        trials: ids of the fleet runs whose beginning is known.
    """

    source: RecordingSource
    trials: frozenset[int]

    @property
    def complete(self) -> bool:
        """Whether the file was finished properly."""
        return self.source.complete

    @property
    def problems(self) -> Sequence[str]:
        """What is wrong with the file, in words."""
        return self.source.problems

    @property
    def losses(self) -> Sequence[Loss]:
        """Which records are missing."""
        return self.source.losses

    @property
    def sha256(self) -> str:
        """SHA-256 of the file, hexadecimal."""
        return self.source.sha256

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """Files kept inside the recording, by name."""
        return self.source.attachments

    def records(self, *topics: str) -> Iterator[tuple[int, Record]]:
        """Yield (sequence, record) of these topics, in the order written."""
        for sequence, record in self.source.records(*topics):
            trial = getattr(record, "trial_id", -1)
            if trial < 0 or trial in self.trials or isinstance(record, Deviation):
                yield sequence, record

    def every_record(self, *topics: str) -> Iterator[tuple[Record, bool]]:
        """Yield records, and whether they belong to the session: a resume leaves some out."""
        return self.source.every_record(*topics)

    def columns(self, topic: str) -> list[dict[str, npt.NDArray[Any]]]:
        """Return a topic's fields as arrays, in blocks with a constant number of robots."""
        known = list(self.trials)
        blocks = []
        for block in self.source.columns(topic):
            if "trial_id" not in block:
                blocks.append(block)
                continue
            kept = (block["trial_id"] < 0) | np.isin(block["trial_id"], known)
            blocks.append({name: values[kept] for name, values in block.items()})
        return blocks


def broken_trials(
    losses: Sequence[Loss], began: Mapping[int, int], over: Mapping[int, int]
) -> tuple[int, ...]:
    """Return the ids of the fleet runs of which records are missing.

    Args:
        losses: what is missing.
        began: sequence number of each fleet run's beginning, by id.
        over: sequence number of its end, by id; absent if that is not recorded.
    """
    return tuple(
        trial
        for trial, first in sorted(began.items())
        if any(loss.overlaps(first, over.get(trial)) for loss in losses)
    )


def unknown_trials(source: RecordingSource, began: Mapping[int, int]) -> dict[int, int]:
    """Return how many timesteps there are of each fleet run whose beginning is missing."""
    counts: Counter[int] = Counter()
    for block in source.columns(Timestep.topic):
        ids, numbers = np.unique(block["trial_id"], return_counts=True)
        counts.update(dict(zip(ids.tolist(), numbers.tolist(), strict=True)))
    for _, record in source.records(TrialEnded.topic):
        if isinstance(record, TrialEnded):
            counts[record.trial_id] += 0
    return {trial: n for trial, n in sorted(counts.items()) if trial >= 0 and trial not in began}
