"""What a file's metadata state of it: above all, what a salvage could not save."""

from __future__ import annotations

import json
from typing import Any, TypeVar

from study.errors import RecordingError
from study.recording import losses as loss_text
from study.recording.identity import SALVAGED_BY_TOPIC, SALVAGED_LOSSES, SALVAGED_PROBLEMS
from study.recording.losses import Loss
from study.recording.mcap_records import DamagedError

_Stated = TypeVar("_Stated", dict[str, Any], list[Any])


def pairs(text: str) -> tuple[tuple[int, int], ...]:
    """Return the (first, last) pairs that a text states.

    Raises:
        DamagedError: it states something else.
    """
    try:
        return tuple((int(first), int(last)) for first, last in json.loads(text))
    except (ValueError, TypeError, OverflowError, RecursionError) as error:
        raise DamagedError("its metadata are unreadable") from error


def losses(metadata: dict[str, str]) -> tuple[Loss, ...]:
    """Return the losses stated by the salvage that made the file."""
    return loss_text.from_json(metadata.get(SALVAGED_LOSSES, "[]"))


def by_topic(metadata: dict[str, str]) -> dict[str, int]:
    """Return how many records of each topic the salvage missed."""
    found = json_value(metadata, SALVAGED_BY_TOPIC, {})
    return {topic: count for topic, count in found.items() if type(count) is int}


def problems(metadata: dict[str, str]) -> list[str]:
    """Return the problems that the salvage found."""
    return [str(problem) for problem in json_value(metadata, SALVAGED_PROBLEMS, [])]


def json_value(metadata: dict[str, str], key: str, default: _Stated) -> _Stated:
    """Return what metadata state under a key, of the type of `default`.

    Raises:
        RecordingError: they state something else.
    """
    try:
        stated = json.loads(metadata[key]) if key in metadata else default
    except (ValueError, RecursionError):
        stated = None
    if not isinstance(stated, type(default)):
        raise RecordingError(
            f'the metadata "{key}" are unreadable', "Give the file that it was made from."
        )
    return stated
