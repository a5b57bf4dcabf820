"""Faults of the writer and of the disk, each really done."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from patience import PASS_S, PATIENCE_S
from recording_parts import Merged
from study.errors import RecordingFailedError, StudyError
from study.events.shell import Note
from study.recording.failover import TOO_FAST, FailoverRecorder
from study.recording.reader import read_recording
from study.recording.writer import FAIL_SYNC_AFTER

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="signals and mounts of Linux")


def note(number: int, size: int = 0) -> Note:
    text = "".join(random.Random(number).choices("abcdefghijklmnopqrstuvwxyz", k=size))
    return Note(t_ns=number, text=f"note {number} {text}")


def watched(recorder: FailoverRecorder, seconds: float) -> tuple[str | None, float]:
    """Check as a loop does; return the fault found, and after how many seconds.

    A pass in which the machine did other things counts as one that it did not.
    """
    counted, fault = 0.0, None
    while fault is None and counted < seconds:
        began = time.perf_counter()
        time.sleep(0.01)
        fault = recorder.check(time.perf_counter_ns())
        counted += min(time.perf_counter() - began, PASS_S)
    return fault, counted


def stall_noticed_after_ns(recorder: FailoverRecorder, written_ns: int) -> int:
    """Check a hundred times a second of a clock of our own, which no slow machine holds up."""
    for now_ns in range(written_ns, written_ns + 5_000_000_000, 10_000_000):
        fault = recorder.check(now_ns)
        if fault is not None:
            assert "wrote nothing" in fault
            return now_ns - written_ns
    pytest.fail("a stall was not noticed in five seconds")


def wait_for_failure(recorder: FailoverRecorder) -> None:
    """Wait until the writer has said that it failed; on a busy machine it may seem to stall."""
    deadline = time.monotonic() + PATIENCE_S
    while recorder.healthy and time.monotonic() < deadline:
        time.sleep(0.01)


def assert_nothing_missing(paths: list[Path], taken: int) -> None:
    """Across the parts every record is there, and the last file is complete."""
    assert sorted(Merged(paths).rows) == list(range(1, taken + 1))
    assert read_recording(paths[-1]).complete


@contextmanager
def mounted(folder: Path, *options: str) -> Iterator[None]:
    """Mount something on a folder for a while."""
    if os.geteuid() != 0:
        pytest.skip("needs root to mount a small file system")
    folder.mkdir(exist_ok=True)
    done = subprocess.run(
        ["mount", *options, str(folder)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        pytest.skip(f"needs root to mount a small file system: {done.stderr.strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def fill(folder: Path) -> Path:
    """Leave no byte free on the disk of a folder."""
    filler = folder / "filler"
    with filler.open("wb", buffering=0) as stream:
        for size in (1 << 16, 1 << 12, 1):
            try:
                while stream.write(b"x" * size) == size:
                    pass
            except OSError:
                continue
    return filler


def test_a_killed_writer_costs_nothing(tmp_path: Path) -> None:
    """A dead writer is noticed within a second; what it had not acknowledged is sent again."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {"protocol.toml": b"x"}, {"session_id": "s"})
    for number in range(50):
        recorder.write(note(number), number)
    assert recorder.ensure_durable(PATIENCE_S)
    os.kill(recorder.writer_pid, signal.SIGKILL)
    for number in range(50, 60):
        recorder.write(note(number), number)
    fault, seconds = watched(recorder, 5)
    assert fault is not None
    assert "ended unexpectedly" in fault
    assert seconds < 1
    for number in range(60, 70):
        assert recorder.write(note(number), number) == number + 1
    assert recorder.begin_part(fault) == 2
    assert recorder.durable_sequence == 70
    assert recorder.check(time.perf_counter_ns()) is None
    recorder.write(note(70), 70)
    paths = recorder.close()
    assert [path.name for path in paths] == ["P01.mcap.part", "P01_part2.mcap"]
    assert_nothing_missing(paths, 71)
    second = read_recording(paths[1])
    assert (second.metadata["part"], second.session_id) == ("2", "s")
    assert second.attachments == {"protocol.toml": b"x"}
    assert [raw.log_time_ns for raw in second.raw()][-3:] == [68, 69, 70]


def test_a_disk_that_is_only_slow_is_waited_for(tmp_path: Path) -> None:
    """When half of what may wait does wait, the fault says so; the same part then goes on."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {}, backlog_limit=400_000)
    os.kill(recorder.writer_pid, signal.SIGSTOP)
    for number in range(3):
        recorder.write(note(number, 100_000), 1)
    assert recorder.check(time.perf_counter_ns()) == TOO_FAST
    os.kill(recorder.writer_pid, signal.SIGCONT)
    assert recorder.begin_part(TOO_FAST) == 1
    assert recorder.check(time.perf_counter_ns()) is None
    assert_nothing_missing(recorder.close(), 3)


def test_a_stalled_writer_is_killed_before_its_part_is_given_up(tmp_path: Path) -> None:
    """A writer that stands still is noticed within a second, and never writes beside another."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(0), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    stalled = recorder.writer_pid
    os.kill(stalled, signal.SIGSTOP)
    recorder.write(note(1), 1)
    assert 800_000_000 < stall_noticed_after_ns(recorder, time.perf_counter_ns()) < 1_000_000_000
    fault, _ = watched(recorder, 5)
    assert fault is not None
    assert "wrote nothing" in fault
    before = (tmp_path / "P01.mcap.part").read_bytes()
    assert recorder.begin_part(fault) == 2
    assert not Path(f"/proc/{stalled}").exists()
    recorder.write(note(2), 1)
    paths = recorder.close()
    assert (tmp_path / "P01.mcap.part").read_bytes() == before
    assert_nothing_missing(paths, 3)


def test_standing_still_oneself_is_no_stall_of_the_writer(tmp_path: Path) -> None:
    """After a gap between two checks the writer gets its second anew."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    os.kill(recorder.writer_pid, signal.SIGSTOP)
    recorder.write(note(0), 1)
    time.sleep(1.2)
    assert recorder.check(time.perf_counter_ns()) is None
    os.kill(recorder.writer_pid, signal.SIGCONT)
    assert recorder.ensure_durable(PATIENCE_S)
    assert [path.name for path in recorder.close()] == ["P01.mcap"]


def test_a_writer_that_comes_round_goes_on_with_its_part(tmp_path: Path) -> None:
    """A stall that passes pauses the session, but begins no part."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    os.kill(recorder.writer_pid, signal.SIGSTOP)
    recorder.write(note(0), 1)
    fault, _ = watched(recorder, 5)
    assert fault is not None
    woken = threading.Timer(0.5, os.kill, (recorder.writer_pid, signal.SIGCONT))
    woken.start()
    assert recorder.begin_part(fault) == 1
    woken.join()
    assert recorder.check(time.perf_counter_ns()) is None
    assert [path.name for path in recorder.close()] == ["P01.mcap"]


@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGSTOP])
def test_waiting_for_the_disk_fails_over(tmp_path: Path, sent: signal.Signals) -> None:
    """Who waits for a dead or stalled writer soon has another; the fault is told afterwards."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    os.kill(recorder.writer_pid, sent)
    recorder.write(note(0), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    fault = recorder.check(time.perf_counter_ns())
    assert fault is not None
    assert recorder.begin_part(fault) == 2
    assert recorder.check(time.perf_counter_ns()) is None
    assert_nothing_missing(recorder.close(), 1)


def test_a_writer_that_dies_at_the_end_is_made_up_for(tmp_path: Path) -> None:
    """Closing sends what a dead writer left to another part."""
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    os.kill(recorder.writer_pid, signal.SIGKILL)
    recorder.write(note(0), 1)
    paths = recorder.close()
    assert [path.name for path in paths] == ["P01.mcap.part", "P01_part2.mcap"]
    assert_nothing_missing(paths, 1)
    assert recorder.close() == paths


def write_until_it_fails(recorder: FailoverRecorder) -> None:
    for number in range(2_000):
        recorder.write(note(number, 2_000), 1_700_000_000_000_000_000 + number)
        time.sleep(0.002)
        fault = recorder.check(time.perf_counter_ns())
        if fault is not None:
            recorder.begin_part(fault)


def test_a_disk_full_in_mid_trial_ends_the_session_honestly(tmp_path: Path) -> None:
    """With no room for another part either, the error says what is safe, and it is."""
    with mounted(tmp_path / "small", "-t", "tmpfs", "-o", "size=400k", "none"):
        folder = tmp_path / "small"
        recorder = FailoverRecorder.start(folder, "P01", {}, {})
        with pytest.raises(RecordingFailedError, match="the disk is full") as caught:
            write_until_it_fails(recorder)
        durable, sent = recorder.durable_sequence, recorder.sent_sequence
        assert 0 < durable < sent
        assert f"(record {durable}); {sent - durable} records after that" in caught.value.message
        assert "2023-11-14 22:13:20" in caught.value.message
        assert "Free space" in caught.value.hint
        assert caught.value.exit_status == 4
        found = sorted(Merged(sorted(folder.glob("*.part"))).rows)
        assert found[:durable] == list(range(1, durable + 1))
        assert list(folder.glob("*.mcap")) == []
        with pytest.raises(RecordingFailedError, match="the disk is full"):
            recorder.close()


def test_a_full_disk_with_room_made_in_time_costs_nothing(tmp_path: Path) -> None:
    """If space is freed before the next part, that part holds all that waited."""
    with mounted(tmp_path / "small", "-t", "tmpfs", "-o", "size=1m", "none"):
        folder = tmp_path / "small"
        recorder = FailoverRecorder.start(folder, "P01", {}, {})
        filler = fill(folder)
        for number in range(100):
            recorder.write(note(number, 200), number)
        wait_for_failure(recorder)
        fault = recorder.check(time.perf_counter_ns())
        assert fault is not None
        assert "the disk is full" in fault
        filler.unlink()
        assert recorder.begin_part(fault) == 2
        paths = recorder.close()
        assert_nothing_missing(paths, 100)


def test_a_disk_full_at_the_end_is_no_success(tmp_path: Path) -> None:
    """No room for the index: all records are safe, which is said, but no file is complete."""
    with mounted(tmp_path / "small", "-t", "tmpfs", "-o", "size=1m", "none"):
        folder = tmp_path / "small"
        recorder = FailoverRecorder.start(folder, "P01", {}, {})
        for number in range(100):
            recorder.write(note(number, 200), number)
        assert recorder.ensure_durable(PATIENCE_S)
        fill(folder)
        with pytest.raises(RecordingFailedError, match=r"the disk is full.*All 100 records are"):
            recorder.close()
        assert not (folder / "P01.mcap").exists()
        assert sorted(Merged([folder / "P01.mcap.part"]).rows) == list(range(1, 101))


def test_a_read_only_folder_is_refused_at_the_start(tmp_path: Path) -> None:
    """The error names the file, and nothing is left behind."""
    with (
        mounted(tmp_path / "small", "-t", "tmpfs", "-o", "size=1m,ro", "none"),
        pytest.raises(StudyError, match="Read-only file system"),
    ):
        FailoverRecorder.start(tmp_path / "small", "P01", {}, {})


def test_a_folder_that_becomes_read_only_is_no_success(tmp_path: Path) -> None:
    """The open file is written to its end, but cannot get its name: that is said."""
    folder = tmp_path / "folder"
    recorder = FailoverRecorder.start(folder, "P01", {}, {})
    recorder.write(note(0), 1)
    with mounted(folder, "--bind", str(folder)):
        subprocess.run(["mount", "-o", "remount,ro,bind", str(folder)], check=True)
        with pytest.raises(RecordingFailedError, match=r"Read-only.*All 1 records are safe"):
            recorder.close()
    assert [path.name for path in folder.iterdir()] == ["P01.mcap.part"]
    assert sorted(Merged([folder / "P01.mcap.part"]).rows) == [1]


@pytest.mark.parametrize("how", ["deleted", "moved"])
def test_a_vanished_folder_is_made_again(tmp_path: Path, how: str) -> None:
    """All that was written is put back where it belongs, which is remarked."""
    folder = tmp_path / "deep" / "folder"
    recorder = FailoverRecorder.start(folder, "P01", {}, {})
    recorder.write(note(0, 3_000), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    if how == "deleted":
        shutil.rmtree(folder.parent)
    else:
        folder.parent.rename(tmp_path / "elsewhere")
    recorder.write(note(1), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    assert sorted(Merged([folder / "P01.mcap.part"]).rows) == [1, 2]
    recorder.write(note(2), 1)
    (path,) = recorder.close()
    assert path == folder / "P01.mcap"
    assert_nothing_missing([path], 3)
    assert path.stat().st_mode & 0o777 == 0o600
    assert [item.name for item in folder.iterdir()] == ["P01.mcap"]
    assert any("put back" in remark for remark in recorder.take_remarks())


def test_a_folder_that_cannot_be_made_again_is_said_to_be_lost(tmp_path: Path) -> None:
    """A file in the folder's place: nothing is called safe that is gone."""
    folder = tmp_path / "folder"
    recorder = FailoverRecorder.start(folder, "P01", {}, {})
    recorder.write(note(0), 1)
    assert recorder.ensure_durable(PATIENCE_S)
    shutil.rmtree(folder)
    folder.write_bytes(b"")
    with pytest.raises(RecordingFailedError, match=r"was deleted.*What it held is not safe"):
        recorder.close()


def test_an_error_on_sync_costs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After an input/output error nothing is called durable until another part holds it."""
    monkeypatch.setenv(FAIL_SYNC_AFTER, "1")
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    monkeypatch.delenv(FAIL_SYNC_AFTER)
    recorder.write(note(0), 1)
    wait_for_failure(recorder)
    fault, _ = watched(recorder, 5)
    assert fault is not None
    assert "the disk reported an error" in fault
    assert recorder.durable_sequence == 0
    assert recorder.begin_part(fault) == 2
    assert recorder.durable_sequence == 1
    assert_nothing_missing(recorder.close(), 1)


def test_errors_on_every_sync_end_the_session(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A disk that fails each part is given up, and no record of it is called safe."""
    monkeypatch.setenv(FAIL_SYNC_AFTER, "1")
    recorder = FailoverRecorder.start(tmp_path, "P01", {}, {})
    recorder.write(note(0), 1)
    with pytest.raises(RecordingFailedError, match=r"disk reported an error.*None of its 1 rec"):
        recorder.ensure_durable(PATIENCE_S)
    assert list(tmp_path.glob("*.mcap")) == []
