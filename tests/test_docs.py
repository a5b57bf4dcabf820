"""The documentation agrees with the program: reference, links, pictures, commands, examples."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

import analysis.commands.main
import study.commands.main
from patience import PATIENCE_S
from protocols import variant
from study.commands.simulating import simulate_session, simulated_assignments
from study.events.events import TrialEnded
from study.loading import load_protocol
from study.questionnaire import parse_questionnaire
from study.recording.reader import read_recording

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted(DOCS.rglob("*.md"))]
IMAGES = sorted((DOCS / "images").glob("*"))
APPS = {"study": study.commands.main.app, "analysis": analysis.commands.main.app}
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^\1```", re.DOTALL | re.MULTILINE)
WRITE_REFERENCE = ROOT / "tools" / "write_reference.py"


def blocks(page: Path, language: str) -> list[str]:
    """Return a page's code blocks in a language, without their indentation."""
    return [
        "".join(line.removeprefix(indent) for line in body.splitlines(keepends=True))
        for indent, found, body in BLOCK.findall(page.read_text(encoding="utf-8"))
        if found == language
    ]


def links(page: Path) -> list[Path]:
    """Return the files that a page refers to by relative links."""
    text = BLOCK.sub("", page.read_text(encoding="utf-8"))
    targets = [target.partition("#")[0] for target in LINK.findall(text) if "://" not in target]
    return [(page.parent / target).resolve() for target in targets if target]


def help_options(program: str, command: str) -> set[str]:
    """Return the options that a command's own help names."""
    run = CliRunner(env={"COLUMNS": "300", "NO_COLOR": "1", "TERM": "dumb"})
    shown = run.invoke(APPS[program], [command, "--help"])
    assert shown.exit_code == 0, shown.output
    return set(re.findall(r"(?<!\S)--[a-z][a-z-]+", shown.output)) - {"--help"}


def command_names(app: typer.Typer) -> list[str]:
    """Return the names of an app's commands."""
    return [command.name for command in app.registered_commands if command.name]


COMMANDS = [(program, name) for program, app in APPS.items() for name in command_names(app)]
SHELL_LINES = [
    (page, line)
    for page in PAGES
    for block in blocks(page, "sh")
    for line in block.splitlines()
    if line
]


def test_generated_reference_is_in_step() -> None:
    """The reference says what models and command lines say now."""
    check = [sys.executable, str(WRITE_REFERENCE), "--check"]
    done = subprocess.run(
        check, cwd=ROOT, capture_output=True, text=True, check=False, timeout=PATIENCE_S
    )
    assert done.returncode == 0, f"{done.stdout}{done.stderr}Run: python tools/write_reference.py"


@pytest.mark.parametrize(
    ("program", "command"), COMMANDS, ids=[" ".join(pair) for pair in COMMANDS]
)
def test_commands_and_options_are_documented(program: str, command: str) -> None:
    """Each command has its section, which names every option that its help names."""
    text = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    heading = f"### `{program} {command}`\n"
    assert heading in text
    section = text.partition(heading)[2].partition("\n### ")[0]
    options = help_options(program, command)
    assert options == set(re.findall(r"`(--[a-z-]+)`", section))


def test_every_exit_status_is_in_the_table() -> None:
    """Each status with which a command's file ends has a row for that command, or for each."""
    text = (DOCS / "reference" / "commands.md").read_text(encoding="utf-8")
    table = text.partition("## Exit statuses\n")[2].partition("\n<!--")[0]
    rows = set(re.findall(r"^\| (\d+) \| (each|`[a-z -]+`) \|", table, re.MULTILINE))
    ended = []
    places = ("study/starting.py", "study/commands/*.py", "analysis/commands/*.py")
    for file in [file for place in places for file in ROOT.glob(place)]:
        source = file.read_text(encoding="utf-8")
        numbers = dict(re.findall(r"^(\w+) = (\d+)$", source, re.MULTILINE))
        command = (file.parts[-3], file.stem.replace("_", "-"))
        name = f"`{' '.join(command)}`" if command in COMMANDS else "each"
        given = re.findall(r"(?:typer\.Exit|sys\.exit)\((\w+)\)", source)
        ended += [(numbers.get(status, status), name) for status in given]
    errors = (ROOT / "study" / "errors.py").read_text(encoding="utf-8")
    of_errors = re.findall(r"exit_status(?:: ClassVar\[int\])? = (\d+)", errors)
    assert len(ended) >= 9
    assert [row for row in ended if row not in rows] == []
    assert {"0", "1", *of_errors} <= {status for status, _ in rows}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_and_pictures_resolve(page: Path) -> None:
    """Every relative link and picture is a file of the project."""
    missing = [str(target) for target in links(page) if not target.exists()]
    assert not missing


def test_every_page_is_found_from_the_readme() -> None:
    """A reader who follows links from the README comes to every page."""
    reached, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        if page not in reached:
            reached.add(page)
            waiting += [target for target in links(page) if target.suffix == ".md"]
    assert {page for page in PAGES if DOCS in page.parents} <= reached


def test_pictures_are_used_and_small() -> None:
    """No picture lies about unused; together they stay small."""
    assert IMAGES
    used = {target for page in PAGES for target in links(page)}
    assert [image.name for image in IMAGES if image not in used] == []
    assert max(image.stat().st_size for image in IMAGES) < 200_000
    assert sum(image.stat().st_size for image in IMAGES) < 1_500_000


@pytest.mark.parametrize(
    ("page", "line"), SHELL_LINES, ids=[f"{page.stem}: {line}" for page, line in SHELL_LINES]
)
def test_shell_commands_exist(page: Path, line: str) -> None:
    """Each line to type begins with a program of the project, and gives options that it has."""
    words = shlex.split(line)
    while "=" in words[0]:
        words.pop(0)
    program, *rest = words
    if program == "make":
        assert f"\n{rest[0]}:" in (ROOT / "Makefile").read_text(encoding="utf-8")
    elif program == "cp":
        assert (ROOT / rest[0]).is_file()
    elif program in ("python3", ".venv/bin/python"):
        named = [word for word in rest if word.startswith(("tools/", "tests/"))]
        benchmark = rest[0] == "-m" and rest[1].startswith("benchmarks.")
        if benchmark:
            named.append(f"{rest[1].replace('.', '/')}.py")
        assert named or rest[:2] == ["-m", "pytest"] or rest[0] == "read.py"
        assert all((ROOT / word).exists() for word in named)
    else:
        name = program.removeprefix(".venv/bin/")
        assert (name, rest[0]) in COMMANDS, f"{page.name}: no command {line}"
        given = {word for word in rest if word.startswith("--")}
        assert given <= help_options(name, rest[0])


def test_protocols_named_in_the_reference_are_shipped() -> None:
    """Each shipped protocol is named in the reference of the protocol file.

    The folder may hold protocols of the user's own, as the tutorial makes one.
    """
    text = (DOCS / "reference" / "protocol.md").read_text(encoding="utf-8")
    for name in ("scaled_autonomy", "pilot", "smoke"):
        assert f"`{name}`" in text
        assert (ROOT / "protocols" / f"{name}.toml").is_file()


def test_the_example_questionnaire_is_valid() -> None:
    """The questionnaire of the how-to guide can be used as it stands."""
    example = blocks(DOCS / "how-to" / "add-a-questionnaire.md", "toml")[0]
    assert len(parse_questionnaire(example, "the guide").items) == 3


def test_the_example_reader_reads(tmp_path: Path) -> None:
    """The guide's program, which knows nothing of this project, reads what our reader reads."""
    protocol = str(variant(tmp_path))
    (assignment,) = simulated_assignments(load_protocol(protocol), 1, seed=5)
    path = simulate_session(protocol, assignment, 5, tmp_path / "recordings")
    (example,) = blocks(DOCS / "how-to" / "read-a-recording-elsewhere.md", "python")
    program = tmp_path / "read.py"
    program.write_text(example, encoding="utf-8")
    command = [sys.executable, str(program), str(path)]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=PATIENCE_S
    )
    expected = [
        f"{sequence} {record.trial_id} {record.timesteps} {round(record.team_reward, 2)}"
        for sequence, record in read_recording(path).records("event/trial_ended")
        if isinstance(record, TrialEnded)
    ]
    assert expected
    assert done.stdout.splitlines() == expected
