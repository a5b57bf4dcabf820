"""A reader that shares nothing with ours, on Node, finds the same in every recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cut_sessions import resume, study_loaded, whole_session, write_part
from node_reader import facts_of, read_by_node
from study.commands.resuming import find_boundary
from study.events.fields import Record, Wire, record_types, wire_fields
from study.events.inputs import SessionOpened
from study.recording.client import Recorder
from study.recording.identity import PROFILE
from study.recording.parts import part_number
from study.recording.protobuf_format import ARRAY_DTYPES
from study.recording.reader import read_recording
from study.recording.salvage import salvage

GOLDEN = Path(__file__).parent / "golden" / "v1.mcap"
PRODUCED = {
    "input/session_opened",
    "input/key_changed",
    "input/timestep_due",
    "input/fleet_observed",
    "input/fit_completed",
    "event/timestep",
    "event/switched",
    "event/trial_started",
    "event/trial_ended",
    "event/episode_ended",
    "event/question_answered",
    "event/reward_revealed",
    "event/fit_applied",
    "event/session_ended",
}
"""What any session holds, among others."""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated session."""
    return whole_session(tmp_path_factory.mktemp("session"))


def made_up(record_type: type[Record], generator: np.random.Generator) -> Record:
    """Return a record with extreme and arbitrary values in every field."""
    fields = wire_fields(record_type)
    robots = int(generator.integers(1, 5))
    values = {name: _value(wire, robots, generator) for name, wire in fields.items()}
    if "robots" in fields:
        values["robots"] = robots
    made: Any = record_type
    return made(**values)  # type: ignore[no-any-return]


def _value(wire: Wire, robots: int, generator: np.random.Generator) -> Any:
    if wire.kind in ARRAY_DTYPES:
        lengths = {"n,d": (robots, 4), "n": (robots,), "n or 0": (robots,)}
        numbers = generator.normal(0, 1e6, lengths.get(wire.shape, (3,)))
        odd = np.array([np.nan, np.inf, -0.0])
        if wire.kind != "ints" and generator.random() < 0.5:
            numbers.flat[: min(3, numbers.size)] = odd[: min(3, numbers.size)]
        return numbers.astype(ARRAY_DTYPES[wire.kind])
    texts = ["", "plain", "Grüße, 世界 🤖", 'a "b"\n\0']
    choices: dict[str, list[Any]] = {
        "fixed64": [0, 1, 2**32, 2**63, 2**64 - 1],
        "sfixed32": [0, -1, 2**31 - 1, -(2**31)],
        "double": [0.0, -0.0, float("nan"), float("inf"), 5e-324, 0.1],
        "bool": [False, True],
        "string": texts,
        "bytes": [b"", bytes(range(256))],
        "strings": [(), ("",), tuple(texts)],
    }
    options = choices[wire.kind]
    return options[int(generator.integers(len(options)))]


@pytest.fixture(scope="module")
def every_topic(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with several made-up records of every topic that is declared."""
    generator = np.random.default_rng(11)
    recorder = Recorder.start(
        tmp_path_factory.mktemp("every"), "every", {"protocol.toml": b"a = 1\n"}, {}
    )
    for number in range(6):
        for record_type in record_types().values():
            recorder.write(made_up(record_type, generator), 10**18 + number)
    return recorder.close()


def assert_agrees(path: Path, found: dict[str, Any]) -> dict[str, int]:
    """Hold what Node found against our reader; return the counts by topic."""
    recording = read_recording(path)
    # A salvaged file is whole, and says that its session is not.
    assert recording.complete or recording.salvaged_from
    ours = facts_of(recording)
    theirs = found["topics"]
    assert found["profile"] == PROFILE
    assert found["metadata"][PROFILE] == recording.metadata
    assert set(theirs) <= set(ours)
    for topic, facts in ours.items():
        if topic not in theirs:
            # A file of before the topic was declared.
            assert facts["count"] == 0, topic
            continue
        fields = {name: facts["fields"][name] for name in theirs[topic]["fields"]}
        assert theirs[topic] == {**facts, "fields": fields}, topic
    counts = {topic: int(facts["count"]) for topic, facts in ours.items() if facts["count"]}
    assert found["counts_by_index"] == counts
    assert set(found["attachments"]) == set(recording.attachments)
    return counts


def test_node_reads_a_session_and_every_topic(session: Path, every_topic: Path) -> None:
    """Counts, times and every field of every topic agree, down to the bits of each number."""
    of_session, of_every = read_by_node(session, every_topic)
    assert set(assert_agrees(session, of_session)) >= PRODUCED
    counts = assert_agrees(every_topic, of_every)
    assert set(counts) == set(record_types())
    assert min(counts.values()) >= 6


def test_node_reads_old_mended_and_later_files(session: Path, tmp_path: Path) -> None:
    """So they do in the golden file of version 1, in a salvaged file, and in a part 2."""
    damaged = tmp_path / "damaged.mcap"
    data = bytearray(session.read_bytes())
    middle = len(data) // 2
    data[middle : middle + 16] = b"\xff" * 16
    damaged.write_bytes(data)
    salvaged = salvage(damaged, tmp_path / "salvaged.mcap")
    assert read_recording(damaged).losses

    folder = tmp_path / "parts"
    records = [raw for raw in read_recording(session).raw() if raw.sequence]
    write_part(folder, records[: len(records) * 2 // 3])
    (opened,) = [r for _, r in read_recording(session).records(SessionOpened.topic)]
    assert isinstance(opened, SessionOpened)
    part = resume(find_boundary(study_loaded(), opened.participant, folder), folder)
    assert part_number(read_recording(part)) == 2

    paths = [GOLDEN, salvaged.path, part]
    for path, found in zip(paths, read_by_node(*paths), strict=True):
        assert assert_agrees(path, found), path


def test_a_wrong_value_would_be_noticed(every_topic: Path) -> None:
    """The comparison can fail: of two different recordings not even one topic agrees."""
    (found,) = read_by_node(every_topic)
    ours = facts_of(read_recording(GOLDEN))
    assert [topic for topic, facts in found["topics"].items() if facts == ours[topic]] == []


def test_node_refuses_a_damaged_file(session: Path, tmp_path: Path) -> None:
    """Its checksums are really checked: one byte changed in a chunk is an error."""
    damaged = tmp_path / "damaged.mcap"
    data = bytearray(session.read_bytes())
    data[len(data) // 2] ^= 1
    damaged.write_bytes(data)
    with pytest.raises(AssertionError, match=r"damaged\.mcap: "):
        read_by_node(damaged)
