"""The figures of an experiment's report."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.experiment.contrasts import Mean, mean_of
from analysis.experiment.frames import NONE, Experiment
from analysis.experiment.paper import CLASSIFIER_TOP1, LUCE_TOP1
from analysis.experiment.questions import policies_at, runs_at
from analysis.figures.svg import Drawing, Scale, panel_title, vertical_axis

WIDTH = 920.0
LABELS = 150.0
ROW = 27.0
TOP = 52.0
MARKS = ("c1", "c0", "c2", "c3")


def two_panels(experiment: Experiment) -> Drawing:
    """Draw the paper's two panels: what the fleet earns, and then what its policy earns alone."""
    height = TOP + ROW * len(experiment.scorers) + 46
    drawing = Drawing(
        "panels",
        WIDTH,
        height,
        "Mean team reward in phase three and mean reward of the retrained policies in phase four, "
        "for each scorer, with 95% intervals",
    )
    panels = (
        ("a", "Phase three: team reward", "points a run", LABELS, 522.0, runs_at, "team_reward"),
        ("b", "Phase four: policy alone", "points an episode", 562.0, 906.0, policies_at,
         "policy_reward"),
    )  # fmt: skip
    for letter, title, unit, left, right, rows_at, measure in panels:
        panel_title(drawing, left, letter, title, unit)
        marks = []
        for place, dwell in enumerate(experiment.dwells):
            frame = rows_at(experiment, dwell)
            marks.append(
                (
                    MARKS[place % len(MARKS)],
                    [
                        mean_of(frame[frame["scorer"] == name][measure])
                        if place == 0 or name != NONE
                        else None
                        for name in experiment.scorers
                    ],
                )
            )
        _dots(drawing, marks, left, right, zero=False)
    _names(drawing, [experiment.label(name) for name in experiment.scorers])
    _legend(drawing, experiment, height)
    return drawing


def agreement(experiment: Experiment) -> Drawing:
    """Draw top-1 agreement in both sets of states; the paper's numbers are dashed."""
    scorers = [name for name in experiment.scorers if name != NONE]
    height = TOP + ROW * len(scorers) + 46
    drawing = Drawing(
        "agreement",
        WIDTH,
        height,
        "Top-1 agreement of each scorer with ground truth, 95% intervals",
    )
    robots = int(experiment.protocol["phase_three"]["robots"])
    lines = [
        (1 / robots, "chance"),
        (CLASSIFIER_TOP1, "paper’s classifier"),
        (LUCE_TOP1, "paper’s Luce"),
    ]
    panels = (
        ("a", "States of its own fleet", LABELS, 522.0, "own_agreement", experiment.dwells),
        ("b", "States of ground truth’s fleet", 562.0, 906.0, "reference_agreement",
         experiment.dwells[:1]),
    )  # fmt: skip
    for letter, title, left, right, measure, dwells in panels:
        panel_title(drawing, left, letter, title, "share of timesteps")
        marks = []
        for place, dwell in enumerate(dwells):
            frame = runs_at(experiment, dwell)
            marks.append(
                (
                    MARKS[place % len(MARKS)],
                    [mean_of(frame[frame["scorer"] == name][measure]) for name in scorers],
                )
            )
        scale = _dots(drawing, marks, left, right, zero=True, upto=1.0)
        bottom = TOP + ROW * len(scorers)
        for value, words in lines:
            drawing.line((scale(value), TOP - 12), (scale(value), bottom), "s-quiet dashed")
            drawing.text((scale(value), TOP - 17), words, "f-quiet", "middle", 10.5)
    _names(drawing, [experiment.label(name) for name in scorers])
    _legend(drawing, experiment, height)
    return drawing


def sensitivity(experiment: Experiment) -> Drawing | None:
    """Draw agreement against each dial; None without such trials."""
    table = experiment.tables["sensitivity"]
    if table.empty:
        return None
    titles = {
        "temperature": ("Temperature", "points"),
        "choices": ("Choices", "phase two"),
        "hidden": ("Smoothness of phi", "units a layer"),
    }
    dials = [dial for dial in titles if (table["dial"] == dial).any()]
    scorers = list(dict.fromkeys(table["scorer"]))
    height, bottom, top = 300.0, 240.0, 34.0
    drawing = Drawing(
        "sensitivity", WIDTH, height, "Top-1 agreement as one dial at a time is turned"
    )
    scale = Scale([0.0, 1.0], bottom, top, ticks=6)
    width = (WIDTH - 40) / len(dials)
    for panel, dial in enumerate(dials):
        left, right = 40 + panel * width, 40 + (panel + 1) * width - 42
        panel_title(drawing, left, "abc"[panel], *titles[dial])
        vertical_axis(drawing, scale, left, right)
        here = table[table["dial"] == dial]
        settings = sorted(set(here["setting"]))
        step = (right - left) / len(settings)
        places = {value: left + (at + 0.5) * step for at, value in enumerate(settings)}
        for value, x in places.items():
            drawing.text((x, bottom + 18), f"{value:g}", "f-quiet", "middle", 11.5)
        for at, scorer in enumerate(scorers):
            mine = here[here["scorer"] == scorer]
            colour = MARKS[at % len(MARKS)]
            for measure, line in (("own_agreement", ""), ("reference_agreement", " thin-dash")):
                shift = (-4.0 if measure == "own_agreement" else 4.0) + (3.0 * at - 1.5)
                points = []
                for value in settings:
                    mean = mean_of(mine[mine["setting"] == value][measure])
                    x = places[value] + shift
                    points.append((x, scale(mean.value)))
                    if mean.interval is not None:
                        # Of few trials an interval can reach beyond what a share can be.
                        shown = mean.interval.within(0.0, 1.0)
                        drawing.line((x, scale(shown.low)), (x, scale(shown.high)), f"s-{colour}")
                drawing.polyline(points, f"s-{colour} medium{line}")
                for point in points:
                    fill = f"f-{colour} s-paper" if not line else f"f-paper s-{colour}"
                    drawing.circle(point, 3.6, fill)
    x = 40.0
    for at, scorer in enumerate(scorers):
        colour = MARKS[at % len(MARKS)]
        drawing.circle((x + 6, 281), 4, f"f-{colour}")
        label = experiment.label(scorer)
        drawing.text((x + 16, 285), label, "f-ink", size=11.5)
        x += 40 + 6.6 * len(label)
    drawing.text(
        (x, 285), "solid: own fleet’s states; dashed: ground truth’s", "f-quiet", size=11.5
    )
    return drawing


def fleet_sizes(experiment: Experiment) -> Drawing | None:
    """Draw what an operator's help adds against the size of the fleet; None without trials."""
    table = experiment.tables["fleet_sizes"]
    table = table[table["scorer"] != NONE]
    if table.empty:
        return None
    sizes = sorted(set(table["robots"]))
    scorers = [name for name in experiment.scorers if (table["scorer"] == name).any()]
    height, bottom, left, right = 320.0, 262.0, 60.0, 700.0
    drawing = Drawing("sizes", WIDTH, height, "Points that one operator adds, by size of the fleet")
    means = {
        (name, size): mean_of(table[(table["scorer"] == name) & (table["robots"] == size)]["gain"])
        for name in scorers
        for size in sizes
    }
    reach = [m.value for m in means.values()]
    reach += [e for m in means.values() if m.interval for e in (m.interval.low, m.interval.high)]
    scale = Scale(reach, bottom, 34.0, zero=True)
    panel_title(drawing, left, "", "Points that one operator adds to a run", "")
    vertical_axis(drawing, scale, left, right)
    step = (right - left) / len(sizes)
    for at, size in enumerate(sizes):
        x = left + (at + 0.5) * step
        drawing.text((x, bottom + 18), f"{size:,}".replace(",", " "), "f-quiet", "middle", 11.5)
    drawing.text(((left + right) / 2, bottom + 40), "Robots", "f-quiet", "middle", 11.5)
    drawing.line((left, scale(0)), (right, scale(0)), "s-ink")
    ends: list[tuple[float, str, str]] = []
    for at, name in enumerate(scorers):
        colour = ("c1", "c0", "c2", "c3", "c4", "c5")[at % 6]
        points = []
        for place, size in enumerate(sizes):
            mean = means[(name, size)]
            x = left + (place + 0.5) * step + 4 * (at - (len(scorers) - 1) / 2)
            points.append((x, scale(mean.value)))
            if mean.interval is not None:
                low, high = scale(mean.interval.low), scale(mean.interval.high)
                drawing.line((x, low), (x, high), f"s-{colour}")
        drawing.polyline(points, f"s-{colour} medium")
        for point in points:
            drawing.circle(point, 3.8, f"f-{colour} s-paper")
        ends.append((points[-1][1], experiment.label(name), colour))
    y = 0.0
    for end, label, colour in sorted(ends):
        y = max(end + 4, y + 17)
        drawing.text((right + 12, y), label, f"t-{colour} bold", size=12)
    return drawing


def _dots(
    drawing: Drawing,
    marks: Sequence[tuple[str, Sequence[Mean | None]]],
    left: float,
    right: float,
    *,
    zero: bool,
    upto: float | None = None,
) -> Scale:
    """Draw means with intervals, a row each and a mark a dwell; from 0 to ``upto`` if given."""
    reach = [0.0, upto] if upto is not None else []
    for _, means in marks if upto is None else ():
        for mean in means:
            if mean is not None:
                reach.append(mean.value)
                reach += [mean.interval.low, mean.interval.high] if mean.interval else []
    scale = Scale(reach, left + 6, right - 6, ticks=6, zero=zero)
    rows = max(len(means) for _, means in marks)
    bottom = TOP + ROW * rows
    for tick in scale.ticks:
        drawing.line((scale(tick), TOP - 6), (scale(tick), bottom), "s-rule")
        drawing.text((scale(tick), bottom + 17), scale.label(tick), "f-quiet", "middle", 11.5)
    for place, (colour, means) in enumerate(marks):
        shift = 8.0 * (place - (len(marks) - 1) / 2)
        for row, mean in enumerate(means):
            if mean is None:
                continue
            y = TOP + ROW * (row + 0.5) + (shift if len(marks) > 1 else 0.0)
            if mean.interval is not None:
                shown = mean.interval if upto is None else mean.interval.within(0.0, upto)
                drawing.line((scale(shown.low), y), (scale(shown.high), y), f"s-{colour} medium")
            drawing.circle((scale(mean.value), y), 4.2, f"f-{colour} s-paper")
    return scale


def _names(drawing: Drawing, labels: Sequence[str]) -> None:
    for row, label in enumerate(labels):
        y = TOP + ROW * (row + 0.5)
        drawing.text((0, y + 4), label, "f-ink", size=12)


def _legend(drawing: Drawing, experiment: Experiment, height: float) -> None:
    x = LABELS
    for place, dwell in enumerate(experiment.dwells):
        colour = MARKS[place % len(MARKS)]
        words = "choosing anew at every timestep" if dwell == 1 else f"dwell {dwell}"
        drawing.circle((x + 5, height - 8), 4.2, f"f-{colour}")
        drawing.text((x + 15, height - 4), words, "f-quiet", size=11.5)
        x += 44 + 6.3 * len(words)
