"""The report: one self-contained HTML file, the same bytes for the same recordings."""

from __future__ import annotations

from typing import Any

from analysis.environment import analysis_files, digest
from analysis.figures.paired_means import inferred
from analysis.page import frame, page_environment
from analysis.plan_status import plan_status
from analysis.results import StudyResults
from analysis.sections import (
    checks,
    participants,
    policies,
    provenance,
    quality,
    ratings,
    reward,
    robustness,
    scorers,
    sentences,
    summary,
)
from analysis.statistics.cumulative_link import CumulativeLink
from analysis.statistics.result import EffectResult


def render_report(results: StudyResults) -> str:
    """Return the report as HTML.

    Nothing in it depends on the time, the folder or the order of the files. All text from
    recordings is escaped.
    """
    environment = page_environment()
    environment.tests["computed"] = lambda outcome: isinstance(outcome, EffectResult)
    environment.tests["fitted"] = lambda outcome: isinstance(outcome, CumulativeLink)
    page = environment.get_template("report.html.j2").render(
        r=results,
        **frame(
            environment,
            results.label.short if results.label.simulated else "",
            results.study.protocol_hashes[0],
        ),
        **_context(results),
    )
    return page.rstrip() + "\n"


def _context(results: StudyResults) -> dict[str, Any]:
    map_rows, map_scale = scorers.figures(results)
    plan = plan_status(results.study)
    sections = [
        ("summary", "Summary"),
        ("reward", "Team reward"),
        ("order", "Learning and order"),
        ("robustness", "Robustness"),
        ("ratings", "Ratings"),
        ("scorers", "Learned scorers"),
        ("scorer-quality", "Scorer quality"),
        ("policies", "Phase four"),
        ("quality", "Data quality"),
        ("checks", "Assumption checks"),
        ("timing", "Timing"),
        ("participants", "Participants"),
        ("methods", "Methods and sentences"),
        ("provenance", "Provenance"),
        ("downloads", "Downloads"),
    ]
    return {
        "sections": sections,
        "headline": summary.headline(results),
        "evidence": summary.evidence(results),
        "direction": summary.direction(results) if len(results.labels) == 2 else "",
        "design": summary.design(results),
        "recorded": summary.recorded(results),
        "tiles": summary.tiles(results),
        "reward_figure": reward.figure(results),
        "reward_intervals": inferred(results.cells),
        "curves": reward.curves(results),
        "plan": plan,
        "forest": reward.forest_figure(results),
        "forest_finding": reward.forest_finding(results),
        "check_figure": checks.figure(results),
        "check_rows": checks.rows(results),
        "check_finding": checks.finding(results),
        "pages": participants.pages(results),
        "sentences": sentences.sentences(results),
        "accuracy_figure": scorers.accuracy_figure(results),
        "accuracy_finding": scorers.accuracy_finding(results),
        "test_groups": reward.test_groups(results),
        "reward_refusals": reward.refusals(results),
        "order_finding": reward.order_finding(results),
        "period_finding": reward.period_finding(results),
        "order_caption": reward.order_caption(results),
        "robustness_findings": robustness.findings(results),
        "order_tests": robustness.order_tests(results),
        "order_design": robustness.order_design(results),
        "robustness_refusals": robustness.refusals(results),
        "rating_figure": ratings.figure(results),
        "rating_finding": ratings.finding(results),
        "rating_label": ratings.label,
        "rating_df": ratings.paper_heading(results),
        "rating_refusals": ratings.refusals(results),
        "questions": ratings.questions(results),
        "map_rows": map_rows,
        "map_scale": map_scale,
        "peak_finding": scorers.peak_finding(results),
        "scorer_quality": scorers.quality(results),
        "policy_figure": policies.figure(results),
        "policy_finding": policies.finding(results),
        "policy_starts": policies.starts(results),
        "flags": quality.flags(results),
        "rules": quality.rules(results),
        "timing_rows": quality.timing_rows(results),
        "methods": provenance.methods(results, plan),
        "analysis_versions": provenance.analysis_versions(),
        "analysis_digest": digest(analysis_files()),
        "recording_versions": provenance.recording_versions(results),
        "downloads": provenance.downloads(results),
    }
