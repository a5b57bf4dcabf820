"""Formulas of mixed models, written as in R: `reward ~ condition * trial + (1 | participant)`."""

from __future__ import annotations

import dataclasses
import itertools
import re

Term = tuple[str, ...]
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*\Z")


class FormulaError(ValueError):
    """A formula that cannot be read; the message says what was given and what is known."""


@dataclasses.dataclass(frozen=True, slots=True)
class RandomTerm:
    """Random effects of one grouping factor, correlated among one another.

    Attributes:
        group: columns whose combinations are the groups.
        terms: which effects vary between groups, without the intercept.
        intercept: whether the intercept varies.
    """

    group: Term
    terms: tuple[Term, ...]
    intercept: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class Formula:
    """A parsed formula; the intercept is always part of it.

    Attributes:
        response: the column explained.
        terms: fixed terms, main effects before interactions.
        random: random terms in the order written.
        text: as written.
    """

    response: str
    terms: tuple[Term, ...]
    random: tuple[RandomTerm, ...]
    text: str

    @property
    def names(self) -> tuple[str, ...]:
        """Every column but the response, in order of appearance."""
        found: dict[str, None] = {}
        for term in self.terms:
            found.update(dict.fromkeys(term))
        for random in self.random:
            for term in (*random.terms, random.group):
                found.update(dict.fromkeys(term))
        return tuple(found)


def parse_formula(text: str) -> Formula:
    """Read a formula with +, :, *, and random terms (1 + x | a:b), (1 | a/b) or (1 + x || a).

    Raises:
        FormulaError: anything else.
    """
    left, tilde, right = text.partition("~")
    if not tilde:
        raise FormulaError(f"The formula {text!r} has no ~ between response and terms.")
    terms: list[Term] = []
    random: list[RandomTerm] = []
    for part in _split(right, text):
        if part.startswith("(") and part.endswith(")"):
            random += _random_terms(part[1:-1], text)
        elif part != "1":
            terms += [term for term in _expand(part, text) if term not in terms]
    ordered = tuple(sorted(terms, key=len))  # stable: the order written within each order
    return Formula(_name(left, text), ordered, tuple(random), " ".join(text.split()))


def _split(right: str, text: str) -> list[str]:
    """Split at each + outside of brackets."""
    parts, depth = [""], 0
    for sign in right:
        depth += (sign == "(") - (sign == ")")
        if sign == "+" and depth == 0:
            parts.append("")
        else:
            parts[-1] += sign
    if depth or not all(part.strip() for part in parts):
        raise FormulaError(f"The formula {text!r} has an empty term or unbalanced brackets.")
    return [part.strip() for part in parts]


def _random_terms(inside: str, text: str) -> list[RandomTerm]:
    effects, bar, group = inside.partition("|")
    apart = group.startswith("|")  # as in lme4: effects without correlation
    group = group.removeprefix("|")
    if not bar or "|" in group:
        raise FormulaError(f"{inside!r} in {text!r} is not of the form (effects | group).")
    parts = _split(effects, text)
    intercept = "0" not in parts
    terms = [term for part in parts if part not in {"0", "1"} for term in _expand(part, text)]
    nested = [_interaction(name, text) for name in group.split("/")]
    groups = [tuple(itertools.chain(*nested[: depth + 1])) for depth in range(len(nested))]
    if not apart:
        return [RandomTerm(names, tuple(terms), intercept) for names in groups]
    each: list[tuple[tuple[Term, ...], bool]] = [((), True)] if intercept else []
    each += [((term,), False) for term in terms]
    return [RandomTerm(names, own, with_one) for names in groups for own, with_one in each]


def _expand(part: str, text: str) -> list[Term]:
    factors = [_interaction(factor, text) for factor in part.split("*")]
    sizes = range(1, len(factors) + 1)
    chosen = itertools.chain(*(itertools.combinations(factors, size) for size in sizes))
    return [tuple(dict.fromkeys(itertools.chain(*names))) for names in chosen]


def _interaction(part: str, text: str) -> Term:
    return tuple(_name(name, text) for name in part.split(":"))


def _name(name: str, text: str) -> str:
    if not _NAME.match(name.strip()):
        raise FormulaError(
            f"{name.strip()!r} in {text!r} is not the name of a column. A formula has names of "
            "columns, +, :, * and random terms; the intercept is always part of it, and what is "
            "computed of columns is made a column first."
        )
    return name.strip()
