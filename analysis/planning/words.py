"""What a plan says in words: its answer, and what it rests on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from analysis.formatting import counted, interval, listed, number
from analysis.planning.assumptions import Design
from analysis.planning.plan import Plan
from analysis.planning.power import Cell
from analysis.planning.stated import PILOT, PlannedStudy, Stated


def design_text(design: Design) -> str:
    """Write a size: "12 participants, 8 trials a condition"."""
    people = counted(design.participants, "participant")
    return f"{people}, {counted(design.trials, 'trial')} a condition"


def plain(value: float) -> str:
    """Write a number with the decimals that it has, at most three."""
    text = number(value, 3)
    return text.rstrip("0").rstrip(".") if "." in text else text


def power_text(cell: Cell) -> str:
    """Write a power with its Monte-Carlo interval."""
    return f"{number(cell.power)} {interval(cell.interval)}"


def effect_text(plan: Plan) -> str:
    """Write the effect planned for."""
    effects = plan.given.effects[1:]
    points = listed([plain(each) for each in effects])
    return f"{'an effect' if len(effects) == 1 else 'effects'} of {points} points a trial"


def headline(plan: Plan) -> str:
    """Say the answer in a sentence."""
    wanted = number(plan.wanted.power)
    if plan.chosen is None or plan.check is None:
        best = plan.best
        return (
            f"No size in the grid reaches a power of {wanted}; the best is "
            f"{design_text(best.design)}: {power_text(best)}."
        )
    return (
        f"{design_text(plan.chosen.design).capitalize()}: the smallest size in the grid that finds "
        f"{effect_text(plan)} with a power of at least {wanted}."
    )


def details(plan: Plan, study: PlannedStudy) -> list[str]:
    """Say what stands behind the answer."""
    found = []
    if plan.chosen is not None and plan.check is not None:
        found.append(
            f"Its power in the grid is {power_text(plan.chosen)}; simulated afresh, with other "
            f"seeds, {power_text(plan.check)} in {plan.check.counts.studies} studies."
        )
        # An answer at the edge of what was looked at may not be the smallest there is.
        if plan.chosen.design == min(plan.wanted.designs):
            found.append("It is the smallest size of the grid: a smaller one may do.")
    found += [
        f"{design_text(cell.design).capitalize()} reached the power in the grid, but not afresh: "
        f"{power_text(cell)}."
        for cell in plan.failed
    ]
    sizes = [
        f"{counted(count, 'participant')} with {counted(trials, 'trial')}"
        for trials, count in plan.by_formula
        if count is not None
    ]
    if plan.by_formula:
        found.append(
            f"By the closed form it takes {listed(sizes)} a condition."
            if sizes
            else "By the closed form no size of up to 400 participants does."
        )
    own = Design(study.participants, study.trials)
    found += [
        f"The protocol’s own size, {design_text(own)}, has a power of {power_text(cell)}."
        for cell in plan.cells
        if cell.design == own and (plan.chosen is None or plan.chosen.design != own)
    ]
    return found


def warnings(plan: Plan, study: PlannedStudy, stated: Sequence[Stated]) -> list[str]:
    """Say what the numbers assume, and what follows if that is not so."""
    return [*_of_the_effect(plan, stated), *_of_the_law(plan, study), *_of_losses(plan, study)]


def _of_the_effect(plan: Plan, stated: Sequence[Stated]) -> Iterator[str]:
    pilot = plan.pilot
    from_pilot = [row for row in stated if row.source == PILOT]
    if pilot is not None and from_pilot:
        if pilot.simulated:
            yield (
                "The pilot’s participants are simulated. Their numbers show what the program does "
                "with such participants, and nothing about people."
            )
        if any(row.option == "--effect" for row in from_pilot):
            yield (
                f"The effect is that of a pilot of {counted(pilot.participants, 'participant')}. "
                "Pilots that look promising overestimate it on average, and so a plan made from "
                "one is too small. Plan for the smallest effect that would matter: --effect, or "
                "equivalence_bound under [analysis] in the protocol."
            )
        scatter = [row for row in from_pilot if row.interval and row.option.endswith("-sd")]
        if scatter:
            known = listed([
                f"{row.option.removeprefix('--')} {interval(row.interval, 1)}"
                for row in scatter
                if row.interval is not None
            ])  # fmt: skip
            yield f"The pilot knows the scatter only within its 95% intervals: {known}."
    elif any(row.option == "--effect" for row in stated):
        yield "Effect and scatter are as stated; nothing here shows that they are so."
    share = plan.best.exaggeration
    if share is not None and share > 1.05:
        yield (
            f"Studies of this size that find something report {number(share)} times the true "
            "effect on average: those that miss it are the ones that see less."
        )


def _of_the_law(plan: Plan, study: PlannedStudy) -> Iterator[str]:
    given = plan.given
    yield (
        "All scatter is taken as normal, independent and equal under every condition. Rewards "
        "with a ceiling, or a few participants far from the others, have other power."
    )
    if given.period or given.carry_over:
        yield (
            "The primary test of participants’ means does not adjust for order: what order adds "
            "counts as scatter and costs power; carry-over also shifts the effect."
        )
    else:
        yield "Neither the place in the session nor what came before is taken to matter."
    if len(study.orders) == 1:
        yield (
            "Everybody has the same order: what place in the session adds cannot be told from the "
            "effect, and counts as one."
        )
    elif any(design.participants % len(study.orders) for design in plan.wanted.designs):
        yield (
            f"Some sizes are no multiple of the {len(study.orders)} orders, which then are not "
            "balanced."
        )
    if given.conditions > 2:
        yield ("The power is that of finding any difference among the conditions, not each pair’s.")
    yield "More trials are taken to be like the others: nobody tires of them but as stated."


def _of_losses(plan: Plan, study: PlannedStudy) -> Iterator[str]:
    given = plan.given
    if given.drop_out or given.missing:
        yield (
            "Who leaves, and which trials are lost, is taken to be chance. If those leave for whom "
            "a condition goes badly, the result is biased and the power is another."
        )
    else:
        yield (
            "Nobody is taken to leave, and no trial to be lost: enrol more than this (--drop-out)."
        )
    if given.needed and (given.drop_out or given.missing):
        yield (
            "By the protocol’s rules whoever has fewer than "
            f"{number(100 * given.needed, 0)} % of the trials is left out, here too."
        )
    if any(cell.counts.by_model for cell in plan.cells):
        yield (
            "Where trials are missing the primary test is the mixed model of the trials, here as "
            "in the report. It has no closed form."
        )
    if study.other_rules:
        yield f"Rules that are not simulated: {listed(study.other_rules)}."
