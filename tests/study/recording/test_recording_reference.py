from __future__ import annotations

from pathlib import Path

import pytest

from study.events.fields import record_types, wire_fields
from study.recording.findings import MAX_ATTACHMENTS_BYTES, MAX_CHUNKS, MAX_RECORDS
from study.recording.identity import (
    CHANNELS,
    PART,
    SALVAGED_BY_TOPIC,
    SALVAGED_FROM,
    SALVAGED_LOSSES,
    SALVAGED_NUMBERS,
    SALVAGED_PROBLEMS,
    SELF_DIGEST,
)
from study.recording.mcap_chunks import MAX_CHUNK_MESSAGES
from study.recording.mcap_records import MAX_CHUNK_BYTES, MAX_RECORD_BYTES
from study.recording.reader import read_recording
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


def test_a_change_of_any_field_would_be_noticed() -> None:
    """A row of the reference that differs in one sign is out of step."""
    text = DEFAULT_FILE.read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("| 1 | `t_ns` | fixed64 |")]
    assert len(rows) == len(record_types())
    assert insert(text.replace("| 1 | `t_ns` |", "| 2 | `t_ns` |", 1)) == text


def test_the_limits_are_those_of_the_reader() -> None:
    """What the reader refuses is stated with the numbers that it refuses by."""
    text = " ".join(DEFAULT_FILE.read_text(encoding="utf-8").split())
    assert f"more than {MAX_CHUNK_BYTES // 2**20} MiB unpacked" in text
    assert f"{MAX_CHUNK_MESSAGES:,} messages" in text
    assert f"record of more than {MAX_RECORD_BYTES // 2**20} MiB" in text
    assert f"attachments of more than {MAX_ATTACHMENTS_BYTES // 2**20} MiB" in text
    assert f"more than {MAX_CHUNKS:,} chunks" in text
    assert (MAX_RECORDS, "five million records" in text) == (5_000_000, True)


def test_every_key_of_the_metadata_is_in_it() -> None:
    """The keys that the program gives the metadata are explained."""
    text = DEFAULT_FILE.read_text(encoding="utf-8")
    salvaged = (SALVAGED_FROM, SALVAGED_LOSSES, SALVAGED_BY_TOPIC)
    keys = (PART, CHANNELS, SELF_DIGEST, *salvaged, SALVAGED_PROBLEMS, SALVAGED_NUMBERS)
    golden = read_recording(Path(__file__).parent / "golden" / "v1.mcap").metadata
    for key in (*keys, *golden):
        prefix, colon, _ = key.partition(":")
        assert f"`{prefix}:NAME`" in text if colon else f"`{key}`" in text, key


def test_the_command_writes_between_the_markers(tmp_path: Path) -> None:
    """What stands around the markers is kept, what stands between them replaced."""
    file = tmp_path / "reference.md"
    file.write_text(f"before\n{BEGIN}\nwas here before\n{END}\nafter\n", encoding="utf-8")
    assert main([str(file)]) == 0
    text = file.read_text(encoding="utf-8")
    assert text.startswith(f"before\n{BEGIN}\n")
    assert text.endswith(f"{END}\nafter\n")
    assert "was here before" not in text
    assert "`event/timestep`" in text
    with pytest.raises(ValueError, match="markers"):
        insert("no markers")
