"""The report of a plan: one HTML file, the same bytes for the same plan."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.environment import PACKAGES, analysis_files, digest, version_of
from analysis.page import frame, page_environment
from analysis.planning import words
from analysis.planning.figures import power_curves
from analysis.planning.plan import Plan
from analysis.planning.stated import PlannedStudy, Stated


def render_plan(plan: Plan, study: PlannedStudy, stated: Sequence[Stated]) -> str:
    """Return a plan's report as HTML."""
    environment = page_environment()
    environment.filters.update(power=words.power_text, design=words.design_text, plain=words.plain)
    sections = [
        ("summary", "Summary"),
        ("power", "Power"),
        ("otherwise", "If it is otherwise"),
        ("assumptions", "Assumptions"),
        ("limits", "What this rests on"),
        ("provenance", "Provenance"),
    ]
    origin_words = origin(plan)
    page = environment.get_template("plan.html.j2").render(
        **frame(environment, origin_words, study.sha256),
        sections=sections,
        origin=origin_words,
        plan=plan,
        study=study,
        stated=stated,
        headline=words.headline(plan),
        details=words.details(plan, study),
        effect=words.effect_text(plan),
        warnings=words.warnings(plan, study, stated),
        figure=power_curves(plan),
        made_with=[(name, version_of(name) or "not installed") for name in PACKAGES],
        analysis_digest=digest(analysis_files()),
    )
    return page.rstrip() + "\n"


def origin(plan: Plan) -> str:
    """Say what the numbers are: nothing that was measured."""
    count = sum(cell.counts.studies for cell in plan.cells)
    return f"Made-up data: a plan from {count} simulated studies"
