"""The figure of a plan: power against participants, a line for each number of trials."""

from __future__ import annotations

from analysis.figures.svg import Drawing, Scale, panel_title, tone, vertical_axis
from analysis.planning.plan import Plan
from analysis.planning.power import Cell

WIDTH, HEIGHT = 920.0, 372.0
LEFT, RIGHT, TOP, BOTTOM = 44.0, 770.0, 36.0, 306.0
APART = 26.0
"""Least distance of two numbers along the axis, px."""


def power_curves(plan: Plan) -> Drawing:
    """Draw every cell with its Monte-Carlo interval, and the closed form as a dashed line."""
    drawing = Drawing(
        "power",
        WIDTH,
        HEIGHT,
        "Power against the number of participants, a line for each number of trials, with 95% "
        "Monte-Carlo intervals",
    )
    panel_title(drawing, 0.0, "", "Power", "share of simulated studies")
    counts = sorted({cell.design.participants for cell in plan.cells})
    trials = sorted({cell.design.trials for cell in plan.cells})
    up = Scale([0.0, 1.0], BOTTOM, TOP, ticks=6)
    vertical_axis(drawing, up, LEFT, RIGHT)
    along = Scale(counts, LEFT + 24, RIGHT - 24, ticks=9)
    last = -APART
    for count in counts:
        if along(count) - last >= APART:
            last = along(count)
            drawing.text((last, BOTTOM + 20), f"{count}", "f-quiet", "middle", 11.5)
    drawing.text(((LEFT + RIGHT) / 2, BOTTOM + 42), "participants", "f-quiet", "middle", 11.5)
    level = up(plan.wanted.power)
    drawing.line((LEFT, level), (RIGHT, level), "s-ink dashed")
    drawing.text((LEFT + 4, level - 6), f"wanted {plan.wanted.power:g}", "f-ink", size=11.5)
    ends = []
    for at, each in enumerate(trials):
        cells = sorted(
            (cell for cell in plan.cells if cell.design.trials == each),
            key=lambda cell: cell.design,
        )
        shift = 2.4 * (at - (len(trials) - 1) / 2)
        _line(drawing, cells, tone(at), up, along, shift)
        ends.append((up(cells[-1].power), each, tone(at)))
    _names(drawing, ends)
    if plan.chosen is not None:
        at = trials.index(plan.chosen.design.trials)
        shift = 2.4 * (at - (len(trials) - 1) / 2)
        place = (along(plan.chosen.design.participants) + shift, up(plan.chosen.power))
        drawing.circle(place, 9.0, "none s-ink ring")
    drawing.line((LEFT, HEIGHT - 10), (LEFT + 26, HEIGHT - 10), "s-quiet thin-dash")
    drawing.text((LEFT + 34, HEIGHT - 6), "closed form", "f-quiet", size=11.5)
    drawing.circle((LEFT + 140, HEIGHT - 10), 3.6, "f-quiet")
    drawing.text((LEFT + 150, HEIGHT - 6), "simulated, 95% interval", "f-quiet", size=11.5)
    if plan.chosen is not None:
        drawing.circle((LEFT + 320, HEIGHT - 10), 7.0, "none s-ink ring")
        drawing.text((LEFT + 334, HEIGHT - 6), "smallest that reaches it", "f-quiet", size=11.5)
    return drawing


def _line(
    drawing: Drawing, cells: list[Cell], colour: str, up: Scale, along: Scale, shift: float
) -> None:
    known = [
        (along(cell.design.participants) + shift, up(cell.formula.power))
        for cell in cells
        if cell.formula is not None
    ]
    if len(known) > 1:
        drawing.polyline(known, f"s-{colour} thin-dash")
    for cell in cells:
        x = along(cell.design.participants) + shift
        bounds = cell.interval
        drawing.line((x, up(bounds.low)), (x, up(bounds.high)), f"s-{colour} medium")
    points = [(along(cell.design.participants) + shift, up(cell.power)) for cell in cells]
    if len(points) > 1 and len(known) < 2:
        drawing.polyline(points, f"s-{colour} medium")
    for point in points:
        drawing.circle(point, 3.6, f"f-{colour} s-paper")


def _names(drawing: Drawing, ends: list[tuple[float, int, str]]) -> None:
    """Write the trials at the end of each line, apart from each other."""
    ends = sorted(ends)
    places = [y for y, _, _ in ends]
    for at in range(1, len(places)):
        places[at] = max(places[at], places[at - 1] + 16)
    over = max(0.0, places[-1] - BOTTOM)
    for y, (_, trials, colour) in zip(places, ends, strict=True):
        word = "trial" if trials == 1 else "trials"
        text = f"{trials} {word} a condition"
        drawing.text((RIGHT + 10, y + 4 - over), text, f"t-{colour} bold", size=11.5)
