from __future__ import annotations

from pathlib import Path

import pytest

from study.events.fields import record_types, wire_fields
from study.recording.reference import BEGIN, DEFAULT_FILE, END, insert, main


def test_the_readme_is_in_step() -> None:
    """The format reference is what the declarations say now."""
    text = DEFAULT_FILE.read_text(encoding="utf-8")
    assert insert(text) == text, "run: python -m study.recording.reference"


def test_every_field_is_in_it() -> None:
    """Every topic, and each of its fields with number and kind, has its place."""
    text = DEFAULT_FILE.read_text(encoding="utf-8")
    for topic, record_type in record_types().items():
        section = text.partition(f"#### `{topic}`\n")[2].partition("####")[0]
        for name, wire in wire_fields(record_type).items():
            assert f"| {wire.number} | `{name}` | {wire.kind} |" in section


def test_the_command_writes_between_the_markers(tmp_path: Path) -> None:
    """What stands around the markers is kept, what stands between them replaced."""
    file = tmp_path / "reference.md"
    file.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n", encoding="utf-8")
    assert main([str(file)]) == 0
    text = file.read_text(encoding="utf-8")
    assert text.startswith(f"before\n{BEGIN}\n")
    assert text.endswith(f"{END}\nafter\n")
    assert "old" not in text
    assert "`event/timestep`" in text
    with pytest.raises(ValueError, match="markers"):
        insert("no markers")
