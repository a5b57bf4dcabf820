"""Ctrl-C of a command line is one line and exit status 130, whenever it comes."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from study.starting import start

WHEN = {
    "imported": "raise KeyboardInterrupt",
    "running": "def main():\n    with stopped_in_a_line():\n        raise KeyboardInterrupt",
    "by Typer": "def main():\n    with stopped_in_a_line():\n        raise SystemExit(130)",
}


def begun(code: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> object:
    """Start a command line of this code; return its exit status."""
    (folder / "a_command_line.py").write_text(
        f"from study.starting import stopped_in_a_line\n{code}\n"
    )
    monkeypatch.syspath_prepend(str(folder))
    monkeypatch.delitem(sys.modules, "a_command_line", raising=False)
    with pytest.raises(SystemExit) as left:
        start("a_command_line")
    return left.value.code


@pytest.mark.parametrize("when", WHEN)
def test_it_is_said_once(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    when: str,
) -> None:
    """While all is imported, while it runs, and where Typer has made an exit of it."""
    assert begun(WHEN[when], tmp_path, monkeypatch) == 130
    assert capsys.readouterr() == ("", "Stopped.\n")


def test_another_exit_is_none_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a command ends with stays as it is."""
    code = "def main():\n    with stopped_in_a_line():\n        raise SystemExit(2)"
    assert begun(code, tmp_path, monkeypatch) == 2
    assert capsys.readouterr() == ("", "")
