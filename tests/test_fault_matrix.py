"""The fault matrix is in step with the tests that it names; its gaps are no others than here."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference" / "fault-matrix.md"
MISSING: set[str] = set()
"""What no test proves yet. Whoever adds the test names it in the matrix and takes it out here."""

ASKED = (
    "practice", "break", "early end", "decline of consent", "drop-out at each phase",
    "failed comprehension", "wrong condition run", "duplicate participant",
    "second session on another day", "participant id with a path", "blanks",
    "participant id of a device", "real name", "unknown keys, types and syntax in protocols",
    "questionnaire without items", "recordings of other programs", "newer versions",
    "mixed studies", "HTML", "formulas", "emoji", "right to left", "10,000 characters", "NaN",
    "one-class", "over its budget", "clock that jumps", "CPU hog", "1 kHz",
    "paused by the experimenter", "console killed", "cable severed", "link delayed",
    "dropped and reordered", "twin killed", "frozen or dead camera", "lost pose", "flat battery",
    "wrong key", "emergency stop", "hears nothing",
)  # fmt: skip
"""Every fault and bad input that a lab may count on having an outcome."""


def rows() -> list[list[str]]:
    """Return fault, outcome and proof of each row."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if "|" in line]
    return [row for row in cells if row[0] != "fault" and not row[0].startswith("---")]


def names_of_tests(path: Path) -> set[str]:
    """Return the names of a file's tests."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
    assigned = {
        target.id
        for node in tree.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    return {name for name in functions | assigned if name.lower().startswith("test")}


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0])
def test_each_row_names_a_test_that_exists(row: list[str]) -> None:
    """Or says that it is missing."""
    assert len(row) == 3
    fault, outcome, proof = row
    assert outcome
    if fault in MISSING:
        assert proof == "missing"
        return
    named = re.fullmatch(r"`(tests/[\w/]+\.py)::(\w+)`", proof)
    assert named, proof
    assert named[2] in names_of_tests(ROOT / named[1])


def test_nothing_is_left_out_or_listed_twice() -> None:
    """Every fault asked for has a row; the gaps are rows too."""
    faults = [row[0] for row in rows()]
    assert len(set(faults)) == len(faults)
    assert set(faults) >= MISSING
    assert [asked for asked in ASKED if not any(asked in fault for fault in faults)] == []
