"""Methods text, versions and downloads."""

from __future__ import annotations

import base64
import dataclasses
import json
import platform

from analysis.environment import PACKAGES, version_of
from analysis.formatting import counted, listed, utc
from analysis.plan_status import PlanStatus
from analysis.results import StudyResults
from analysis.sections import effects
from analysis.statistics.crossover import Crossover
from analysis.statistics.latin_square import LatinSquare
from analysis.statistics.result import EffectResult

EMBED_BYTES = 400_000
"""Largest CSV that the page itself carries."""


@dataclasses.dataclass(frozen=True, slots=True)
class Download:
    """One table to download."""

    name: str
    rows: int
    href: str
    embedded: bool


def downloads(results: StudyResults) -> list[Download]:
    """Return every table as a link: small ones inside the page, others beside it."""
    made: list[Download] = []
    tables = results.tables
    for name in tables.names():
        rows = tables.rows(name)
        csv = tables[name].to_csv(results.label.line).encode()
        if len(csv) > EMBED_BYTES:
            made.append(Download(name, rows, f"tables/{name}.csv", embedded=False))
            continue
        coded = base64.b64encode(csv).decode()
        href = f"data:text/csv;charset=utf-8;base64,{coded}"
        made.append(Download(name, rows, href, embedded=True))
    return made


def analysis_versions() -> list[tuple[str, str]]:
    """Return the versions of what computed this report."""
    versions = [(package, version_of(package)) for package in PACKAGES]
    installed = [(package, version) for package, version in versions if version is not None]
    return [("Python", platform.python_version()), *installed]


def recording_versions(results: StudyResults) -> list[tuple[str, str]]:
    """Return the versions that made the recordings; several where they differ."""
    found: dict[str, set[str]] = {}
    for session in results.study.sessions:
        try:
            versions = json.loads(session.opened.versions_json or "{}")
        except (ValueError, RecursionError):
            continue
        for name, version in versions.items() if isinstance(versions, dict) else ():
            found.setdefault(str(name), set()).add(str(version))
    return [(name, ", ".join(sorted(versions))) for name, versions in sorted(found.items())]


def methods(results: StudyResults, plan: PlanStatus) -> list[str]:
    """Describe the analysis in sentences to copy."""
    facts, cells, data = results.facts, results.cells, results.data
    kind = "simulated participants" if results.label.simulated else "participants"
    sessions = counted(len(results.study.sessions), "session")
    text = [
        f"The data are {sessions} of {kind}. "
        "Team reward is the sum of all robots’ rewards in one trial."
    ]
    if results.labels:
        text.append(
            "It was averaged over the complete trials of each participant under "
            f"{listed(results.labels)}."
        )
    if isinstance(results.primary, EffectResult):
        text.append(f"{counted(cells.n, 'participant')} entered its test.")
    else:
        text.append("Its difference between conditions was not tested.")
    if results.by_trial:
        text.append(
            "As not all participants have as many trials under each condition, the primary test "
            "is that of condition in a linear mixed model of the trials (condition, trial and "
            "period; random effects of participant and of participant by condition) with Kenward "
            "and Roger’s degrees of freedom."
        )
    elif isinstance(results.primary, EffectResult) and results.primary.estimate is not None:
        text.append(
            "The primary test is a repeated-measures ANOVA on these means, identical to a paired "
            "t test (F = t²). Intervals of differences are t intervals at 95%; that of d_z "
            "inverts the noncentral t distribution."
        )
    elif isinstance(results.primary, EffectResult):
        text.append(
            "The primary test is a repeated-measures ANOVA on these means with Greenhouse and "
            "Geisser’s correction, with each pair of conditions Holm-adjusted beside it."
        )
    if results.factorial is not None and effects.effects(results):
        text.append(
            f"{effects.factors_in_words(results)}: that the conditions cross these factors follows "
            "from their settings (rule crossed_settings). Main effects and interactions were "
            "tested with an error term each, Holm-adjusted over the effects."
        )
    if results.robustness is not None:
        text.append(
            "Sensitivity analyses are a linear mixed model of the trials with Kenward and Roger’s "
            "and with Satterthwaite’s degrees of freedom, the exact Wilcoxon test, a sign-flip "
            "permutation test, leaving out each participant in turn and a JZS Bayes factor."
        )
        if isinstance(results.robustness.equivalence, EffectResult):
            text.append(
                "Equivalence was tested by two one-sided tests against the bound that the protocol "
                f"states, {facts.equivalence_bound:g} points."
            )
    if isinstance(results.order_tests, Crossover):
        text.append("Period and carry-over were tested as an AB/BA crossover.")
    elif isinstance(results.order_tests, LatinSquare):
        text.append(
            "Period and carry-over were tested with participants as fixed effects, each term "
            "adjusted for the others."
        )
    if any(isinstance(outcome, EffectResult) for outcome in results.comparison):
        text.append(
            "Trial rows pooled over participants are shown for comparison only: they treat trials "
            "of one participant as independent, so that their error rate is not the one stated."
        )
    if results.ratings:
        ranks = "exact Wilcoxon signed-rank tests (differences of zero dropped)"
        if len(results.labels) > 2:
            ranks = "Friedman’s tests"
            if not results.rating_effects:
                ranks += " (pairs by exact Wilcoxon signed-rank tests)"
        text.append(
            f"Ratings were compared by F as in the paper and by {ranks}, "
            "with cumulative-link mixed models beside them, each "
            f"Holm-adjusted over {counted(len(results.ratings), 'row')}."
        )
    if results.rating_effects or results.scale_effects:
        ordinal = (
            " Beside them stand likelihood ratios in cumulative-link mixed models of ratings."
            if results.rating_effects
            else ""
        )
        text.append(
            "Effects of the factors on ratings and scores were tested by repeated-measures ANOVA "
            "of participants’ cells with Greenhouse and Geisser’s correction, and levels of each "
            "factor by ranks, each kind of test Holm-adjusted over all effects of ratings, and of "
            f"scores.{ordinal}"
        )
    if results.scales:
        compared = [row for row in results.scales if row.compared]
        if compared:
            tests = (
                "by paired t tests on participants’ scores and by exact Wilcoxon tests"
                if len(results.labels) == 2
                else "by repeated-measures ANOVA with Greenhouse and Geisser’s correction"
            )
            text.append(
                f"Scores of instruments were compared {tests}, Holm-adjusted over "
                f"{counted(len(compared), 'scale')}."
            )
        text.append(
            "Reliability is Cronbach’s alpha under each condition, with Feldt’s 95% interval."
        )
    if facts.exclusions:
        rules = [
            f"{rule.name} (at least {rule.at_least:g} {rule.measure.replace('_', ' ')})"
            for rule in facts.exclusions
        ]
        left = counted(len(data.excluded), "participant") if data.excluded else "nobody"
        text.append(
            f"The protocol’s exclusion {'rule' if len(rules) == 1 else 'rules'} {listed(rules)} "
            f"left out {left}."
        )
    if facts.trial_exclusions:
        rules = [
            f"{rule.name} ({', '.join(sorted(rule.deviations))})" for rule in facts.trial_exclusions
        ]
        left = counted(len(data.excluded_trials), "trial") if len(data.excluded_trials) else "none"
        text.append(
            f"The protocol’s {'rule' if len(rules) == 1 else 'rules'} on disturbed trials "
            f"{listed(rules)} left out {left}."
        )
    if plan.confirmatory and plan.lock is not None:
        text.append(
            "Protocol, exclusion rules, analysis code and software versions were fixed on "
            f"{utc(plan.lock.locked_utc)}, before the first record, and have not changed since."
        )
    return text
