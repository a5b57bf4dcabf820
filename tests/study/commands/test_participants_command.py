"""`study participants` as a user meets it."""

from __future__ import annotations

import json
import shlex
import subprocess
from io import StringIO
from pathlib import Path

import pytest
import typer
from rich.console import Console
from typer.testing import CliRunner

from command_line import study
from study.commands import main
from study.commands.participants import confirm
from study.commands.participants_table import participants_tables
from study.commands.resuming import find_boundary
from study.commands.simulating import simulate_session, simulated_assignments
from study.enrolment.register import Register
from study.enrolment.withdrawing import leave_tombstone
from study.errors import StudyError
from study.loading import load_protocol

ORDERS = [("manual", "assisted"), ("assisted", "manual")]


def participants(*words: str | Path) -> subprocess.CompletedProcess[str]:
    """Run the command."""
    return study("participants", *words, environment={"COLUMNS": "140", "NO_COLOR": "1"})


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A register with one complete participant of the protocol "pilot", and one of another."""
    with Register(tmp_path) as register:
        for name in ("pilot", "other"):
            register.reserve(name, ORDERS, pseudonym=f"{name}1")
            register.start(name, f"{name}1")
            register.finish(name, f"{name}1", "complete")
    return tmp_path


def test_a_folder_and_a_protocol(folder: Path) -> None:
    """A folder shows all; a protocol, also one that is called as a mark, shows its study."""
    shown = participants(folder)
    assert "pilot1" in shown.stdout
    assert "other1" in shown.stdout
    assert "pilot: 1 x manual, assisted" in shown.stdout
    rows = json.loads(participants("pilot", "-o", folder, "--json").stdout)
    assert [(row["pseudonym"], row["state"], row["slot"]) for row in rows] == [
        ("pilot1", "complete", 1)
    ]


def test_a_table_for_each_study(folder: Path) -> None:
    """Each is headed by its study's name alone, so that slot 1 of both can be told apart."""
    lines = participants(folder).stdout.splitlines()
    headings = [line.strip() for line in lines]
    other, pilot = headings.index("other"), headings.index("pilot")
    assert other < pilot
    assert any("other1" in line for line in lines[other:pilot])
    assert not any("pilot1" in line for line in lines[:pilot])
    assert "pilot: 1 x" not in "".join(lines[:pilot])


def test_the_table_uses_the_words_of_the_json(folder: Path) -> None:
    """Headings are the JSON's keys, but for those that the guide names."""
    participants("exclude", "pilot1", folder, "--reason", "fell ill")
    shown = participants(folder).stdout
    (row,) = json.loads(participants("pilot", "-o", folder, "--json").stdout)
    named = {"visits": "sessions", "changed_utc": "changed, UTC", "reason": "remarks"}
    for key in ("slot", "pseudonym", "state", "order", *named):
        assert key in row
        assert f" {named.get(key, key)} " in shown
    assert "since" not in shown
    guide = Path("docs/how-to/enrol-participants.md").read_text(encoding="utf-8")
    assert all(f"`{key}`" in guide for key in named)


@pytest.mark.parametrize("width", [70, 80, 140])
def test_pseudonyms_are_whole_at_every_width(tmp_path: Path, width: int) -> None:
    """The longest there can be, in the narrowest terminal; other columns wrap or are left out."""
    longest = "P-2026-" + "0123456789" * 2 + "-abcd"
    with Register(tmp_path) as register:
        for name in (longest, "P03"):
            register.reserve("pilot", ORDERS, pseudonym=name)
            register.start("pilot", name)
            register.finish("pilot", name, "complete")
    shown = study("participants", tmp_path, environment={"COLUMNS": str(width)}).stdout
    assert len(longest) == 32
    assert f" {longest} " in shown
    assert "complete" in shown
    assert "\N{HORIZONTAL ELLIPSIS}" not in shown
    assert ("changed" in shown) == (width == 140)
    assert max(len(line) for line in shown.splitlines()) <= width


@pytest.mark.parametrize("remark", ["", "stopped by the participant"], ids=["bare", "remarks"])
def test_dates_are_not_broken_over_lines(tmp_path: Path, remark: str) -> None:
    """From wide to narrow: day and time, the day, no column; in each a row has one of them."""
    with Register(tmp_path) as register:
        for name in ("P4KX9R", "P2ABCD"):
            register.reserve("pilot", ORDERS, pseudonym=name)
            register.start("pilot", name)
            register.finish("pilot", name, "dropped" if remark else "complete", remark)
        found = register.participants()
    seen = set()
    for width in range(60, 141):
        shown = StringIO()
        Console(file=shown, width=width).print(*participants_tables(found, width))
        lines = shown.getvalue().splitlines()
        assert max(map(len, lines)) <= width
        day, minute = found[0].changed_utc[:10], found[0].changed_utc[11:16]
        if "changed, UTC" not in shown.getvalue():
            seen.add("none")
            assert day not in shown.getvalue()
            continue
        (row,) = [line for line in lines if "P4KX9R" in line]
        seen.add("time" if f" {day} {minute} " in row else "day")
        assert f" {day} " in row
        assert sum(day in line for line in lines) == len(found)
        if width == 80:
            assert (f"{day} {minute}" in row) == (not remark)
    assert seen == {"time", "day", "none"}


@pytest.mark.parametrize("remark", ["", "stopped by the participant"], ids=["bare", "remarks"])
def test_condition_names_are_not_broken(tmp_path: Path, remark: str) -> None:
    """However long: at every width that has room for one; the table is never wider than that."""
    names = ("manual_with_all_tiles_shown", "assisted_by_the_trained_scorer")
    with Register(tmp_path) as register:
        register.reserve("pilot", [names], pseudonym="P01")
        register.start("pilot", "P01")
        register.finish("pilot", "P01", "dropped" if remark else "complete", remark)
        found = register.participants()
    for width in range(76 if remark else 70, 141):
        shown = StringIO()
        Console(file=shown, width=width).print(*participants_tables(found, width))
        rows, _, below = shown.getvalue().partition("pilot: ")
        assert below
        assert all(name in rows for name in names)
        assert max(map(len, rows.splitlines())) <= width
        if not remark and width >= 130:
            assert ", ".join(names) in rows


def test_a_reserved_slot_is_no_session_yet(tmp_path: Path) -> None:
    """Neither in the table nor in the JSON; another session that is reserved is not counted."""
    with Register(tmp_path) as register:
        register.reserve("pilot", ORDERS, pseudonym="P01")
        register.reserve("pilot", ORDERS, pseudonym="P02")
        register.start("pilot", "P02")
        register.finish("pilot", "P02", "complete")
        register.reserve("pilot", ORDERS, pseudonym="P02", again=True)
    rows = json.loads(participants(tmp_path, "--json").stdout)
    assert {row["pseudonym"]: row["visits"] for row in rows} == {"P01": 0, "P02": 1}
    cells = [
        line.split("\N{BOX DRAWINGS LIGHT VERTICAL}")
        for line in participants(tmp_path).stdout.splitlines()
        if " P0" in line
    ]
    assert {cell[2].strip(): cell[5].strip() for cell in cells} == {"P01": "0", "P02": "1"}


def test_marks_and_history(folder: Path) -> None:
    """Each edit says what it led to, and the history has it with its reason."""
    assert "excluded" in participants("exclude", "pilot1", folder, "--reason", "fell  ill").stdout
    restored = participants("restore", "pilot1", folder, "--reason", "it was another")
    assert "complete, slot 1" in restored.stdout
    assert "pilot" in participants("mark-pilot", "pilot1", folder).stdout
    participants("unmark-pilot", "pilot1", folder, "--reason", "a slip")
    history = participants("history", "pilot1", folder).stdout
    assert [line.split("  ", 1)[1] for line in history.splitlines()] == [
        "reserved: slot 1, order manual,assisted",
        "running",
        "complete",
        "excluded: fell ill",
        "complete: restored by hand: it was another",
        "marked: a pilot; now in pilot slot 1",
        "marked: no pilot: a slip; now in slot 1",
    ]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["exclude", "pilot1"], "exclude needs words"),
        (["drop"], "drop needs one pseudonym"),
        (["fly", "pilot1"], "nothing that can be done"),
        (["drop", "nobody", "--reason", "x"], 'no participant "nobody"'),
        (["drop", "Anna Smith", "--reason", "x"], "is no pseudonym"),
        (["release", "pilot1"], "not reserved"),
        (["restore", "pilot1"], "no mark can be taken back"),
        (["withdraw", "pilot1"], "nobody can be asked"),
        (["nowhere.toml"], "nowhere.toml"),
        (["withdraw", "pilot1", "--yes", "--reason", "x"], "nowhere to keep it"),
        (["release", "pilot1", "--reason", "x"], "nowhere to keep it"),
        (["pilot", "--reason", "x"], "--reason with no action"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_what_is_refused(folder: Path, words: list[str], message: str) -> None:
    """One message, and nothing has changed."""
    done = CliRunner().invoke(main.app, ["participants", *words, "-o", str(folder)])
    assert isinstance(done.exception, StudyError)
    assert message in str(done.exception)
    with Register(folder) as register:
        assert {each.state for each in register.participants()} == {"complete"}


@pytest.mark.parametrize(
    "words",
    [["-o", "none"], ["none"], ["history", "P01", "none"], ["smoke", "-o", "none"]],
    ids=" ".join,
)
def test_a_folder_that_is_not_there(tmp_path: Path, words: list[str]) -> None:
    """It is called a missing folder, and none is made by looking."""
    done = study("participants", *words, folder=tmp_path)
    assert done.returncode == 2
    assert "no folder" in done.stderr
    assert "none" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_nobody_s_session_broke_off(folder: Path) -> None:
    """Where there is a register, resuming says who could be meant: nobody."""
    done = study("run", "pilot", "--resume", "-o", folder)
    assert done.returncode == 2
    assert "broke off or was ended early" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ["participants", "."],
        ["participants", "history", "P01", "."],
        ["run", "smoke", "--resume", "-o", "."],
        ["run", "smoke", "--resume", "-p", "P01", "-o", "."],
        ["run", "smoke", "--resume", "-o", "none"],
    ],
    ids=" ".join,
)
def test_a_folder_of_nothing_gets_no_register(tmp_path: Path, words: list[str]) -> None:
    """A folder of something else stays as it was, and is said to be none of a study."""
    (tmp_path / "holiday.txt").write_text("")
    done = study(*words, folder=tmp_path)
    assert done.returncode == 2
    there = words[-1] == "."
    assert ("holds neither a register of participants nor" in done.stderr) == there
    assert ("no folder none: it is not there" in done.stderr) == (not there)
    assert [path.name for path in tmp_path.iterdir()] == ["holiday.txt"]


@pytest.mark.parametrize(
    "words",
    [["participants", "."], ["run", "smoke", "--resume", "-o", "."]],
    ids=" ".join,
)
def test_a_folder_of_simulated_participants_gets_no_register(
    tmp_path: Path, words: list[str]
) -> None:
    """It is said that no people took part, until one did."""
    (simulated,) = simulated_assignments(load_protocol("smoke"), 1, seed=1)
    path = simulate_session("smoke", simulated, 1, tmp_path)
    done = study(*words, folder=tmp_path)
    assert done.returncode == 2
    assert "no people took part in ." in done.stderr
    assert list(tmp_path.iterdir()) == [path]
    # What cannot be read may be a person's.
    (tmp_path / "torn.mcap").write_bytes(b"torn")
    assert "no people" not in study(*words, folder=tmp_path).stderr


def test_a_forgotten_pseudonym_is_asked_for(folder: Path) -> None:
    """A folder in its place is not taken for one."""
    done = participants("exclude", folder, "--reason", "fell ill")
    assert done.returncode == 2
    assert "exclude needs a pseudonym" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ["pilot", "exclude", "P01"],
        ["P01", "exclude", "pilot"],
        ["P01", "pilot", "exclude"],
        ["exclude", "pilot", "P01"],
    ],
    ids=" ".join,
)
def test_words_in_another_order(folder: Path, words: list[str]) -> None:
    """The right order is given, with the words that were."""
    done = CliRunner().invoke(main.app, ["participants", *words, "-o", str(folder)])
    assert isinstance(done.exception, StudyError)
    assert done.exception.hint == "Say: study participants exclude P01 pilot"


def test_a_pseudonym_of_two_studies(folder: Path) -> None:
    """The command that says which is given whole; where no protocol is known, by a word."""
    with Register(folder) as register:
        for name in ("pilot", "smoke", "other"):
            register.reserve(name, ORDERS, pseudonym="P01")
    done = CliRunner().invoke(main.app, ["participants", "withdraw", "P01", str(folder)])
    assert isinstance(done.exception, StudyError)
    assert '"P01" takes part in other and pilot and smoke' in done.exception.message
    assert done.exception.hint.endswith(
        f"study participants withdraw P01 pilot -o {shlex.quote(str(folder))}"
    )


def test_who_is_in_a_session_is_not_withdrawn(tmp_path: Path) -> None:
    """Nothing is said to be erased: it is refused before anything else."""
    with Register(tmp_path) as register:
        register.reserve("smoke", ORDERS, pseudonym="P01")
        register.start("smoke", "P01")
        (tmp_path / "smoke_P01_20261126T022848_c3e0.mcap").write_bytes(b"torn")
        done = participants("withdraw", "P01", tmp_path, "--yes")
    assert done.returncode == 2
    assert "is in a session" in done.stderr
    assert "To be erased" not in done.stdout + done.stderr
    assert list(tmp_path.glob("*.mcap"))


def test_a_question_is_answered_or_left(monkeypatch: pytest.MonkeyPatch) -> None:
    """No is status 1; Ctrl-C at the question is the same as anywhere."""
    monkeypatch.setattr(typer, "confirm", lambda _: False)
    with pytest.raises(typer.Exit) as left:
        confirm("Erase?")
    assert left.value.exit_code == 1

    def interrupted(_: str) -> bool:
        raise typer.Abort

    monkeypatch.setattr(typer, "confirm", interrupted)
    with pytest.raises(KeyboardInterrupt):
        confirm("Erase?")


def test_who_withdrew_cannot_be_resumed(folder: Path) -> None:
    """It is said that they withdrew, and not that there is no recording."""
    with Register(folder) as register:
        leave_tombstone(register, "pilot", "pilot1")
    with pytest.raises(StudyError, match="withdrew"):
        find_boundary(load_protocol("pilot"), "pilot1", folder)
