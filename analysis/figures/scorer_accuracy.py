"""Held-out accuracy of each participant's scorer, with its interval, against chance."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from analysis.figures.svg import Drawing, Scale
from analysis.formatting import fraction
from analysis.statistics.proportion import wilson
from analysis.statistics.result import Interval

WIDTH = 920.0
LEFT, RIGHT = 130.0, 640.0
ROW = 22.0


@dataclasses.dataclass(frozen=True, slots=True)
class Accuracy:
    """How often one scorer named the robot chosen, on choices that it never saw.

    Attributes:
        participant: whose it is.
        scorer: its name.
        top1: share of held-out choices.
        held_out: how many there were; None if not recorded.
        choices: on how many it was fitted; None if not recorded.
        chance: what guessing would reach; None if not known.
        over_trials: interval that takes a held-out trial for one observation; None with fewer
            than three, or where trials were not recorded.
    """

    participant: str
    scorer: str
    top1: float
    held_out: int | None
    choices: int | None
    chance: float | None
    over_trials: Interval | None = None

    @property
    def interval(self) -> Interval | None:
        """The interval over trials, else Wilson's 95 % (1927); None without a number held out."""
        if self.over_trials is not None:
            return self.over_trials.within(0.0, 1.0)
        if not self.held_out:
            return None
        return wilson(self.top1, self.held_out)

    @property
    def beats_chance(self) -> bool | None:
        """Whether the interval lies above chance; None if that is not known."""
        if self.interval is None or self.chance is None:
            return None
        return self.interval.low > self.chance

    @property
    def below_chance(self) -> bool:
        """Whether the interval lies below chance, for certain."""
        if self.interval is None or self.chance is None:
            return False
        return self.interval.high < self.chance


def accuracy_dots(name: str, rows: Sequence[Accuracy]) -> Drawing:
    """Draw a dot with its interval for each scorer; chance is a dashed line."""
    height = 30 + ROW * len(rows) + 46
    title = f"Held-out top-1 accuracy of {len(rows)} scorers with 95% intervals"
    drawing = Drawing(name, WIDTH, height, title)
    scale = Scale([0.0, 1.0], LEFT, RIGHT, ticks=5)
    bottom = 30 + ROW * len(rows)
    drawing.text((0, 14), "Participant", "f-ink bold", size=12)
    drawing.text((740, 14), "Top-1 [95% CI]", "f-ink bold", "end", 12)
    drawing.text((830, 14), "Held out", "f-ink bold", "end", 12)
    drawing.text((WIDTH, 14), "Fitted on", "f-ink bold", "end", 12)
    drawing.line((0, 24), (WIDTH, 24), "s-ink")
    for tick in scale.ticks:
        drawing.line((scale(tick), 26), (scale(tick), bottom), "s-rule")
        drawing.text((scale(tick), bottom + 17), f"{tick:g}", "f-quiet", "middle", 11.5)
    drawing.text(
        ((LEFT + RIGHT) / 2, bottom + 35), "Held-out choices named", "f-quiet", "middle", 11.5
    )
    # Where robots were lost chance differs a little from participant to participant.
    chances = sorted({round(row.chance, 2) for row in rows if row.chance is not None})
    for place in chances:
        drawing.line((scale(place), 26), (scale(place), bottom), "s-quiet dashed")
        drawing.text((scale(place) + 4, 20), f"chance {fraction(place)}", "f-quiet", size=11)
    for place, row in enumerate(rows):
        y = 30 + ROW * (place + 0.5)
        doubtful = row.beats_chance is False
        tone, mark = ("t-c0", "c0") if doubtful else ("f-ink", "c1")
        drawing.text(
            (0, y + 4), row.participant[:18], f"{tone} bold" if doubtful else tone, size=12
        )
        written = fraction(row.top1)
        if row.interval is not None:
            drawing.line(
                (scale(row.interval.low), y), (scale(row.interval.high), y), f"s-{mark} medium"
            )
            low, high = fraction(row.interval.low), fraction(row.interval.high)
            written += f" [{low}, {high}]"
        drawing.circle((scale(row.top1), y), 4.2, f"f-{mark} s-paper")
        drawing.text((740, y + 4), written, tone, "end", 12)
        drawing.text((830, y + 4), _count(row.held_out), "f-ink", "end", 12)
        drawing.text((WIDTH, y + 4), _count(row.choices), "f-ink", "end", 12)
    return drawing


def _count(number: int | None) -> str:
    return "–" if number is None else str(number)
