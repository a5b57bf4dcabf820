"""What `study replay` refuses, and how: one message, a status, never a traceback."""

from __future__ import annotations

import shutil
import stat
import subprocess
from pathlib import Path

import pytest

from command_line import study
from cut_sessions import seen_session
from protocols import ROOT


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session in several chunks."""
    return seen_session(tmp_path_factory.mktemp("recorded"), pause_s=0.005)[0]


def replay(*arguments: str | Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command."""
    return study("replay", *arguments, environment=environment)


def test_no_display_is_said(recording: Path) -> None:
    """Exit status 2: nothing was watched."""
    done = replay(recording, DISPLAY="", SDL_VIDEODRIVER="x11")
    assert done.returncode == 2
    assert "no window can be opened" in done.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--speed", "3"], "a speed of 3"),
        (["--trial", "99"], "no trial 99 in the session"),
        (["--from", "noon"], 'time "noon"'),
        (["--from", "9:99"], 'time "9:99"'),
        (["--from", "5:00", "--to", "4:00"], "give --from before --to"),
        (["--from", "99999"], "The session lasts"),
        (["--size", "800x600"], "It needs at least 1280x720"),
        (["--size", "99999x99999"], "It has at most 7680x4320"),
        (["--size", "big"], 'window size "big"'),
        (["--ui-scale", "9"], "a UI scale of 9"),
        (["--verify", "--video", "x.webm"], "Ask for one at a time"),
        (["--video", "x.mp4"], "Name it x.webm"),
        (["--video", "x.webm", "--size", "1281x721"], "Both sides must be even"),
    ],
)
def test_wishes_that_cannot_be_met(recording: Path, options: list[str], words: str) -> None:
    """Each is one message that says what was given and what to do."""
    done = replay(recording, *options)
    assert done.returncode == 2
    assert done.stderr.startswith("Error: ")
    assert words in done.stderr


def test_several_recordings_are_not_watched_at_once(recording: Path) -> None:
    """One at a time, or verified."""
    done = replay(recording, recording)
    assert done.returncode == 2
    assert "Give one, or say --verify." in done.stderr


def test_a_folder_is_verified_whole_and_not_watched(recording: Path, tmp_path: Path) -> None:
    """All recordings of a folder are compared; watching asks for one; an empty one is refused."""
    folder = tmp_path / "recordings"
    folder.mkdir()
    assert "no recordings in" in replay(folder, "--verify").stderr
    names = ("x_P01_20260101T000000_0001.mcap", "x_P02_20260101T000000_0002.mcap")
    for name in names:
        shutil.copy(recording, folder / name)
    done = replay(folder, "--verify")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("Identical") == 2
    (folder / names[1]).write_bytes(recording.read_bytes()[:-4000])
    assert replay(folder, "--verify").returncode == 1
    watched = replay(folder)
    assert watched.returncode == 2
    assert "is a folder, of 2 recordings" in watched.stderr


@pytest.mark.parametrize("damage", ["missing", "empty", "text"])
def test_what_is_no_recording_is_refused(tmp_path: Path, damage: str) -> None:
    """The message names the file."""
    path = tmp_path / "x.mcap"
    if damage != "missing":
        path.write_bytes(b"" if damage == "empty" else b"no recording\n" * 50)
    done = replay(path)
    assert done.returncode == 2
    assert str(path) in done.stderr


def test_without_the_extra_words_say_how_to_get_it(recording: Path, tmp_path: Path) -> None:
    """Nothing is written."""
    (tmp_path / "av.py").write_text("raise ImportError('made up')\n")
    target = tmp_path / "x.webm"
    done = replay(recording, "--video", target, PYTHONPATH=f"{tmp_path}:{ROOT}")
    assert done.returncode == 2
    assert "scaled-autonomy[video]" in done.stderr
    assert not target.exists()


class TestVideo:
    """Videos that are written."""

    @pytest.fixture(autouse=True)
    def _encoder(self) -> None:
        pytest.importorskip("av")

    def test_a_span_at_a_size_and_rate(self, recording: Path, tmp_path: Path) -> None:
        """As many frames as asked for, private, and never over another file."""
        import av

        target = tmp_path / "new" / "x.webm"
        options = ["--from", "0:02", "--to", "4.5", "--rate", "8", "--size", "1280x720"]
        done = replay(recording, "--video", target, *options)
        assert done.returncode == 0, done.stderr
        assert "20 frames of 1280x720 pixels written to" in done.stdout
        assert stat.S_IMODE(target.stat().st_mode) == 0o600
        with av.open(str(target)) as container:
            frames = list(container.decode(video=0))
        assert len(frames) == 20
        assert float(frames[8].time) == pytest.approx(1.0, abs=0.002)
        before = target.read_bytes()
        done = replay(recording, "--video", target, *options)
        assert done.returncode == 2
        assert "is there already" in done.stderr
        assert target.read_bytes() == before

    def test_faster_means_fewer_frames(self, recording: Path, tmp_path: Path) -> None:
        """At 4 times the speed a second of video holds four of the session."""
        options = ["--from", "0", "--to", "8", "--rate", "5", "--speed", "4"]
        done = replay(recording, "--video", tmp_path / "x.webm", "--participant-view", *options)
        assert done.returncode == 0, done.stderr
        assert "10 frames of 1280x960 pixels" in done.stdout

    def test_a_torn_recording_gives_what_there_is(self, recording: Path, tmp_path: Path) -> None:
        """With words, and exit status 3."""
        torn = tmp_path / "torn.mcap"
        data = recording.read_bytes()
        torn.write_bytes(data[: len(data) * 2 // 3])
        done = replay(torn, "--video", tmp_path / "x.webm", "--rate", "1", "--speed", "16")
        assert done.returncode == 3, done.stderr
        assert "Not whole:" in done.stderr
        assert (tmp_path / "x.webm").stat().st_size > 1000

    def test_a_place_that_cannot_be_written(self, recording: Path, tmp_path: Path) -> None:
        """The message says why."""
        (tmp_path / "file").write_text("")
        done = replay(recording, "--video", tmp_path / "file" / "x.webm", "--to", "1")
        assert done.returncode == 2
        assert "is a file; a folder is wanted" in done.stderr
