"""Whatever stands in a TOML file of a user's, the answer is one message."""

from __future__ import annotations

from pathlib import Path

import pytest

from command_line import study
from protocols import variant
from study.errors import ProtocolError
from study.questionnaire import parse_questionnaire
from study.robots.robots_file import read_robots_file
from study.toml_text import DEEPEST, parse_toml

BOTTOMLESS = {
    "lists": f"x = {'[' * 5000}{']' * 5000}",
    "unclosed lists": f"x = {'[' * 5000}",
    "tables": f"x = {'{a=' * 5000}1{'}' * 5000}",
    "dotted keys": f"{'.'.join(['a'] * 5000)} = 1",
    "just too deep": f"x = {'[' * (DEEPEST + 1)}{']' * (DEEPEST + 1)}",
}


@pytest.mark.parametrize("text", BOTTOMLESS.values(), ids=BOTTOMLESS)
def test_what_has_no_bottom_is_refused(text: str) -> None:
    """However it is nested, and before anything else follows it down."""
    with pytest.raises(ProtocolError) as caught:
        parse_toml(text, "deep.toml")
    (problem,) = caught.value.problems
    assert problem.startswith("nested too deeply")


@pytest.mark.parametrize("number", ["9" * 5000, f"0x{'f' * 20000}", str(2**63 + 1)])
def test_numbers_beyond_toml_s_are_refused(number: str) -> None:
    """Python takes some of them, or says how to take more; a protocol has none such."""
    with pytest.raises(ProtocolError, match="a whole number beyond 64 bits"):
        parse_toml(f"x = {number}", "large.toml")


@pytest.mark.parametrize("text", BOTTOMLESS.values(), ids=BOTTOMLESS)
def test_questionnaires_and_lists_of_robots_too(tmp_path: Path, text: str) -> None:
    """They are read as protocols are."""
    path = tmp_path / "deep.toml"
    path.write_text(text)
    with pytest.raises(ProtocolError, match="nested too deeply"):
        parse_questionnaire(text, "deep.toml")
    with pytest.raises(ProtocolError, match="nested too deeply"):
        read_robots_file(path)


def test_a_list_of_robots_may_have_a_byte_order_mark(tmp_path: Path) -> None:
    """What is said is what is missing, not that it is no TOML."""
    path = tmp_path / "robots.toml"
    path.write_bytes(b"\xef\xbb\xbfoperator_key = 'keys/operator.toml'")
    with pytest.raises(ProtocolError) as caught:
        read_robots_file(path)
    assert "operator_key" not in str(caught.value)
    assert "poses: missing" in str(caught.value)


@pytest.mark.parametrize("command", ["validate", "experiment"])
def test_a_protocol_without_bottom_ends_in_one_message(tmp_path: Path, command: str) -> None:
    """Exit status 2, no traceback."""
    path = variant(tmp_path, ("[timing]", f"{BOTTOMLESS['lists']}\n[timing]"))
    done = study(command, path)
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == f"Error: {path}: 1 problem"
    assert len(done.stderr.splitlines()) == 2
