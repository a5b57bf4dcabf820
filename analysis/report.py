"""The report: one self-contained HTML file, the same bytes for the same recordings."""

from __future__ import annotations

import base64
import hashlib
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from analysis import formatting
from analysis.environment import analysis_files, digest
from analysis.figures.paired_means import inferred
from analysis.plan_status import plan_status
from analysis.results import StudyResults
from analysis.sections import (
    checks,
    effects,
    participants,
    policies,
    provenance,
    quality,
    ratings,
    reward,
    robustness,
    scored,
    scorers,
    sentences,
    summary,
)
from analysis.statistics.cumulative_link import CumulativeLink
from analysis.statistics.result import EffectResult

TEMPLATES = Path(__file__).parent / "templates"
FONTS = (("regular", 400, "normal"), ("semibold", 600, "normal"), ("italic", 400, "italic"))


def render_report(results: StudyResults) -> str:
    """Return the report as HTML.

    Nothing in it depends on the time, the folder or the order of the files. All text from
    recordings is escaped.
    """
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        number=formatting.number,
        fraction=formatting.fraction,
        p_value=formatting.p_value,
        interval=formatting.interval,
        degrees=formatting.degrees,
        statistic=formatting.statistic,
        equation=formatting.equation,
        effect=formatting.effect,
        effect_symbol=formatting.effect_symbol,
        listed=formatting.listed,
        utc=formatting.utc,
    )
    environment.tests["computed"] = lambda outcome: isinstance(outcome, EffectResult)
    environment.tests["fitted"] = lambda outcome: isinstance(outcome, CumulativeLink)
    style = environment.get_template("style.css.j2").render(
        fonts=[(name, weight, slant, _font(name)) for name, weight, slant in FONTS],
        footer=results.label.short if results.label.simulated else "",
        protocol=_hexadecimal(results.study.protocol_hashes[0])[:12],
    )
    script = (TEMPLATES / "script.js").read_text(encoding="utf-8")
    # Both are our own templates, filled with numbers and hexadecimal digits only.
    style_markup, script_markup = Markup(style), Markup(script)  # noqa: S704
    page = environment.get_template("report.html.j2").render(
        r=results,
        style=style_markup,
        script=script_markup,
        policy=_security_policy(style, script),
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
        ("scored", "Scored instruments"),
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
        "rating_pairs": ratings.pairs(results),
        "rating_df": ratings.paper_heading(results),
        "rating_refusals": ratings.refusals(results),
        "questions": ratings.questions(results),
        "scored_text": scored.asked_text(results),
        "scored_finding": scored.finding(results),
        "scored_figure": scored.figure(results),
        "scored_rows": scored.compared(results),
        "scored_name": scored.full_name,
        "scored_pairs": scored.pairs(results),
        "scored_alphas": scored.reliability(results),
        "scored_refusals": scored.refusals(results),
        "map_rows": map_rows,
        "map_scale": map_scale,
        "map_low_health": scorers.shows_low_health(results),
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


def _security_policy(style: str, script: str) -> str:
    """Allow what the page carries itself, by hash, and nothing from anywhere else."""
    return "; ".join(
        [
            "default-src 'none'",
            "img-src data:",
            "font-src data:",
            f"style-src 'sha256-{_digest(style)}'",
            f"script-src 'sha256-{_digest(script)}'",
            "base-uri 'none'",
            "form-action 'none'",
        ]
    )


def _digest(text: str) -> str:
    return base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _font(name: str) -> str:
    content = (TEMPLATES / "fonts" / f"inter-{name}.woff2").read_bytes()
    return f"data:font/woff2;base64,{base64.b64encode(content).decode()}"


def _hexadecimal(text: str) -> str:
    return "".join(letter for letter in text.lower() if letter in "0123456789abcdef")
