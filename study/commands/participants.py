"""`study participants`: show and edit who takes part."""

from __future__ import annotations

import dataclasses
import json
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from study.commands.enrolling import BY_HAND, tell_out_of_reach
from study.commands.kept_folder import check_kept
from study.commands.participants_table import participants_tables
from study.commands.terminal import console, errors
from study.enrolment import editing
from study.enrolment.files import files_in_words, out_of_reach
from study.enrolment.importing import bring_in_step
from study.enrolment.participants import HOLDING, Participant
from study.enrolment.pseudonyms import PARTICIPANT
from study.enrolment.register import Register
from study.enrolment.withdrawing import to_be_erased, withdraw
from study.errors import StudyError
from study.loading import find_protocol, load_protocol
from study.output_option import folder_wanted
from study.preflight_result import forget_rehearsed

ACTIONS = (
    "exclude",
    "drop",
    "restore",
    "mark-pilot",
    "unmark-pilot",
    "release",
    "note",
    "history",
    "withdraw",
)
_NEED_REASON = ("exclude", "drop", "note")
_TAKE_REASON = (*_NEED_REASON, "restore", "mark-pilot", "unmark-pilot")


def participants(
    words: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[ACTION PSEUDONYM] [WHERE]",
            help=f"ACTION: {', '.join(ACTIONS)}. PSEUDONYM: of the one it is done with. "
            "WHERE: folder of recordings, or protocol.",
        ),
    ] = None,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            callback=folder_wanted,
            help="Folder of the recordings, for a protocol.",
        ),
    ] = Path("recordings"),
    reason: Annotated[str, typer.Option(help="Why, for the history; the text of a note.")] = "",
    yes: Annotated[  # noqa: FBT002
        bool, typer.Option("--yes", help="Withdraw without being asked.")
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Show as JSON.")] = False,  # noqa: FBT002
) -> None:
    """Show who takes part, in which slot and order, and how it went; or change one of them.

    A folder's register is brought in step with its recordings first, or made
    from them. `withdraw` erases a participant's data and keeps a tombstone.
    """
    action, pseudonym, where = _parsed(words or [])
    if reason and action not in _TAKE_REASON:
        raise StudyError(
            f"--reason with {action or 'no action'}: there is nowhere to keep it",
            f"Leave it out, or say it with one of: {', '.join(_TAKE_REASON)}.",
        )
    study, folder = _place(where, output)
    check_kept(folder)
    with Register(folder) as register:
        added = bring_in_step(register)
        if added:
            errors.print(f"Taken from recordings and tombstones: {added}.")
        if not action:
            _show(register.participants(study), as_json=as_json)
            return
        known = _one(register, study, pseudonym, action)
        if action in _NEED_REASON and not reason.strip():
            raise StudyError(f"{action} needs words", 'Give them with --reason "...", no names.')
        if action == "withdraw":
            _withdraw(register, known, yes=yes)
        elif action == "history":
            _show_history(register, known, as_json=as_json)
        else:
            _edit(register, known, action, " ".join(reason.split()))


def _parsed(words: list[str]) -> tuple[str, str, str]:
    """Return action, pseudonym and place; each empty if not given."""
    action = next((word for word in words if word in ACTIONS), "")
    # A protocol may be called as an action is; alone it is asked for nothing but to be shown.
    if words and words[0] != action:
        if action:
            raise _misplaced(action, [word for word in words if word is not action])
        if len(words) > 1:
            raise StudyError(
                f'"{words[0]}" is nothing that can be done with participants',
                f"Known: {', '.join(ACTIONS)}.",
            )
        return "", "", words[0]
    if not words:
        return "", "", ""
    if not 2 <= len(words) <= 3:
        raise StudyError(
            f"{action} needs one pseudonym", f"Say: study participants {action} PSEUDONYM [WHERE]"
        )
    if len(words) == 2 and Path(words[1]).is_dir():
        raise StudyError(
            f"{action} needs a pseudonym, and {words[1]} is a folder",
            f"Say: study participants {action} PSEUDONYM {words[1]}",
        )
    if len(words) == 3 and _is_place(words[1]) and not _is_place(words[2]):
        raise _misplaced(action, words[1:])
    return action, words[1], words[2] if len(words) > 2 else ""


def _misplaced(action: str, others: list[str]) -> StudyError:
    """Return the refusal of words in another order, which gives the right one."""
    places = [word for word in others if _is_place(word)]
    names = [word for word in others if word not in places]
    right = shlex.join([action, *(names or ["PSEUDONYM"]), *places])
    return StudyError(
        "first what is to be done, then with whom, then where", f"Say: study participants {right}"
    )


def _is_place(word: str) -> bool:
    """Whether a word is a folder or a protocol."""
    if Path(word).is_dir():
        return True
    try:
        find_protocol(word)
    except StudyError:
        return False
    return True


def _place(where: str, output: Path) -> tuple[str, Path]:
    """Return the study meant, empty for all, and the folder of the recordings."""
    if not where:
        return "", output
    if Path(where).is_dir():
        return "", Path(where)
    if not _is_place(where):
        raise StudyError(
            f'no folder "{where}", and no protocol of that name',
            "Give the folder of the recordings.",
        )
    return load_protocol(where).protocol.study.name, output


def _one(register: Register, study: str, pseudonym: str, action: str) -> Participant:
    if not PARTICIPANT.fullmatch(pseudonym):
        raise StudyError(f'"{pseudonym[:60]}" is no pseudonym', "Give one such as P01.")
    of_all = register.participants(study)
    found = [each for each in of_all if each.pseudonym.casefold() == pseudonym.casefold()]
    if not found:
        raise StudyError(
            f'no participant "{pseudonym}" in {register.path}', "`study participants` lists them."
        )
    if len(found) > 1:
        folder = register.folder
        raise StudyError(
            f'"{pseudonym}" takes part in {" and ".join(each.study for each in found)}',
            "Say in which, by its protocol, and give the folder with -o: study participants "
            + shlex.join([action, found[0].pseudonym, _protocol_of(found), "-o", str(folder)]),
        )
    return found[0]


def _protocol_of(found: list[Participant]) -> str:
    """Return a study that is called as its protocol is; else what stands for one."""
    return next((each.study for each in found if _is_place(each.study)), "PROTOCOL")


def _edit(register: Register, known: Participant, action: str, text: str) -> None:
    match action:
        case "exclude":
            editing.mark(register, known, "excluded", text)
        case "drop":
            editing.mark(register, known, "dropped", text)
        case "restore":
            editing.restore(register, known, text)
        case "mark-pilot" | "unmark-pilot":
            editing.set_pilot(register, known, text, pilot=action == "mark-pilot")
        case "note":
            editing.note(register, known, text)
            console.print(f"{known.pseudonym}: noted; `study participants history` shows it.")
            return
        case _:
            register.release(known.study, known.pseudonym)
            forget_rehearsed(register.folder, known.pseudonym)
    now = register.find(known.study, known.pseudonym)
    if now is None:
        console.print(f"{known.pseudonym}: the slot is free; nothing is kept.")
    else:
        place = f", slot {now.slot}" if now.state in HOLDING else ""
        pilot = ", pilot" if now.pilot else ""
        console.print(f"{now.pseudonym}: {now.shown_state}{place}{pilot}.")


def _withdraw(register: Register, known: Participant, *, yes: bool) -> None:
    for path in to_be_erased(register, known):
        inside = path.resolve().is_relative_to(register.folder.resolve())
        outside = "" if inside else f" (not in {register.folder})"
        console.print(f"To be erased: {escape(str(path) + outside)}")
    if not yes:
        if not sys.stdin.isatty():
            raise StudyError("nobody can be asked here", "Say --yes to erase without being asked.")
        confirm(f"Erase all data of {known.pseudonym} for good?")
    erased = withdraw(register, known.study, known.pseudonym)
    missed = out_of_reach(register, known.study, known.pseudonym)
    console.print(
        f"{known.pseudonym} withdrew, and {'these' if missed else 'all'} data were erased: "
        f"{escape(files_in_words(erased))}. A tombstone is kept: pseudonym and time."
    )
    tell_out_of_reach(missed)
    errors.print(BY_HAND)


def _show(found: list[Participant], *, as_json: bool) -> None:
    if as_json:
        rows = [
            {
                **{key: value for key, value in dataclasses.asdict(each).items() if key != "lease"},
                "state": each.shown_state,
                "visits": each.sessions,
                "slot": each.slot if each.state in HOLDING else None,
            }
            for each in found
        ]
        sys.stdout.write(json.dumps(rows, indent=2) + "\n")
        return
    if not found:
        console.print("No participants yet.")
        return
    for number, table in enumerate(participants_tables(found, console.width)):
        if number:
            console.print()
        console.print(table)


def confirm(question: str) -> None:
    """Ask; go on only after a yes. Ctrl-C is the same here as anywhere."""
    try:
        agreed = typer.confirm(question)
    except typer.Abort as error:
        raise KeyboardInterrupt from error
    if not agreed:
        console.print("Nothing was erased.")
        raise typer.Exit(1)


def _show_history(register: Register, known: Participant, *, as_json: bool) -> None:
    lines = register.history(known.study, known.pseudonym)
    if as_json:
        text = json.dumps([dataclasses.asdict(line) for line in lines], indent=2)
        sys.stdout.write(f"{text}\n")
        return
    if not lines:
        state = (
            f"withdrew at {known.changed_utc[:19]}" if known.state == "withdrawn" else "no history"
        )
        console.print(f"{known.pseudonym}: {state}; nothing else is kept.", markup=False)
    for line in lines:
        detail = f": {line.detail}" if line.detail else ""
        console.print(f"{line.utc[:19]}  {line.what}{detail}", markup=False)
