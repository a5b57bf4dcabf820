"""The strip under an analyst's view: time, the session's and the trial's timeline, scores, keys."""

from __future__ import annotations

import dataclasses

import pygame

from study.screens import CountdownScreen, FleetScreen
from study.shell.drawing import marks as shapes
from study.shell.drawing import palette
from study.shell.drawing.canvas import Canvas
from study.shell.drawing.chrome import draw_cap, key_tokens
from study.shell.replay.head import Head
from study.shell.replay.marks import Marks
from study.shell.replay.player import KEYS
from study.shell.replay.score_bars import draw_score_bars
from study.shell.replay.timeline import Line, draw_key, draw_line

HEIGHT = 202
"""Design pixels."""
MARGIN = 16
SCORES_WIDTH = 320
PAGE_NS = 60_000_000_000
"""Where no trial runs the lower timeline shows the minute."""
SMALLEST_SCALE = 0.8


@dataclasses.dataclass(frozen=True, slots=True)
class Shown:
    """What the strip shows.

    Attributes:
        head: the session as it is.
        t_ns: session time.
        playing: whether time goes on.
        speed: session seconds a second.
        reading: share of the recording read through, where the replay waits for it; else -1.
    """

    head: Head
    t_ns: int
    playing: bool
    speed: float
    reading: float = -1.0


class Strip:
    """Draws the strip of one window size.

    Args:
        size: of the window, pixels.
        marks: of the session.
    """

    def __init__(self, size: tuple[int, int], marks: Marks) -> None:
        scale = max(SMALLEST_SCALE, min(size[0] / 1280, 2.0))
        height = round(HEIGHT * scale)
        self.place = pygame.Rect(0, size[1] - height, size[0], height)
        self._canvas = Canvas(self.place.size)
        self._canvas.rescale(scale)
        self._marks = marks
        self._lines: tuple[Line, ...] = ()

    def draw(self, surface: pygame.Surface, shown: Shown) -> None:
        """Draw the strip at the bottom of a window."""
        canvas = self._canvas
        canvas.begin()
        ground = canvas.surface
        ground.fill(palette.CARD)
        ground.fill(palette.LINE, (0, 0, ground.get_width(), max(1, canvas.u(1))))
        self._draw_head(shown)
        session, detail = self._lines = self._lines_at(shown.t_ns)
        draw_line(canvas, self._marks, session, shown.t_ns, "Session")
        trial = self._marks.at(shown.t_ns, "trial")
        name = "Trial" if trial else "Minute"
        draw_line(canvas, self._marks, detail, shown.t_ns, name, numbered=True)
        column = pygame.Rect(0, 0, canvas.u(SCORES_WIDTH - 2 * MARGIN), canvas.u(104))
        column.topright = (ground.get_width() - canvas.u(MARGIN), canvas.u(44))
        draw_score_bars(canvas, column, shown.head.scores, _operated(shown.head))
        self._draw_foot()
        surface.blit(ground, self.place)

    def time_at(self, x: float, y: float) -> int | None:
        """Return the session time that a place in the window means; None if it is on no line."""
        for line in self._lines:
            reach = line.place.inflate(0, line.place.height // 2)
            if reach.collidepoint(x - self.place.left, y - self.place.top):
                return line.time_at(x - self.place.left)
        return None

    def _lines_at(self, t_ns: int) -> tuple[Line, Line]:
        """Return the timeline of the session, and that of the trial or minute."""
        canvas = self._canvas
        left, height = canvas.u(MARGIN + 62), canvas.u(30)
        width = self.place.width - left - canvas.u(SCORES_WIDTH)
        session = pygame.Rect(left, canvas.u(50), width, height)
        detail = pygame.Rect(left, canvas.u(98), width, canvas.u(40))
        trial = self._marks.at(t_ns, "trial")
        first = t_ns // PAGE_NS * PAGE_NS
        span = (trial.first_ns, trial.last_ns) if trial else (first, first + PAGE_NS)
        return Line(session, 0, max(1, self._marks.last_ns)), Line(detail, *span)

    def _draw_head(self, shown: Shown) -> None:
        canvas, marks = self._canvas, self._marks
        y, size = canvas.u(24), canvas.u(19)
        _draw_state(canvas, canvas.u(MARGIN + 9), y, playing=shown.playing)
        times = f"{clock(shown.t_ns)} / {clock(marks.last_ns, tenths=False)}"
        place = canvas.write(times, canvas.u(MARGIN + 30), y, size, weight="semibold", tabular=True)
        place = canvas.write(f"{shown.speed:g}x", place.right + canvas.u(18), y, size,
                             weight="semibold", colour=palette.SECONDARY)  # fmt: skip
        words = self._where(shown)
        left = max(place.right + canvas.u(24), canvas.u(290))
        width = self.place.width - left - canvas.u(MARGIN)
        canvas.write(words, left, y, canvas.u(17), colour=palette.INK, width=width)

    def _where(self, shown: Shown) -> str:
        """Say in words where the session is, and whether something went wrong just now."""
        if shown.reading >= 0:
            return f"Reading the recording: {shown.reading:.0%}"
        marks, t_ns = self._marks, shown.t_ns
        stage = marks.at(t_ns, "survey") or marks.at(t_ns, "stage")
        spans = (stage, marks.at(t_ns, "trial"), marks.at(t_ns, "pause"))
        words = [marks.participant, *(span.label for span in spans if span is not None)]
        near = [fault.text for fault in marks.faults if abs(fault.t_ns - t_ns) < 3_000_000_000]
        return "   |   ".join([*words, *near[-1:]])

    def _draw_foot(self) -> None:
        canvas = self._canvas
        size, left = canvas.u(14), canvas.u(MARGIN)
        draw_key(canvas, left, self.place.height - canvas.u(44), size)
        y = self.place.height - canvas.u(18)
        for keys, what in KEYS:
            for key in key_tokens(keys):
                left += draw_cap(canvas, key, left, y, canvas.u(20)) + canvas.u(4)
            word = canvas.write(what, left + canvas.u(3), y, size, colour=palette.SECONDARY)
            left = word.right + canvas.u(18)


def clock(t_ns: int, *, tenths: bool = True) -> str:
    """Return a session time as "12:34.5"."""
    # Cut off, not rounded: the picture shown is never later than what is written.
    tens = t_ns // 100_000_000
    minutes, rest = divmod(tens, 600)
    seconds = f"{rest // 10:02d}.{rest % 10}" if tenths else f"{rest // 10:02d}"
    return f"{minutes}:{seconds}"


def _operated(head: Head) -> int:
    """Return the index of the operated robot; -1 if there is none."""
    screen = head.screen
    if isinstance(screen, CountdownScreen):
        screen = screen.fleet
    return screen.operated if isinstance(screen, FleetScreen) else -1


def _draw_state(canvas: Canvas, x: float, y: float, *, playing: bool) -> None:
    """Draw whether it plays: a triangle, or the two bars of a pause."""
    size = canvas.u(18)
    if playing:
        shapes.triangle_right(canvas, x, y, size, palette.INK)
        return
    for side in (-1, 1):
        bar = pygame.Rect(0, 0, canvas.u(5), canvas.u(16))
        bar.center = (round(x + side * canvas.u(5)), round(y))
        canvas.surface.fill(palette.INK, bar)
