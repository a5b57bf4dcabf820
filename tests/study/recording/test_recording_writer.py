from __future__ import annotations

import os
import random
import resource
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader

import study
from patience import PATIENCE_S
from study.errors import StudyError
from study.events.fields import record_types
from study.events.inputs import FitCompleted
from study.events.shell import Note
from study.recording.client import BacklogError, Recorder
from study.recording.durable_file import DurableFile
from study.recording.framing import FrameKind, FrameSplitter, frame
from study.recording.reader import read_recording

ROOT = Path(study.__file__ or "").parent.parent
STAND_IN = Path(__file__).parent / "stand_in.py"
linux_only = pytest.mark.skipif(sys.platform != "linux", reason="signals and limits of Linux")


def note(number: int) -> Note:
    return Note(t_ns=number, text=f"note {number}")


def wait_for(path: Path) -> bool:
    deadline = time.monotonic() + PATIENCE_S
    while not path.exists() and time.monotonic() < deadline:
        time.sleep(0.01)
    return path.exists()


def test_records_reach_the_file(tmp_path: Path) -> None:
    """What is written can be read: records, times, numbers, attachments, metadata."""
    toml = b'name = "pilot"\n'
    recorder = Recorder.start(tmp_path, "P01", {"protocol.toml": toml}, {"session_id": "abc"})
    sent = [recorder.write(note(number), 1_000 + number) for number in range(1, 101)]
    path = recorder.close()
    recording = read_recording(path)
    assert sent == list(range(1, 101))
    assert (recording.complete, recording.problems) == (True, ())
    assert recording.session_id == "abc"
    assert recording.attachments == {"protocol.toml": toml}
    raws = list(recording.raw("shell"))
    assert [raw.sequence for raw in raws] == list(range(101))
    assert [raw.log_time_ns for raw in raws[1:]] == [1_000 + number for number in sent]
    texts = [record.text for _, record in recording.records() if isinstance(record, Note)]
    assert texts == ["recording opened", *(f"note {number}" for number in sent)]


def test_the_file_is_an_ordinary_mcap(tmp_path: Path) -> None:
    """The MCAP project's own reader finds index, channels, schemas and messages."""
    recorder = Recorder.start(tmp_path, "P01", {"protocol.toml": b""}, {})
    recorder.write(note(1), 1)
    path = recorder.close()
    with path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == 2
        assert {channel.topic for channel in summary.channels.values()} == set(record_types())
        assert len(summary.chunk_indexes) >= 1
        assert [item.name for item in reader.iter_attachments()] == ["protocol.toml"]
        assert sorted(message.sequence for _, _, message in reader.iter_messages()) == [0, 1]


def test_only_the_owner_can_read(tmp_path: Path) -> None:
    """The folder gets mode 0700 and the file 0600."""
    folder = tmp_path / "deep" / "recordings"
    path = Recorder.start(folder, "P01", {}, {}).close()
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


@pytest.mark.parametrize("taken", ["P01.mcap", "P01.mcap.part"])
def test_names_are_never_taken_twice(tmp_path: Path, taken: str) -> None:
    """A finished or unfinished file of that name is an error, and stays as it is."""
    (tmp_path / taken).write_bytes(b"mine")
    with pytest.raises(StudyError, match=f"{taken} exists already"):
        Recorder.start(tmp_path, "P01", {}, {})
    assert (tmp_path / taken).read_bytes() == b"mine"
    assert [item.name for item in tmp_path.iterdir()] == [taken]


def test_a_file_that_appears_meanwhile_is_not_replaced(tmp_path: Path) -> None:
    """If the final name is taken during the session, both files survive."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(1), 1)
    (tmp_path / "P01.mcap").write_bytes(b"mine")
    with pytest.raises(StudyError, match="exists already"):
        recorder.close()
    assert (tmp_path / "P01.mcap").read_bytes() == b"mine"
    assert read_recording(tmp_path / "P01.mcap.part").complete


def test_without_hard_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file system without hard links gets the final name too, and replaces nothing."""

    def refuse(*_: object) -> None:
        raise PermissionError(1, "no hard links")

    monkeypatch.setattr(os, "link", refuse)
    file = DurableFile(tmp_path / "a.mcap")
    file.write(b"data")
    assert file.publish().read_bytes() == b"data"
    assert [item.name for item in tmp_path.iterdir()] == ["a.mcap"]
    other = DurableFile(tmp_path / "b.mcap")
    (tmp_path / "b.mcap").write_bytes(b"mine")
    with pytest.raises(FileExistsError):
        other.publish()
    assert (tmp_path / "b.mcap").read_bytes() == b"mine"


@pytest.mark.parametrize("name", ["", "a/b", "..", ".hidden"])
def test_names_must_be_plain(tmp_path: Path, name: str) -> None:
    """A name with folders or a leading dot is refused."""
    with pytest.raises(StudyError, match="cannot be the name"):
        Recorder.start(tmp_path, name, {}, {})


def test_a_folder_that_cannot_be_made(tmp_path: Path) -> None:
    """The error names the folder and says what to do."""
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(StudyError, match=r"file/sub cannot be made.*\n.*another folder"):
        Recorder.start(tmp_path / "file" / "sub", "P01", {}, {})


def test_records_become_durable(tmp_path: Path) -> None:
    """After ensure_durable the record is readable in the unfinished file."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(1), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    assert recorder.durable_sequence == recorder.sent_sequence == 1
    assert recorder.unacknowledged() == []
    assert recorder.backlog_bytes == 0
    part = read_recording(tmp_path / "P01.mcap.part")
    assert not part.complete
    assert [sequence for sequence, _ in part.records()] == [0, 1]
    assert recorder.close() == recorder.close()


def test_records_become_durable_unasked(tmp_path: Path) -> None:
    """A lone record reaches the disk by itself."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(1), 1)
    deadline = time.monotonic() + PATIENCE_S
    while recorder.durable_sequence < 1 and time.monotonic() < deadline:
        time.sleep(0.02)
    assert recorder.durable_sequence == 1
    recorder.close()


def test_an_invalid_record_leaves_no_trace(tmp_path: Path) -> None:
    """A refused record gets no number and spoils nothing around it."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(1), 1)
    with pytest.raises(ValueError, match=r"Note\.t_ns"):
        recorder.write(note(-1), 1)
    with pytest.raises(ValueError, match="log time -1"):
        recorder.write(note(1), -1)
    assert recorder.write(note(2), 1) == 2
    assert len(list(read_recording(recorder.close()).records())) == 3


@linux_only
def test_a_slow_writer_loses_nothing(tmp_path: Path) -> None:
    """While the writer stands still, records queue up to the limit, then are refused."""
    recorder = Recorder.start(tmp_path, "P01", {}, {}, backlog_limit=3 * 2**20)
    os.kill(recorder.writer_pid, signal.SIGSTOP)
    weights = np.random.default_rng(1).bytes(100_000)
    fit = FitCompleted(
        t_ns=0,
        request_id=0,
        artefact_id="policy:1",
        weights=weights,
        seconds=1.0,
        metric_names=(),
        metric_values=np.zeros(0),
        score_grid=np.zeros(0),
        preparation=b"",
    )
    for _ in range(31):
        recorder.write(fit, 1)
    with pytest.raises(BacklogError, match="wait for the disk"):
        recorder.write(fit, 1)
    taken = recorder.sent_sequence
    assert taken == 31
    assert not recorder.healthy
    assert not recorder.ensure_durable(0.05)
    os.kill(recorder.writer_pid, signal.SIGCONT)
    assert recorder.ensure_durable(PATIENCE_S)
    assert recorder.healthy
    found = [record for _, record in read_recording(recorder.close()).records(FitCompleted.topic)]
    assert [isinstance(item, FitCompleted) and item.weights == weights for item in found] == (
        [True] * taken
    )


@linux_only
def test_a_killed_writer_is_noticed(tmp_path: Path) -> None:
    """When the writer dies, writing and closing say so, and what was durable can be read."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(1), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    os.kill(recorder.writer_pid, signal.SIGKILL)
    deadline = time.monotonic() + PATIENCE_S
    while recorder.healthy and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not recorder.healthy
    with pytest.raises(StudyError, match="ended unexpectedly"):
        recorder.write(note(2), 1)
    assert not recorder.ensure_durable(0.1) or recorder.durable_sequence == 1
    with pytest.raises(StudyError, match=r"Record 1 of 1 .*\n.*P01\.mcap\.part"):
        recorder.close()
    assert len(list(read_recording(tmp_path / "P01.mcap.part").records())) == 2


@linux_only
def test_a_full_disk_is_reported(tmp_path: Path) -> None:
    """When the file can grow no further, no record is called durable that is not on disk."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    size = (tmp_path / "P01.mcap.part").stat().st_size
    resource.prlimit(recorder.writer_pid, resource.RLIMIT_FSIZE, (size + 100, size + 100))
    text = "".join(random.Random(1).choices("abcdefghijklmnopqrstuvwxyz", k=5_000))
    recorder.write(Note(t_ns=1, text=text), 1)
    assert not recorder.ensure_durable(PATIENCE_S)
    assert recorder.durable_sequence == 0
    with pytest.raises(StudyError, match="File too large"):
        recorder.close()
    assert not (tmp_path / "P01.mcap").exists()
    assert [sequence for sequence, _ in read_recording(tmp_path / "P01.mcap.part").records()] == [0]


def test_the_writer_process_is_light() -> None:
    """The writer loads neither NumPy nor protobuf nor the records: it starts in no time."""
    code = (
        "import sys, study.recording.writer, mcap.writer\n"
        "heavy = {'numpy', 'google.protobuf', 'study.events.fields', 'pygame', 'torch'}\n"
        "print(sorted(heavy & set(sys.modules)))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT
    )
    assert done.stdout.strip() == "[]"


@linux_only
def test_polite_signals_do_not_stop_the_writer(tmp_path: Path) -> None:
    """SIGINT, SIGTERM and SIGHUP leave the recording going; it has its own session."""
    recorder = Recorder.start(tmp_path, "P01", {}, {})
    for sent in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        os.kill(recorder.writer_pid, sent)
    assert os.getsid(recorder.writer_pid) != os.getsid(0)
    recorder.write(note(1), 1)
    assert len(list(read_recording(recorder.close()).records())) == 2


@linux_only
@pytest.mark.parametrize("seed", range(5))
def test_a_killed_study_leaves_a_complete_file(tmp_path: Path, seed: int) -> None:
    """SIGKILL at any moment: the file is completed and holds all handed over."""
    log = tmp_path / "handed_over"
    stand_in = subprocess.Popen(
        [sys.executable, str(STAND_IN), str(tmp_path), str(log), str(seed)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    assert wait_for(log)
    time.sleep(random.Random(seed).uniform(0.0, 1.2))
    stand_in.kill()
    stand_in.wait()
    path = tmp_path / "killed.mcap"
    assert wait_for(path)
    handed_over = [int(line) for line in log.read_text().splitlines()]
    recording = read_recording(path)
    found = [sequence for sequence, _ in recording.records()]
    assert recording.complete
    assert found == list(range(len(found)))
    # One more than logged may be there: the one between its writing and its logging.
    assert len(found) - 1 - len(handed_over) in {0, 1}
    with path.open("rb") as stream:
        summary = make_reader(stream, validate_crcs=True).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == len(found)
    assert not (tmp_path / "killed.mcap.part").exists()


@given(
    payloads=st.lists(st.binary(max_size=50), max_size=8),
    cuts=st.lists(st.integers(1, 30), min_size=1),
    torn=st.integers(0, 400),
)
def test_frames_survive_any_cutting(payloads: list[bytes], cuts: list[int], torn: int) -> None:
    """However a pipe cuts the stream, whole frames come out, and a torn last one does not."""
    stream = b"".join(frame(FrameKind.MESSAGES, payload) for payload in payloads)
    whole = stream[: len(stream) - min(torn, len(stream))]
    splitter = FrameSplitter()
    found: list[bytes] = []
    rest, turn = whole, 0
    while rest:
        size = cuts[turn % len(cuts)]
        found += [payload for _, payload in splitter.feed(rest[:size])]
        rest, turn = rest[size:], turn + 1
    ends = np.cumsum([len(frame(FrameKind.MESSAGES, payload)) for payload in payloads])
    assert found == payloads[: int((ends <= len(whole)).sum())]
