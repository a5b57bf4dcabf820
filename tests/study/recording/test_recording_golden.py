"""A recording of format version 1, made once and never again, is readable for ever."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from study.errors import RecordingError
from study.events.events import TrialEnded
from study.recording.identity import PROFILE, SELF_DIGEST, metadata_digest
from study.recording.mcap_records import metadata_record, text
from study.recording.mcap_summary import read_summary
from study.recording.reader import Recording, read_recording
from study.recording.salvage import salvage

GOLDEN = Path(__file__).parent / "golden"
FILE = GOLDEN / "v1.mcap"


def facts(recording: Recording) -> dict[str, Any]:
    """Return counts and hashes of everything in a recording."""
    topics: dict[str, Any] = {}
    for raw in recording.raw():
        count, digest = topics.setdefault(raw.topic, (0, hashlib.sha256()))
        digest.update(raw.sequence.to_bytes(8, "little") + raw.log_time_ns.to_bytes(8, "little"))
        digest.update(raw.data)
        topics[raw.topic] = (count + 1, digest)
    runs = recording.columns("event/timestep")
    states = b"".join(run["states"].astype("<f4").tobytes() for run in runs)
    ended = [record for _, record in recording.records("event/trial_ended")]
    return {
        "records": len(recording.sequences),
        "session_id": recording.session_id,
        "topics": {
            topic: {"count": count, "sha256": digest.hexdigest()}
            for topic, (count, digest) in sorted(topics.items())
        },
        "timesteps": sum(len(run["sequence"]) for run in runs),
        "states_sha256": hashlib.sha256(states).hexdigest(),
        "rewards": float(sum(run["rewards"].astype(np.float64).sum() for run in runs)),
        "team_rewards": [r.team_reward for r in ended if isinstance(r, TrialEnded)],
    }


def test_format_version_1_is_readable() -> None:
    """Counts, bytes, columns and decoded values are those of the day it was made."""
    expected = json.loads((GOLDEN / "v1.json").read_text())
    recording = read_recording(FILE)
    assert recording.sha256 == expected.pop("file_sha256")
    assert (recording.complete, recording.problems, recording.losses) == (True, (), ())
    assert facts(recording) == expected


def test_the_index_changes_nothing(tmp_path: Path) -> None:
    """Without index and summary the same records come out, in the same columns."""
    with FILE.open("rb") as stream:
        summary = read_summary(stream)
    assert summary is not None
    torn = tmp_path / "torn.mcap"
    torn.write_bytes(FILE.read_bytes()[: summary.start])
    expected = json.loads((GOLDEN / "v1.json").read_text())
    del expected["file_sha256"]
    recording = read_recording(torn)
    assert facts(recording) == expected
    assert (recording.complete, recording.losses) == (False, ())
    assert facts(read_recording(salvage(torn, tmp_path / "new.mcap").path)) == expected


@pytest.mark.parametrize("version", ["2", "17"])
def test_a_newer_version_says_what_to_install(tmp_path: Path, version: str) -> None:
    """A file of a later format names its version and what to install, whole or torn."""
    data = FILE.read_bytes()
    begin = data.index(b"\x0c", 8)
    length = int.from_bytes(data[begin + 1 : begin + 9], "little")
    _, entries = metadata_record(data[begin + 9 : begin + 9 + length])
    entries |= {"format_version": version}
    entries[SELF_DIGEST] = metadata_digest(entries)
    packed = b"".join(text(key) + text(value) for key, value in entries.items())
    payload = text(PROFILE) + len(packed).to_bytes(4, "little") + packed
    newer = tmp_path / "newer.mcap"
    newer.write_bytes(
        data[: begin + 1]
        + len(payload).to_bytes(8, "little")
        + payload
        + data[begin + 9 + length :]
    )
    with pytest.raises(RecordingError, match=f"format version {version}") as caught:
        read_recording(newer)
    assert "reads up to 1" in caught.value.message
    assert "pip install --upgrade scaled-autonomy" in caught.value.hint


if __name__ == "__main__":
    made = {"file_sha256": read_recording(FILE).sha256, **facts(read_recording(FILE))}
    (GOLDEN / "v1.json").write_text(json.dumps(made, indent=2) + "\n", encoding="utf-8")
