"""The report: one self-contained HTML file, the same bytes for the same recordings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from analysis.environment import analysis_files, digest
from analysis.figures.paired_means import inferred
from analysis.formatting import listed
from analysis.page import frame, page_environment
from analysis.plan_status import plan_status
from analysis.results import StudyResults
from analysis.sections import (
    attention,
    by_factor,
    checks,
    effects,
    laps,
    participants,
    policies,
    provenance,
    quality,
    ratings,
    reward,
    robustness,
    scored,
    scorer_quality,
    scorers,
    sentences,
    summary,
    what_if,
    what_if_figures,
)
from analysis.statistics.cumulative_link import CumulativeLink
from analysis.statistics.result import EffectResult, Refusal
from analysis.what_if import WhatIf


def render_report(results: StudyResults, asked: WhatIf | None = None) -> str:
    """Return the report as HTML.

    Args:
        results: of the recordings.
        asked: what `study whatif` found about them; None for no such section.

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
        **_context(results, asked),
        **_what_if_context(asked),
    )
    return page.rstrip() + "\n"


def _context(results: StudyResults, asked: WhatIf | None) -> dict[str, Any]:
    map_rows, map_scale = scorers.figures(results)
    plan = plan_status(results.study)
    measured = attention.rows(results)
    driven = laps.rows(results)
    sections = [
        ("summary", "Summary"),
        ("reward", "Team reward"),
        *((("laps", "Laps"),) if driven else ()),
        ("order", "Learning and order"),
        ("robustness", "Robustness"),
        ("ratings", "Ratings"),
        ("scored", "Scored instruments"),
        ("scorers", "Learned scorers"),
        ("scorer-quality", "Scorer quality"),
        *((("what-if", "What if"),) if asked else ()),
        ("policies", "Phase four"),
        ("attention", "Attention"),
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
        "participants_fact": summary.participants_fact(results),
        "sessions_fact": summary.sessions_fact(results),
        "tiles": summary.tiles(results),
        "reward_figure": reward.figure(results),
        "reward_intervals": inferred(results.cells),
        "effects": effects.effects(results),
        "other_effects": effects.other_effects(results),
        "simple_effects": effects.simple(results),
        "effects_text": effects.effects_in_words(results),
        "factors_text": effects.factors_in_words(results),
        "interaction_figure": effects.interaction_figure(results),
        "interaction_caption": effects.interaction_caption(results),
        "effect_refusals": effects.refusals(results),
        "pairs": effects.pairs(results),
        "pairs_figure": effects.pairs_figure(results),
        "pairs_finding": effects.pairs_finding(results),
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
        "lap_rows": driven,
        "lap_figure": laps.figure(driven),
        "lap_finding": laps.finding(driven),
        "order_finding": reward.order_finding(results),
        "period_finding": reward.period_finding(results),
        "order_caption": reward.order_caption(results),
        "robustness_findings": robustness.findings(results),
        "order_tests": robustness.order_tests(results),
        "order_design": robustness.order_design(results),
        "robustness_refusals": robustness.refusals(results),
        "rating_figure": ratings.figure(results),
        "rating_finding": by_factor.rating_finding(results) or ratings.finding(results),
        "rating_label": ratings.label,
        "rating_pairs": ratings.pairs(results),
        "rating_df": ratings.paper_heading(results),
        "rating_refusals": _by_reason(
            [*ratings.refusals(results), *by_factor.rating_refusals(results)]
        ),
        "rating_groups": by_factor.rating_groups(results),
        "rating_factor_figure": by_factor.rating_figure(results),
        "questions": ratings.questions(results),
        "scored_text": scored.asked_text(results),
        "scored_finding": by_factor.scale_finding(results) or scored.finding(results),
        "scale_groups": by_factor.scale_groups(results),
        "scale_factor_figure": by_factor.scale_figure(results),
        "scored_figure": scored.figure(results),
        "scored_rows": scored.compared(results),
        "scored_name": scored.full_name,
        "scored_pairs": scored.pairs(results),
        "scored_alphas": scored.reliability(results),
        "scored_refusals": _by_reason(
            [*scored.refusals(results), *by_factor.scale_refusals(results)]
        ),
        "map_rows": map_rows,
        "map_scale": map_scale,
        "map_health": scorers.has_health(results),
        "map_gates": any(session.task.scene.gates for session in results.study.sessions),
        "map_low_health": scorers.shows_low_health(results),
        "peak_finding": scorers.peak_finding(results),
        "scorer_quality": scorers.quality(results),
        "above_chance": scorer_quality.above_chance(results),
        "reliabilities": scorer_quality.reliabilities(results),
        "gates": scorer_quality.gates(results),
        "gate_finding": scorer_quality.gate_finding(results),
        "policy_figure": policies.figure(results),
        "policy_finding": policies.finding(results),
        "policy_starts": policies.starts(results),
        "attention_rows": measured,
        "attention_figure": attention.figure(results, measured),
        "attention_finding": attention.finding(results, measured),
        "attention_absent": attention.absent(results, measured),
        "flags": quality.flags(results),
        "rules": quality.rules(results),
        "timing_rows": quality.timing_rows(results),
        "methods": provenance.methods(results, plan),
        "analysis_versions": provenance.analysis_versions(),
        "analysis_digest": digest(analysis_files()),
        "recording_versions": provenance.recording_versions(results),
        "downloads": provenance.downloads(results),
    }


def _what_if_context(asked: WhatIf | None) -> dict[str, Any]:
    if asked is None:
        return {"what_if": None}
    rows, regrets = what_if.scorer_rows(asked), what_if.regret_rows(asked)
    found = what_if.matrix(asked)
    return {
        "what_if": asked,
        "what_if_rows": rows,
        "what_if_finding": what_if.finding(rows),
        "what_if_intervals": any(row.agreement.interval for row in rows),
        "what_if_dots": what_if_figures.scorer_dots(rows),
        "what_if_matrix": found,
        "what_if_matrix_finding": what_if.matrix_finding(found) if found else "",
        "what_if_matrix_figure": what_if_figures.matrix_figure(found),
        "what_if_partings": what_if_figures.partings(asked),
        "what_if_regret": regrets,
        "what_if_regret_dots": what_if_figures.regret_dots(regrets),
        "what_if_sources": list(asked.tables["scorers"].itertuples()),
    }


def _by_reason(refusals: Sequence[Refusal]) -> list[Refusal]:
    """Put together what was refused for the same reason, in the order of the first of each."""
    names: dict[str, list[str]] = {}
    for refusal in refusals:
        names.setdefault(refusal.reason, []).append(refusal.name)
    return [Refusal(listed(whose), reason) for reason, whose in names.items()]
