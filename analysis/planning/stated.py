"""From what was given, the protocol and a pilot to assumptions, each with where it comes from."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from analysis.planning.assumptions import Assumptions, Order, check
from analysis.planning.pilot import Estimate, Pilot
from analysis.statistics.result import Interval
from study.errors import StudyError

GIVEN, PILOT = "given", "pilot"


@dataclasses.dataclass(frozen=True, slots=True)
class PlannedStudy:
    """What a plan takes from a protocol.

    Attributes:
        title: of the study.
        sha256: of the protocol's file.
        levels: names of the conditions, the reference first.
        labels: what reports call them.
        orders: orders of the conditions, in the sequence in which they are given out.
        participants: planned.
        trials: planned under each condition.
        trial_seconds: how long one lasts.
        needed: part of all trials that a participant must have to be analysed.
        bound: smallest difference of interest, points; None if not stated.
        other_rules: names of exclusion rules that are not simulated.
    """

    title: str
    sha256: str
    levels: tuple[str, ...]
    labels: tuple[str, ...]
    orders: tuple[Order, ...]
    participants: int
    trials: int
    trial_seconds: float
    needed: float
    bound: float | None
    other_rules: tuple[str, ...] = ()

    def minutes(self, trials: int) -> float:
        """Return how many minutes of trials each participant runs."""
        return len(self.levels) * trials * self.trial_seconds / 60


@dataclasses.dataclass(frozen=True, slots=True)
class Given:
    """What was given to the command; None for what was not.

    Attributes:
        effects: texts: points, or NAME=POINTS.
        others: as in `Assumptions`.
    """

    effects: tuple[str, ...] = ()
    effect_sd: float | None = None
    trial_sd: float | None = None
    level_sd: float | None = None
    period: float | None = None
    learning: float | None = None
    carry_over: float | None = None
    drop_out: float | None = None
    missing: float | None = None
    alpha: float = 0.05


@dataclasses.dataclass(frozen=True, slots=True)
class Stated:
    """One assumption as tables show it.

    Attributes:
        option: that gives it; empty if none does.
        text: what it is.
        value: the number.
        unit: of the number.
        source: where it comes from.
        interval: of the pilot's estimate, where it comes from there.
    """

    option: str
    text: str
    value: float
    unit: str
    source: str
    interval: Interval | None = None


def settle(
    study: PlannedStudy, given: Given, pilot: Pilot | None
) -> tuple[Assumptions, tuple[Stated, ...]]:
    """Return what is assumed, and where each number comes from.

    What is given counts first, then the protocol's smallest difference of interest, then the pilot.

    Raises:
        StudyError: something is neither given nor in a pilot, or is no possible value.
    """
    rows = list(_effects(study, given, pilot))
    effects = (0.0, *(row.value for row in rows))
    rows += [
        _scatter("effect_sd", "SD between participants of the true effect", given, pilot),
        _scatter("trial_sd", "SD of one participant’s trials under one condition", given, pilot),
    ]
    effect_sd, trial_sd = rows[-2].value, rows[-1].value
    rows.append(_level(given, pilot, trial_sd))
    texts = {
        "period": "Each block above the one before",
        "learning": "Each trial above the one before in its block",
        "carry_over": "A block that follows another condition than the reference",
    }
    for name, text in texts.items():
        found = getattr(pilot, name, None) if pilot is not None else None
        rows.append(_number(name, text, getattr(given, name), found))
    shares = {
        "drop_out": ("Participants who leave, at any trial", "part"),
        "missing": ("Trials lost one by one", "part"),
    }
    for name, (text, unit) in shares.items():
        rows.append(_number(name, text, getattr(given, name), None, unit))
    rows.append(
        Stated("", "Trials that a participant must have to be analysed", study.needed, "part",
               "rules of the protocol" if study.needed else "the protocol has no such rule")
    )  # fmt: skip
    rows.append(Stated("--alpha", "Level of the test", given.alpha, "probability", "given"))
    values = {row.option.removeprefix("--").replace("-", "_"): row.value for row in rows}
    assumptions = Assumptions(
        effects=effects,
        effect_sd=effect_sd,
        trial_sd=trial_sd,
        orders=study.orders,
        needed=study.needed,
        **{name: values[name] for name in ("level_sd", *texts, *shares, "alpha")},
    )
    check(assumptions)
    if len(set(effects)) == 1:
        raise StudyError(
            "--effect: no condition differs from another",
            "No number of participants finds a difference that is not there: give the smallest "
            "one that would matter.",
        )
    return assumptions, tuple(rows)


def _effects(study: PlannedStudy, given: Given, pilot: Pilot | None) -> Sequence[Stated]:
    reference, *others = study.levels
    labels = dict(zip(study.levels, study.labels, strict=True))
    stated = _parsed(given.effects, others, reference)
    found = _pilot_effects(study, pilot)
    rows = []
    for name in others:
        text = f"{labels[name]} less {labels[reference]}"
        if name in stated:
            row = Stated("--effect", text, stated[name], "points", GIVEN)
        elif given.effects:
            raise StudyError(
                f"--effect: none given for {name}",
                f"Give one for each condition but {reference}: "
                + " ".join(f"--effect {each}=POINTS" for each in others),
            )
        elif study.bound is not None and len(others) == 1:
            source = "protocol: analysis.equivalence_bound"
            row = Stated("--effect", text, study.bound, "points", source)
        elif name in found:
            estimate = found[name]
            row = Stated("--effect", text, estimate.value, "points", PILOT, estimate.interval)
        else:
            raise StudyError(
                "no effect to plan for",
                "Give --effect POINTS, the smallest difference that would matter (or "
                "equivalence_bound under [analysis] in the protocol), or a pilot with --from or "
                "--sessions.",
            )
        rows.append(row)
    return rows


def _parsed(texts: Sequence[str], names: Sequence[str], reference: str) -> dict[str, float]:
    found: dict[str, float] = {}
    for text in texts:
        name, equals, number = text.rpartition("=")
        if not equals:
            if len(names) > 1:
                raise StudyError(
                    f"--effect {text}: the protocol has {len(names) + 1} conditions",
                    "Say of which: " + " ".join(f"--effect {each}=POINTS" for each in names),
                )
            name = names[0]
        if name not in names:
            is_what = "is the reference" if name == reference else "is no condition"
            raise StudyError(f"--effect {text}: {name} {is_what}", f"Known: {', '.join(names)}.")
        try:
            value = float(number)
        except ValueError as error:
            raise StudyError(
                f"--effect {text}: {number!r} is no number", "Give points, such as 20."
            ) from error
        if name in found:
            raise StudyError(f"--effect: {name} is given twice", "Give it once.")
        found[name] = value
    return found


def _pilot_effects(study: PlannedStudy, pilot: Pilot | None) -> dict[str, Estimate]:
    if pilot is None:
        return {}
    if pilot.levels[0] != study.levels[0] or set(pilot.levels) != set(study.levels):
        raise StudyError(
            f"the pilot's conditions are {', '.join(pilot.levels)}; the protocol's are "
            f"{', '.join(study.levels)}",
            "Give recordings of this protocol's conditions.",
        )
    return dict(zip(pilot.levels[1:], pilot.effects, strict=True))


def _scatter(name: str, text: str, given: Given, pilot: Pilot | None) -> Stated:
    option = f"--{name.replace('_', '-')}"
    value = getattr(given, name)
    if value is not None:
        return Stated(option, text, value, "points", GIVEN)
    if pilot is None:
        raise StudyError(f"no {option}: {text}", "Give it, or a pilot with --from or --sessions.")
    found: Estimate = getattr(pilot, name)
    return Stated(option, text, found.value, "points", PILOT, found.interval)


def _level(given: Given, pilot: Pilot | None, trial_sd: float) -> Stated:
    option, text = "--level-sd", "SD between participants of their level"
    if given.level_sd is not None:
        return Stated(option, text, given.level_sd, "points", GIVEN)
    if pilot is not None:
        return Stated(option, text, pilot.level_sd.value, "points", PILOT, pilot.level_sd.interval)
    source = "not given: as much as trials scatter; counts only where trials are missing"
    return Stated(option, text, trial_sd, "points", source)


def _number(
    name: str, text: str, given: float | None, found: Estimate | None, unit: str = "points"
) -> Stated:
    option = f"--{name.replace('_', '-')}"
    if given is not None:
        return Stated(option, text, given, unit, GIVEN)
    if found is not None:
        return Stated(option, text, found.value, unit, PILOT, found.interval)
    return Stated(option, text, 0.0, unit, "not given: none")
