"""Diverging bars of answers, centred on the neutral answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from analysis.figures.svg import Drawing, tone
from analysis.instruments import Item
from analysis.statistics.likert import LikertRow

WIDTH = 920.0
NAME_LEFT, LABEL_RIGHT = 0.0, 316.0
BAR_LEFT, BAR_RIGHT = 332.0, 800.0
MEAN_RIGHT, SHARE_RIGHT = 872.0, 920.0
ROW, BAR = 24.0, 16.0


def item_label(item: str, occasion: str) -> str:
    """Return an item as the tables call it: Q1, or Q1* after the reveal."""
    return item.upper() + ("*" if occasion == "after_reveal" else "")


def rating_bars(
    name: str, rows: Sequence[LikertRow], labels: Sequence[str], items: Mapping[str, Item]
) -> Drawing:
    """Draw a bar for each item, occasion and condition.

    Args:
        name: unique in the page.
        rows: the items on their occasions, in order.
        labels: the conditions' labels.
        items: what was asked, by id.
    """
    shown = [row for row in rows if row.cells.n]
    k = len(labels)
    block = k * ROW + 14
    low, high = _scale_of(shown, items)
    drawing = Drawing(
        name, WIDTH, 34 + len(shown) * block + 44, "Answers under each condition as diverging bars"
    )
    neutral = (low + high) / 2
    widest = max((_reach(row, neutral) for row in shown), default=1.0)
    middle = (BAR_LEFT + BAR_RIGHT) / 2
    unit = (BAR_RIGHT - BAR_LEFT) / 2 / max(widest, 1.0)
    drawing.text((NAME_LEFT, 14), "Item", "f-ink bold", size=12)
    drawing.text((middle - 70, 14), "← disagree", "f-ink bold", "end", 12)
    drawing.text((middle, 14), "neutral", "f-ink bold", "middle", 12)
    drawing.text((middle + 70, 14), "agree →", "f-ink bold", "start", 12)
    drawing.text((MEAN_RIGHT, 14), "Mean", "f-ink bold", "end", 12)
    drawing.text((SHARE_RIGHT, 14), f"≥ {int(neutral) + 1}", "f-ink bold", "end", 12)
    drawing.line((0, 24), (WIDTH, 24), "s-ink")
    drawing.line((middle, 26), (middle, 34 + len(shown) * block), "s-quiet dotted")
    y = 36.0
    for row in shown:
        heading = item_label(row.item, row.occasion)
        drawing.text((NAME_LEFT, y + 12), heading, "f-ink bold", size=12)
        when = row.occasion.replace("_", " ")
        drawing.text((NAME_LEFT, y + 29), when, "f-quiet", size=11.5)
        for place in range(k):
            answers = row.cells.means[:, place]
            drawing.text((LABEL_RIGHT, y + 12), labels[place], f"t-{tone(place)}", "end", 12)
            _bar(drawing, answers, (low, high), neutral=neutral, middle=middle, unit=unit, y=y)
            mean = float(np.mean(np.sort(answers)))
            drawing.text((MEAN_RIGHT, y + 12), f"{mean:.2f}", f"t-{tone(place)}", "end", 12)
            above = int((answers > neutral).sum())
            drawing.text((SHARE_RIGHT, y + 12), f"{above} / {answers.size}", "f-ink", "end", 12)
            y += ROW
        y += 14
    _legend(drawing, (low, high), middle, y + 4, items)
    return drawing


def answer_class(value: int, low: int, high: int) -> str:
    """Return the class of an answer's colour on the seven-step diverging scale."""
    share = (value - low) / (high - low)
    return f"f-a{round(share * 6) + 1}"


def _bar(
    drawing: Drawing,
    answers: np.ndarray,
    bounds: tuple[int, int],
    *,
    neutral: float,
    middle: float,
    unit: float,
    y: float,
) -> None:
    low, high = bounds
    counts = [(value, int((np.rint(answers) == value).sum())) for value in range(low, high + 1)]
    below = sum(count for value, count in counts if value < neutral)
    centre = sum(count for value, count in counts if value == neutral)
    x = middle - unit * (below + centre / 2)
    for value, count in counts:
        if count == 0:
            continue
        width = unit * count
        shade = answer_class(value, low, high)
        drawing.rect((x, y), max(width - 1.5, 0.5), BAR, shade)
        dark = f"on-{shade[2:]}"
        drawing.text((x + width / 2 - 0.75, y + 12), str(count), dark, "middle", 11.5)
        x += width


def _reach(row: LikertRow, neutral: float) -> float:
    """Return the longest half of a row's bars, in answers."""
    means = row.cells.means
    centre = (means == neutral).sum(axis=0) / 2
    halves = [(means < neutral).sum(axis=0) + centre, (means > neutral).sum(axis=0) + centre]
    return float(np.max(halves))


def _scale_of(rows: Sequence[LikertRow], items: Mapping[str, Item]) -> tuple[int, int]:
    known = [items[row.item] for row in rows if row.item in items]
    if known:
        return min(item.low for item in known), max(item.high for item in known)
    largest = max((float(row.cells.means.max()) for row in rows), default=7.0)
    return 1, max(7, int(largest))


def _legend(
    drawing: Drawing, bounds: tuple[int, int], middle: float, y: float, items: Mapping[str, Item]
) -> None:
    low, high = bounds
    words = next((item.labels for item in items.values() if item.labels), {})
    step = 40.0
    left = middle - step * (high - low + 1) / 2
    for place, value in enumerate(range(low, high + 1)):
        x = left + place * step
        drawing.rect((x, y), step - 1.5, 10, answer_class(value, low, high))
        drawing.text((x + step / 2, y + 25), str(value), "f-quiet", "middle", 11.5)
    drawing.text((left - 8, y + 9), words.get(str(low), "").lower(), "f-quiet", "end", 11.5)
    right = left + step * (high - low + 1)
    drawing.text((right + 8, y + 9), words.get(str(high), "").lower(), "f-quiet", "start", 11.5)
