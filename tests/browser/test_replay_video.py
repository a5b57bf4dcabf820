"""A video of a twelve-robot trial: the pictures the participant saw, in any browser."""

from __future__ import annotations

import base64
import io
import json
import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pygame
import pytest
from scipy.ndimage import gaussian_filter

from cut_sessions import seen_session
from node_packages import install_packages
from patience import PATIENCE_S
from report_in_browser import TOOLS
from shown_pictures import SIZE, Gallery, Pixels, draw_without_window
from study.loading import load_protocol
from study.messages import messages_for
from study.recording.parts import read_whole_session
from study.screens import FleetScreen, Screen
from study.shell.replay.marks import Span, read_marks
from study.shell.replay.picture import Picture
from study.shell.replay.tape import Tape
from study.shell.replay.video import Cut, frames
from x11_driver import require_program

pytest.importorskip("av")

ROOT = Path(__file__).resolve().parents[2]
RATE = 20
LEAST_SSIM = 0.98


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[tuple[int, Screen]]]:
    """The smoke study by a simulated participant, and every screen that was shown."""
    return seen_session(tmp_path_factory.mktemp("filmed"), load_protocol("smoke"))


@pytest.fixture(scope="module")
def trial(session: tuple[Path, list[tuple[int, Screen]]]) -> Span:
    """A trial of twelve robots that the participant saw as tiles."""
    trials = read_marks(read_whole_session(session[0])).of_kind("trial")
    found = next(trial for trial in trials if trial.operated and "12 robots" in trial.label)
    shown = [s for t, s in session[1] if found.first_ns <= t < found.last_ns]
    assert sum(isinstance(s, FleetScreen) and len(s.tiles) == 12 for s in shown) > 30
    return found


@pytest.fixture(scope="module")
def plain(session: tuple[Path, list[tuple[int, Screen]]], trial: Span) -> list[Pixels]:
    """The frames before they are encoded."""
    draw_without_window()
    recording = read_whole_session(session[0])
    marks = read_marks(recording)
    picture = Picture(SIZE, marks, "participant", messages_for("en"))
    return list(frames(Tape(recording), picture, Cut(trial.first_ns, trial.last_ns, RATE)))


@pytest.fixture(scope="module")
def video(
    session: tuple[Path, list[tuple[int, Screen]]],
    trial: Span,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    """The video that the command writes."""
    target: Path = tmp_path_factory.mktemp("video") / "trial.webm"
    command = [sys.executable, "-m", "study.commands.main", "replay", str(session[0])]
    options = ["--participant-view", "--trial", str(trial.trial_id), "--rate", str(RATE)]
    done = subprocess.run(
        [*command, *options, "--video", str(target)],
        capture_output=True, text=True, check=False, cwd=ROOT, timeout=PATIENCE_S,
        env={**os.environ, "SDL_VIDEODRIVER": "dummy"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "frames of 1280x960 pixels written to" in done.stdout
    assert stat.S_IMODE(target.stat().st_mode) == 0o600
    assert list(target.parent.iterdir()) == [target]
    return target


def luma(pixels: Pixels) -> npt.NDArray[np.float64]:
    """Return the luma of BT.709, 0 to 255 [height, width]."""
    weighted: npt.NDArray[np.float64] = pixels @ np.array([0.2126, 0.7152, 0.0722])
    return weighted


def ssim(first: Pixels, second: Pixels) -> float:
    """Return the mean structural similarity of two pictures' luma.

    Source: Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From Error Visibility
    to Structural Similarity", IEEE Transactions on Image Processing 13(4), 2004: Gaussian window
    of 11 pixels and standard deviation 1.5.
    """

    def mean(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return gaussian_filter(values, 1.5, truncate=5 / 1.5)

    a, b = luma(first), luma(second)
    mean_a, mean_b = mean(a), mean(b)
    variances = mean(a * a) - mean_a**2 + mean(b * b) - mean_b**2
    covariance = mean(a * b) - mean_a * mean_b
    one, two = (0.01 * 255) ** 2, (0.03 * 255) ** 2
    similar = (2 * mean_a * mean_b + one) * (2 * covariance + two)
    return float((similar / ((mean_a**2 + mean_b**2 + one) * (variances + two))).mean())


def test_frames_are_the_gallerys_pictures(
    session: tuple[Path, list[tuple[int, Screen]]], trial: Span, plain: list[Pixels]
) -> None:
    """Before encoding each frame equals, pixel for pixel, the picture of the same screen."""
    gallery = Gallery(session[1])
    cut = Cut(trial.first_ns, trial.last_ns, RATE)
    assert len(plain) == cut.frames
    moved = 0
    for number, frame in enumerate(plain):
        assert (frame == gallery.at(cut.time_of(number))).all(), number
        moved += number > 0 and bool((frame != plain[number - 1]).any())
    # Between two timesteps robots move on.
    assert moved > 0.8 * len(plain)


def test_ssim_tells_pictures_apart(plain: list[Pixels]) -> None:
    """The measure itself: 1 for the same picture, little for another or a blurred one."""
    frame = plain[0]
    assert ssim(frame, frame) == pytest.approx(1.0)
    assert ssim(frame, 255 - frame) < 0.5
    blurred = gaussian_filter(frame.astype(np.float64), (2, 2, 0)).astype(np.uint8)
    assert ssim(frame, blurred) < 0.95


def test_decoded_frames_look_the_same(video: Path, plain: list[Pixels]) -> None:
    """Every frame is there, and of those looked at each is as similar as can be asked."""
    import av

    with av.open(str(video)) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name in ("vp9", "libvpx-vp9")
        decoded = [
            frame.to_ndarray(
                format="rgb24", src_colorspace="ITU709", dst_colorspace="ITU709",
                src_color_range="MPEG", dst_color_range="JPEG",
            )
            for frame in container.decode(stream)
        ]  # fmt: skip
    assert len(decoded) == len(plain)
    looked_at = [*range(0, len(plain), 8), len(plain) - 1]
    assert min(ssim(decoded[number], plain[number]) for number in looked_at) >= LEAST_SSIM


def test_it_plays_in_a_browser(video: Path, plain: list[Pixels]) -> None:
    """Headless Chromium plays it to its end and shows the same pictures, in the same colours."""
    node, chromium = require_program("node"), require_program("chromium")
    install_packages(TOOLS)
    asked = [0, len(plain) // 3, len(plain) - 1]
    times = [f"{(number + 0.5) / RATE:.4f}" for number in asked]
    command = [node, str(TOOLS / "play_video.mjs"), chromium, str(video), *times]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=PATIENCE_S)
    assert done.returncode == 0, done.stderr[-4000:]
    found: dict[str, Any] = json.loads(done.stdout)
    assert (found["width"], found["height"]) == SIZE
    assert found["duration"] == pytest.approx(len(plain) / RATE, abs=1.5 / RATE)
    assert found["played"] > 0
    for number, encoded in zip(asked, found["frames"], strict=True):
        image = pygame.image.load(io.BytesIO(base64.b64decode(encoded)), "frame.png")
        shown = pygame.surfarray.array3d(image).swapaxes(0, 1)
        assert ssim(shown, plain[number]) >= LEAST_SSIM
        # A wrong matrix or range would shift every colour.
        shift = np.abs(shown.astype(float).mean((0, 1)) - plain[number].mean((0, 1)))
        assert shift.max() < 2.0
