"""Which scorers are asked: by the names and files that a user gives."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np

from study.errors import StudyError, UnknownNameError
from study.families import known_members, load_member
from study.recording.parts import read_session
from study.scorers._threads import use_one_thread
from study.scorers.base import Scorer
from study.seeding import stream_seed
from study.whatif.fitting import LazyChoices, parts_of_trials, refit, scorer_part
from study.whatif.sessions import AppliedFit, ChoiceSession, applied_fits

OWN = "own"
PREFIX = "scorer:"
MAX_WEIGHTS_BYTES = 50_000_000

Origin = Literal["recorded", "fitted", "cross_validated", "control", "file"]
Note = Callable[[str], None]


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """One scorer that is asked about the choices of a participant.

    Attributes:
        name: what it is called.
        scorer: what answers.
        origin: where its weights come from.
        algorithm: name of the member.
        sha256: of its weights.
        fitted_to: whose choices it was fitted to; empty if to nobody's.
        source, source_sha256: the file that the weights come from; empty if fitted here.
        log_odds: whether its scores are Luce's phi, so that a choice has a likelihood.
        trials: which fleet runs it is asked about; None for all.
    """

    name: str
    scorer: Scorer
    origin: Origin
    algorithm: str
    sha256: str
    fitted_to: str = ""
    source: str = ""
    source_sha256: str = ""
    log_odds: bool = True
    trials: frozenset[int] | None = None


def own_fit(session: ChoiceSession) -> AppliedFit | None:
    """Return the fitted scorer that phase three used, or else the last; None if there is none."""
    fits = [
        fit
        for fit in session.fits
        if fit.kind == "scorer" and not getattr(_member(fit.algorithm), "IS_CONTROL", False)
    ]
    order = session.opened.order
    conditions = session.protocol.get("conditions", [])
    used = {
        PREFIX + str(part.get("scorer", ""))
        for part in conditions
        if isinstance(part, dict) and part.get("name") in order
    }
    chosen = [fit for fit in fits if fit.artefact_id in used] or fits
    return chosen[-1] if chosen else None


def own_scorer(session: ChoiceSession, note: Note) -> Asked | None:
    """Return a participant's own scorer as recorded; None, and a note, if there is none."""
    fit = own_fit(session)
    if fit is None:
        note(f"{session.participant}: the recording holds no scorer fitted to their choices.")
        return None
    return _recorded(OWN, session, fit)


def asked_scorers(
    given: Sequence[str], sessions: Sequence[ChoiceSession], parts: int, note: Note
) -> list[list[Asked]]:
    """Return who is asked about each session's choices.

    Args:
        given: names and files, each may have a name of its own before "=".
        sessions: of one task.
        parts: in how many parts of its trials an own scorer is cross-validated; 0 for not.
        note: takes what could not be done, in words.

    Raises:
        StudyError: a name or file is unknown or of no use for this task.
    """
    asked: list[list[Asked]] = [[] for _ in sessions]
    for text in dict.fromkeys(given):
        name, path = _as_file(text)
        if path:
            common = _from_file(name, path, sessions[0])
            for mine in asked:
                mine.append(common)
            continue
        found = False
        for session, mine in zip(sessions, asked, strict=True):
            one = _by_name(text, session, note)
            found |= one is not None
            mine.extend([one] if one else [])
        if not found and text != OWN and text not in _members():
            raise UnknownNameError("scorer", text, [OWN, *_members(), *_recorded_names(sessions)])
    if parts:
        for session, mine in zip(sessions, asked, strict=True):
            mine.extend(_cross_validated(session, parts, note))
    for mine in asked:
        names = [each.name for each in mine if each.trials is None]
        if len(set(names)) < len(names):
            twice = next(name for name in names if names.count(name) > 1)
            raise StudyError(
                f'two scorers are called "{twice}"', "Name one yourself: --scorer NAME=FILE."
            )
    return asked


def _by_name(name: str, session: ChoiceSession, note: Note) -> Asked | None:
    if name == OWN:
        return own_scorer(session, note)
    fit = session.fit(PREFIX + name)
    if fit is not None:
        return _recorded(name, session, fit)
    if name not in _members():
        return None
    module = load_member("study.scorers", "scorer", name)
    control = bool(getattr(module, "IS_CONTROL", False))
    if not control:
        use_one_thread()
    data = LazyChoices(session)
    parameters = scorer_part(session, name).get("parameters", {})
    try:
        weights = module.fit(
            data, session.task, parameters, stream_seed(session.opened.seed, f"what if {name}")
        ).weights
    except StudyError as error:
        note(f"{session.participant}: {name} was not fitted: {error.message}.")
        return None
    return Asked(
        name=name,
        scorer=module.load(weights, session.task),
        origin="fitted" if data.used else "control",
        algorithm=name,
        sha256=hashlib.sha256(weights).hexdigest(),
        fitted_to=session.participant if data.used else "",
        log_odds=not control,
    )


def _recorded(name: str, session: ChoiceSession, fit: AppliedFit) -> Asked:
    module = _member(fit.algorithm)
    control = bool(getattr(module, "IS_CONTROL", False))
    file, digest = session.files[0]
    return Asked(
        name=name,
        scorer=_loaded(module, fit.weights, session, file),
        origin="recorded",
        algorithm=fit.algorithm,
        sha256=fit.sha256,
        # A control learns nothing of the operator; one from a recording is another's.
        fitted_to="" if control and fit.algorithm != "novelty" else session.participant,
        source=file,
        source_sha256=digest,
        log_odds=not control or fit.algorithm == "recorded",
    )


def _cross_validated(session: ChoiceSession, parts: int, note: Note) -> Iterator[Asked]:
    fit = own_fit(session)
    if fit is None:
        return
    data = LazyChoices(session)
    groups = parts_of_trials(data["trials"], parts)
    if len(groups) < 2:
        note(f"{session.participant}: fewer than two trials of choices; nothing to hold out.")
        return
    for trials in groups:
        kept = ~np.isin(data["trials"], sorted(trials))
        weights = refit(session, fit, {name: data[name][kept] for name in data})
        module = _member(fit.algorithm)
        yield Asked(
            name=f"{OWN}, cross-validated",
            scorer=module.load(weights, session.task),
            origin="cross_validated",
            algorithm=fit.algorithm,
            sha256=hashlib.sha256(weights).hexdigest(),
            fitted_to=session.participant,
            trials=trials,
        )


def _as_file(text: str) -> tuple[str, str]:
    """Return name and path of what names a file; an empty path if it names a scorer."""
    name, equals, rest = text.partition("=")
    path = rest if equals else text
    if not (name and path):
        raise StudyError(f'--scorer "{text}"', "Give a scorer's name, a file, or NAME=FILE.")
    if equals or "/" in path or path.split("#")[0].endswith((".mcap", ".safetensors")):
        stem = Path(path.split("#")[0]).stem
        return (name if equals else stem), path
    return name, ""


def _from_file(name: str, given: str, session: ChoiceSession) -> Asked:
    """Return the scorer that a recording or a file of weights holds."""
    text, _, wanted = given.partition("#")
    path = Path(text)
    if not path.is_file():
        raise StudyError(f"no file {path}", "Give a recording (*.mcap) or weights (*.safetensors).")
    if path.suffix != ".mcap":
        if path.stat().st_size > MAX_WEIGHTS_BYTES:
            raise StudyError(f"{path}: weights have at most {MAX_WEIGHTS_BYTES} bytes")
        weights = path.read_bytes()
        digest = hashlib.sha256(weights).hexdigest()
        scorer = _loaded(_member("recorded"), weights, session, path.name)
        return Asked(name, scorer, "file", "recorded", digest, "", path.name, digest)
    recording = read_session(path)
    fits = {fit.artefact_id: fit for fit in applied_fits(recording) if fit.kind == "scorer"}
    names = sorted(key.removeprefix(PREFIX) for key in fits)
    if wanted or len(names) == 1:
        fit = fits.get(PREFIX + (wanted or names[0]))
        if fit is None:
            raise UnknownNameError("scorer", wanted, names)
    else:
        raise StudyError(
            f"{path.name} holds {len(names)} scorers that took effect",
            f"Name one: {path.name}#NAME, of {', '.join(names)}."
            if names
            else "Give a recording in which a scorer was fitted.",
        )
    opened = next(iter(recording.records("input/session_opened")))[1]
    module = _member(fit.algorithm)
    return Asked(
        name=name,
        scorer=_loaded(module, fit.weights, session, path.name),
        origin="file",
        algorithm=fit.algorithm,
        sha256=fit.sha256,
        fitted_to=str(getattr(opened, "participant", "")),
        source=path.name,
        source_sha256=recording.sha256,
        log_odds=not getattr(module, "IS_CONTROL", False) or fit.algorithm == "recorded",
    )


def _loaded(module: Any, weights: bytes, session: ChoiceSession, source: str) -> Scorer:  # noqa: ANN401 - a member's module
    """Return a scorer, tried on a state of this task.

    Raises:
        StudyError: the weights are none, or are of another task's states.
    """
    state = np.zeros((1, len(session.task.state_fields)), np.float32)
    try:
        scorer: Scorer = module.load(weights, session.task)
        numbers = scorer.scores(state)
        if numbers.shape != (1,) or not np.isfinite(numbers).all():
            raise ValueError("it gives no finite score for a state")
    except Exception as error:
        raise StudyError(
            f"{source}: its weights are no scorer of the task {session.task.name}: {error}",
            "Give weights that were fitted to choices in this task.",
        ) from error
    return scorer


def _members() -> list[str]:
    return [name for name in known_members("study.scorers") if name != "recorded"]


def _member(name: str) -> Any:  # noqa: ANN401 - a member's module
    return load_member("study.scorers", "scorer", name)


def _recorded_names(sessions: Sequence[ChoiceSession]) -> list[str]:
    names = {
        fit.artefact_id.removeprefix(PREFIX)
        for session in sessions
        for fit in session.fits
        if fit.kind == "scorer"
    }
    return sorted(names - set(_members()))
