"""Scorers of other participants, read from their recordings before a session starts."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from study.errors import StudyError
from study.families import load_member
from study.loading import LoadedProtocol
from study.recording.parts import read_session
from study.whatif.sessions import applied_fits

ALGORITHM = "recorded"


def recorded_weights(
    loaded: LoadedProtocol, overrides: Mapping[str, str] | None = None
) -> dict[str, bytes]:
    """Return the weights of each scorer that comes from a recording, by artefact id.

    Args:
        loaded: the protocol.
        overrides: scorer's name to the path of a recording; before what the protocol says.

    Raises:
        StudyError: a recording is not named, cannot be read, holds no such scorer, or one that
            does not fit the protocol's task.
    """
    wanted = dict(overrides or {})
    found = {}
    for name, part in loaded.protocol.scorers.items():
        if part.name != ALGORITHM:
            continue
        given = wanted.pop(name, "") or str(part.parameters.get("recording", ""))
        if not given:
            raise StudyError(
                f"scorers.{name} comes from a recording, and none is named",
                f"Say --scorer {name}=PATH, or set scorers.{name}.parameters.recording.",
            )
        path = Path(given)
        if not path.is_absolute() and not path.is_file():
            path = loaded.path.parent / path
        weights = _weights(path, str(part.parameters.get("scorer", "luce")))
        _check_fits(path, weights, loaded)
        found[f"scorer:{name}"] = weights
    if wanted:
        raise StudyError(
            f'--scorer names "{", ".join(wanted)}", which is no scorer from a recording',
            'Such scorers have name = "recorded" in the protocol.',
        )
    return found


def parse_overrides(given: list[str]) -> dict[str, str]:
    """Return name and path of each "NAME=PATH".

    Raises:
        StudyError: one is not of that form.
    """
    pairs = {}
    for text in given:
        name, equals, path = text.partition("=")
        if not (name and equals and path):
            raise StudyError(f'--scorer "{text}"', "Give the scorer's name and a path: NAME=PATH.")
        pairs[name] = path
    return pairs


def _weights(path: Path, scorer: str) -> bytes:
    if not path.is_file():
        raise StudyError(f"no recording {path}", "Check the path of the other participant's.")
    recording = read_session(path)
    artefact = f"scorer:{scorer}"
    fits = [fit for fit in applied_fits(recording) if fit.artefact_id == artefact]
    if not fits:
        raise StudyError(
            f'{path.name} holds no scorer "{scorer}" that took effect',
            "Check scorers.NAME.parameters.scorer against that session's protocol.",
        )
    return fits[-1].weights


def _check_fits(path: Path, weights: bytes, loaded: LoadedProtocol) -> None:
    """Try a scorer on the protocol's task, as the session will when it needs it."""
    member = load_member("study.scorers", "scorer", ALGORITHM)
    arrays = {member.WEIGHTS: np.frombuffer(weights, np.uint8)}
    try:
        member.fit(arrays, loaded.description, {}, 0)
    except StudyError as error:
        raise StudyError(
            f"{path.name}: {error.message}",
            f"Take a recording of the same task, {loaded.protocol.task.name}.",
        ) from error
