"""Writes a replay as a video: VP9 in WebM, which every browser plays."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
import pygame

from study.errors import StudyError
from study.shell.replay.picture import Picture
from study.shell.replay.strip import Shown
from study.shell.replay.tape import Tape

SECOND = 1_000_000_000
QUALITY = {"crf": "18", "b": "0", "deadline": "realtime", "cpu-used": "8", "row-mt": "1"}
"""Of libvpx: text stays sharp; faster than the replay on two cores."""
THREADS = 4
SMALLEST_SIDE, LARGEST_SIDE = 160, 7680
"""Of a video, pixels."""


@dataclasses.dataclass(frozen=True, slots=True)
class Cut:
    """What of a session a video shows.

    Attributes:
        first_ns, last_ns: session times.
        frames_per_second: of the video.
        speed: session seconds a second of the video.
    """

    first_ns: int
    last_ns: int
    frames_per_second: int = 30
    speed: float = 1.0

    @property
    def frames(self) -> int:
        """How many frames the video has; at least one."""
        seconds = (self.last_ns - self.first_ns) / SECOND / self.speed
        return max(1, round(seconds * self.frames_per_second))

    def time_of(self, frame: int) -> int:
        """Return the session time of a frame, counted from 0."""
        return self.first_ns + round(frame * SECOND * self.speed / self.frames_per_second)


def frames(tape: Tape, picture: Picture, cut: Cut) -> Iterator[npt.NDArray[np.uint8]]:
    """Yield the video's frames before they are encoded: uint8 [height, width, 3], red first."""
    surface = pygame.Surface(picture.size)
    for number in range(cut.frames):
        t_ns = cut.time_of(number)
        head = tape.go_to(t_ns)
        picture.draw(surface, Shown(head, t_ns, playing=True, speed=cut.speed))
        # Axes swapped: pygame counts columns first.
        yield np.ascontiguousarray(pygame.surfarray.pixels3d(surface).swapaxes(0, 1))


def write_video(
    tape: Tape,
    picture: Picture,
    cut: Cut,
    path: Path,
    progress: Callable[[int], object] = lambda _: None,
) -> None:
    """Write a video, readable by its owner alone; nobody ever sees half of it.

    Args:
        tape: of the session.
        picture: what draws it; both sides of its size are even.
        cut: which part, and how fast.
        path: of the new file.
        progress: told how many frames are written.

    Raises:
        StudyError: as `check_target`; or the file cannot be written.
    """
    av = check_target(path, picture.size)
    part = path.with_name(f".{path.name}.part")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        part.unlink(missing_ok=True)
        descriptor = os.open(part, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            with os.fdopen(descriptor, "w+b") as stream:
                _encode(av, _Told(stream), tape, picture, cut, progress)
            part.replace(path)
        finally:
            part.unlink(missing_ok=True)
    except (OSError, av.FFmpegError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise StudyError(f"{path} cannot be written: {reason}", "Give another place.") from error


def check_target(path: Path, size: tuple[int, int]) -> Any:  # noqa: ANN401 - an extra
    """Return the library that encodes, if it can write such a video.

    Raises:
        StudyError: it is not installed, the file is there, or a side is odd or no size at all.
    """
    if path.exists():
        raise StudyError(f"{path} is there already", "Give another name, or remove it.")
    if any(side % 2 or not SMALLEST_SIDE <= side <= LARGEST_SIDE for side in size):
        raise StudyError(
            f"a video of {size[0]}x{size[1]} pixels",
            f"Both sides must be even, from {SMALLEST_SIDE} to {LARGEST_SIDE}.",
        )
    try:
        import av  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise StudyError(
            "videos need the package av, which is not installed",
            'Install the extra "video": pip install "scaled-autonomy[video]", in a clone '
            "pip install -e '.[video]'.",
        ) from error
    return av


class _Told:
    """A file for PyAV, which tells a traceback of what its files raise: here it is kept for later.

    Attributes:
        failure: why nothing more is written; None while all is well.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.failure: OSError | None = None

    def write(self, data: bytes) -> int:
        """Write, or pretend to once that has failed."""
        if self.failure is None:
            try:
                self._stream.write(data)
                self._stream.flush()
            except OSError as error:
                self.failure = error
        return len(data)

    def seek(self, place: int, whence: int = 0) -> int:
        """Go to a place."""
        return self._stream.seek(place, whence) if self.failure is None else 0

    def tell(self) -> int:
        """Return the place."""
        return self._stream.tell() if self.failure is None else 0


def _encode(
    av: Any,  # noqa: ANN401
    stream: _Told,
    tape: Tape,
    picture: Picture,
    cut: Cut,
    progress: Callable[[int], object],
) -> None:
    with av.open(stream, "w", format="webm") as container:
        video = container.add_stream("libvpx-vp9", rate=cut.frames_per_second, options=QUALITY)
        video.width, video.height = picture.size
        video.pix_fmt = "yuv420p"
        video.codec_context.thread_count = THREADS
        video.codec_context.time_base = Fraction(1, cut.frames_per_second)
        # Said and meant: players take pictures of this size for BT.709 in video levels.
        video.codec_context.colorspace, video.codec_context.color_range = 1, 1
        video.codec_context.color_primaries = video.codec_context.color_trc = 1
        for number, pixels in enumerate(frames(tape, picture, cut)):
            frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
            frame = frame.reformat(
                format="yuv420p", src_colorspace="ITU709", dst_colorspace="ITU709",
                src_color_range="JPEG", dst_color_range="MPEG",
            )  # fmt: skip
            frame.pts, frame.time_base = number, Fraction(1, cut.frames_per_second)
            container.mux(video.encode(frame))
            progress(number + 1)
            if stream.failure is not None:
                break
        container.mux(video.encode(None))
    if stream.failure is not None:
        raise stream.failure
