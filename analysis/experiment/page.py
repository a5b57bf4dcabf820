"""The report of an experiment: one HTML file, the same bytes for the same results."""

from __future__ import annotations

import dataclasses
import json

from analysis.environment import PACKAGES, analysis_files, digest, version_of
from analysis.experiment import figures
from analysis.experiment.contrasts import Contrast, Mean, mean_of
from analysis.experiment.frames import NONE, Experiment
from analysis.experiment.paper import beside_the_paper, in_words, policy_means
from analysis.experiment.questions import PREDICTION, REWARD, hypotheses, runs_at
from analysis.formatting import NO_BREAK, interval, number
from analysis.page import frame, page_environment
from analysis.statistics.result import Interval
from study.trial_files import results_sha256


@dataclasses.dataclass(frozen=True, slots=True)
class ScorerRow:
    """One scorer at one dwell: means over trials."""

    label: str
    dwell: int
    reward: Mean
    own: Mean
    reference: Mean
    goals: Mean
    lost: Mean
    policy: Mean
    impact: Mean


@dataclasses.dataclass(frozen=True, slots=True)
class SizeRow:
    """One fleet size: the points that each scorer's help adds."""

    robots: int
    gains: tuple[Mean, ...]


def render_experiment(experiment: Experiment) -> str:
    """Return an experiment's report as HTML."""
    environment = page_environment()
    environment.filters.update(mean=mean_text, scaled=in_percent)
    tests = hypotheses(experiment)
    head = experiment.results.head
    sizes = size_rows(experiment)
    sections = [
        ("summary", "Summary"),
        ("panels", "Reward and data impact"),
        ("agreement", "Agreement"),
        ("hypotheses", "Hypotheses"),
        ("sensitivity", "Sensitivity"),
        ("sizes", "Fleet size"),
        ("worlds", "Worlds"),
        ("assumptions", "Assumptions"),
        ("provenance", "Provenance"),
    ]
    page = environment.get_template("experiment.html.j2").render(
        **frame(environment, "Synthetic user", head.sha256),
        sections=sections,
        e=experiment,
        origin=origin(experiment),
        headline=headline(tests),
        words=in_words(experiment, tests),
        beside=beside_the_paper(experiment),
        tests=tests,
        rows=scorer_rows(experiment),
        panels=figures.two_panels(experiment),
        agreement=figures.agreement(experiment),
        sensitivity=figures.sensitivity(experiment),
        sensitivity_trials=experiment.tables["sensitivity"]["trial"].nunique(),
        sizes=figures.fleet_sizes(experiment),
        size_rows=sizes[1],
        size_labels=sizes[0],
        size_trials=experiment.tables["fleet_sizes"]["trial"].nunique(),
        worlds=world_rows(experiment),
        assumptions=assumption_rows(experiment),
        seconds=sum(trial.seconds for trial in experiment.results.trials),
        results_sha256=results_sha256(experiment.results.trials),
        made_with=versions(experiment),
        analysed_with=[(name, version_of(name) or "not installed") for name in PACKAGES],
        analysis_digest=digest(analysis_files()),
    )
    return page.rstrip() + "\n"


def origin(experiment: Experiment) -> str:
    """Say what the data are."""
    worlds = "held-out" if experiment.results.head.seeds == "held_out" else "development"
    return f"Synthetic user, {experiment.trials} trials in {worlds} worlds"


def headline(tests: dict[str, list[Contrast]]) -> str:
    """Say in a sentence how H1 and H2 fell against the classifier."""
    prediction = tests.get(PREDICTION, [])
    if not prediction:
        return "Means over trials of each scorer."
    rival = prediction[0].second
    named = (
        f"A scorer learned by Luce’s model named the user’s robot {_compared(prediction, 'often')}"
    )
    reward = [test for test in tests.get(REWARD, []) if test.second == rival]
    earned = f", and its fleet earned {_compared(reward)}" if reward else ""
    return f"{named} than a classifier{earned}."


def _compared(tests: list[Contrast], word: str = "") -> str:
    """Say whether something was more, less or neither, in all or in some of what was compared."""
    kinds = {test.verdict for test in tests}
    more, less = f"more {word}".strip(), f"less {word}".strip()
    if kinds == {"higher"}:
        return more
    if kinds == {"lower"}:
        return less
    if kinds == {"undecided"}:
        return f"neither clearly {more} nor {less}"
    share = f"in {sum(test.verdict == 'higher' for test in tests)} of {len(tests)} comparisons"
    if "lower" not in kinds:
        return f"{more} ({share}; in the others they could not be told apart)"
    return f"{more} in some comparisons and {less} in others"


def in_percent(mean: Mean) -> Mean:
    """Return a mean of shares in percentage points."""
    bounds = mean.interval
    if bounds is not None:
        bounds = Interval(100 * bounds.low, 100 * bounds.high, bounds.level)
    return Mean(100 * mean.value, bounds, mean.n)


def mean_text(mean: Mean, decimals: int = 2) -> str:
    """Write a mean with its interval."""
    if not mean.n:
        return "–"
    text = number(mean.value, decimals)
    if mean.interval is None:
        return text
    return f"{text}{NO_BREAK}{interval(mean.interval, decimals)}"


def scorer_rows(experiment: Experiment) -> list[ScorerRow]:
    """Return every scorer's measures at each dwell; the unassisted fleet's once."""
    rows = []
    for place, dwell in enumerate(experiment.dwells):
        frame_at = runs_at(experiment, dwell)
        alone = {name: (reward, impact) for name, reward, impact in policy_means(experiment, dwell)}
        for name in experiment.scorers:
            if name == NONE and place:
                continue
            mine = frame_at[frame_at["scorer"] == name]
            policy, impact = alone[name]
            rows.append(
                ScorerRow(
                    label=experiment.label(name),
                    dwell=0 if name == NONE else dwell,
                    reward=mean_of(mine["team_reward"].astype(float)),
                    own=mean_of(mine["own_agreement"].astype(float)),
                    reference=mean_of(mine["reference_agreement"].astype(float)),
                    goals=mean_of(mine["goals"].astype(float)),
                    lost=mean_of(mine["lost"].astype(float)),
                    policy=policy,
                    impact=impact,
                )
            )
    return rows


def size_rows(experiment: Experiment) -> tuple[list[str], list[SizeRow]]:
    """Return the scorers' labels, and for each fleet size the points that their help adds."""
    table = experiment.tables["fleet_sizes"]
    names = [
        name for name in experiment.scorers if name != NONE and (table["scorer"] == name).any()
    ]
    rows = [
        SizeRow(
            robots,
            tuple(mean_of(group[group["scorer"] == name]["gain"]) for name in names),
        )
        for robots in sorted({int(size) for size in table["robots"]})
        for group in [table[table["robots"] == robots]]
    ]
    return [experiment.label(name) for name in names], rows


def world_rows(experiment: Experiment) -> list[tuple[str, Mean, int]]:
    """Return what the worlds were like: (words, mean, decimals)."""
    worlds = experiment.tables["worlds"]
    described = (
        ("user_points", "Points of an episode that the user drives", 1),
        ("demonstrations", "Demonstrations in phase one", 0),
        ("values_r_squared", "R² of the robots’ V against held-out rollouts", 2),
        ("phi_deviation", "Standard deviation of phi in phase two, points", 2),
        ("choices", "Choices in phase two", 0),
        ("choices_best", "Part of them that fell on the robot with the largest phi", 2),
    )
    return [
        (words, mean_of(worlds[name].astype(float)), places) for name, words, places in described
    ]


def assumption_rows(experiment: Experiment) -> list[tuple[str, str, str]]:
    """Return (setting, its value, why) of what the paper leaves open."""
    rows = []
    for path, reason in experiment.protocol.get("assumptions", {}).items():
        node = experiment.protocol
        for step in str(path).split("."):
            node = node.get(step, {}) if isinstance(node, dict) else {}
        value = "" if isinstance(node, dict) else json.dumps(node, ensure_ascii=False)
        rows.append((str(path), value, str(reason)))
    return rows


def versions(experiment: Experiment) -> list[tuple[str, str]]:
    """Return with which versions the trials were computed; several are joined."""
    found: dict[str, set[str]] = {}
    for trial in experiment.results.trials:
        for name, version in trial.versions.items():
            found.setdefault(name, set()).add(version)
    return [(name, ", ".join(sorted(each))) for name, each in sorted(found.items())]
