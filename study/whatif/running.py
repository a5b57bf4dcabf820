"""What-if over recordings: every scorer asked about every choice, as tables."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence

from study.errors import StudyError
from study.whatif.measuring import (
    Answers,
    TableBuilder,
    add_cells,
    add_choices,
    add_states,
    add_times,
    add_trials,
)
from study.whatif.named_scorers import Asked, asked_scorers, own_scorer
from study.whatif.regret import RegretSettings, add_regret, open_rollouts
from study.whatif.scoring import judge_all, judge_runs
from study.whatif.sessions import ChoiceSession
from study.whatif_files import Columns
from study.whatif_tables import COLUMNS


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Findings:
    """What came out.

    Attributes:
        tables: those of `study.whatif_tables`.
        notes: in words, what could not be done and why.
    """

    tables: dict[str, Columns]
    notes: tuple[str, ...]


def ask(
    sessions: Sequence[ChoiceSession],
    given: Sequence[str],
    *,
    parts: int = 0,
    regret: RegretSettings | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Findings:
    """Ask scorers about all choices of some sessions.

    Args:
        sessions: of one task; at least one.
        given: names and files of scorers; see `study.whatif.named_scorers`.
        parts: in how many parts own scorers are cross-validated; 0 for not at all.
        regret: how choices are rolled out; None for not at all.
        progress: takes what is being done, in a few words.

    Raises:
        StudyError: the tasks differ, nobody chose anything, or a scorer cannot be used.
    """
    from threadpoolctl import threadpool_limits  # noqa: PLC0415 - of many small products

    _check(sessions)
    # Threads of one small product wait for one another longer than they multiply.
    with threadpool_limits(limits=1):
        return _ask(sessions, given, parts, regret, progress)


def _ask(
    sessions: Sequence[ChoiceSession],
    given: Sequence[str],
    parts: int,
    regret: RegretSettings | None,
    progress: Callable[[str], None],
) -> Findings:
    notes: list[str] = []

    def note(text: str) -> None:
        if text not in notes:
            notes.append(text)

    progress("Fetching scorers")
    asked = asked_scorers(given, sessions, parts, note)
    owners = [own_scorer(session, note) for session in sessions]
    tables = {name: TableBuilder(name) for name in COLUMNS}
    _add_recordings(tables["recordings"], sessions)
    _add_scorers(tables["scorers"], sessions, asked, owners)
    progress("Asking scorers")
    answers: list[list[Answers]] = []
    for session, mine in zip(sessions, asked, strict=True):
        answers.append([_answers(each, session) for each in mine])
        for one in answers[-1]:
            add_choices(tables["choices"], one)
            add_trials(tables["trials"], one)
        for group in _by_name(answers[-1]):
            add_states(tables["states"], group)
            add_times(tables["times"], group)
    progress("Asking each participant's scorer about the others' choices")
    validated = [_validated(mine) for mine in answers]
    _add_matrix(tables["matrix"], sessions, owners, validated)
    if regret is not None:
        for session, mine_answers in zip(sessions, answers, strict=True):
            progress(f"Rolling out {session.participant}'s alternatives")
            rollouts = open_rollouts(session, regret, note)
            if rollouts is not None:
                add_regret(tables["regret"], rollouts, mine_answers, note)
    return Findings({name: table.columns for name, table in tables.items()}, tuple(notes))


def _check(sessions: Sequence[ChoiceSession]) -> None:
    fields = {session.task.state_fields for session in sessions}
    if len(fields) > 1:
        raise StudyError(
            "the recordings' tasks differ in the numbers that make up a state",
            "Give the recordings of one task.",
        )
    if not any(session.runs for session in sessions):
        raise StudyError(
            "these recordings hold no choice of an operator's own among two or more robots",
            "Give recordings of a study in which people chose robots by hand.",
        )


def _answers(asked: Asked, session: ChoiceSession) -> Answers:
    runs = [
        run
        for run in session.runs
        if asked.trials is None or (run.trial_id in asked.trials and session.fitted(run).any())
    ]
    # Cross-validation is of what was fitted to, and of nothing else.
    keep = [run.rows >= 0 if asked.trials is None else session.fitted(run) for run in runs]
    return Answers(asked, session, runs, judge_runs(asked.scorer, runs) if runs else [], keep)


def _by_name(answers: Sequence[Answers]) -> list[Answers]:
    """Join what the parts of a cross-validated scorer say, each of its own fleet runs."""
    found: dict[str, Answers] = {}
    for one in answers:
        before = found.get(one.asked.name)
        if before is None:
            found[one.asked.name] = one
        else:
            found[one.asked.name] = dataclasses.replace(
                before,
                runs=[*before.runs, *one.runs],
                judged=[*before.judged, *one.judged],
                keep=[*before.keep, *one.keep],
            )
    return list(found.values())


def _validated(answers: Sequence[Answers]) -> Answers | None:
    """Return what a participant's own scorer says of choices held out from it, in turn."""
    held_out = [one for one in answers if one.asked.trials is not None]
    return _by_name(held_out)[0] if held_out else None


def _add_matrix(
    table: TableBuilder,
    sessions: Sequence[ChoiceSession],
    owners: Sequence[Asked | None],
    validated: Sequence[Answers | None],
) -> None:
    known = [owner for owner in owners if owner is not None]
    for session, held_out in zip(sessions, validated, strict=True):
        if not session.runs:
            continue
        judged = judge_all([owner.scorer for owner in known], session.runs)
        keep = [run.rows >= 0 for run in session.runs]
        for owner, one in zip(known, judged, strict=True):
            answers = Answers(owner, session, session.runs, one, keep)
            if held_out is not None and owner.fitted_to == session.participant:
                add_cells(table, owner.fitted_to, held_out, (True,))
                add_cells(table, owner.fitted_to, answers, (False,))
            else:
                add_cells(table, owner.fitted_to, answers)


def _add_recordings(table: TableBuilder, sessions: Sequence[ChoiceSession]) -> None:
    for session in sessions:
        for file, digest in session.files:
            table.add(
                1,
                participant=session.participant,
                session=session.opened.session_id,
                file=file,
                sha256=digest,
                protocol_sha256=session.opened.protocol_sha256,
                choices=sum(len(run.chosen) for run in session.runs),
            )


def _add_scorers(
    table: TableBuilder,
    sessions: Sequence[ChoiceSession],
    asked: Sequence[Sequence[Asked]],
    owners: Sequence[Asked | None],
) -> None:
    listed: set[tuple[str, str, str]] = set()
    for session, mine, owner in zip(sessions, asked, owners, strict=True):
        for one in [*mine, *([owner] if owner else [])]:
            # What everyone's choices were held against is one scorer, and one row.
            common = one.origin == "file" or not one.fitted_to
            whose = "" if common else session.participant
            key = (one.name, whose, one.sha256)
            if key in listed:
                continue
            listed.add(key)
            table.add(
                1,
                scorer=one.name,
                participant=whose,
                fitted_to=one.fitted_to,
                origin=one.origin,
                algorithm=one.algorithm,
                weights_sha256=one.sha256,
                source=one.source,
                source_sha256=one.source_sha256,
            )
