"""How numbers are written: one place, so that text, tables and figures agree.

Estimates, F, t and d have two decimals; p has three and no leading zero; a minus is a true
minus; no statistic breaks across lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime

from markupsafe import Markup, escape

from analysis.statistics.result import EffectResult, EffectSize, Interval

NO_BREAK = "\u00a0"
_SYMBOLS = {
    "d_z": Markup("<i>d<sub>z</sub></i>"),
    "g_z": Markup("<i>g<sub>z</sub></i>"),
    "r_rb": Markup("<i>r</i><sub>rb</sub>"),
    "partial eta squared": Markup("partial η²"),
    "generalised eta squared": Markup("generalised η²"),
}
_BOUNDED = {"r_rb", "Kendall's W", "partial eta squared", "generalised eta squared"}


def number(value: float, decimals: int = 2) -> str:
    """Write a number with a true minus; one that rounds to zero has no sign."""
    text = f"{abs(value):.{decimals}f}"
    return f"−{text}" if value < 0 and float(text) != 0 else text


def fraction(value: float, decimals: int = 2) -> str:
    """Write a number that cannot exceed one in size, without its leading zero."""
    text = number(value, decimals)
    return text.replace("0.", ".", 1) if text.lstrip("−").startswith("0.") else text


def p_value(p: float) -> str:
    """Write a probability: "< .001" or three decimals."""
    return f"<{NO_BREAK}.001" if p < 0.001 else fraction(p, 3)


def p_text(p: float) -> str:
    """Write a probability as plain text: "p = .012", "p < .001"."""
    return (f"p {p_value(p)}" if p < 0.001 else f"p = {p_value(p)}").replace(NO_BREAK, " ")


def p_equation(p: float) -> Markup:
    """Write a probability for running text: "p = .012"."""
    text = p_value(p) if p < 0.001 else f"={NO_BREAK}{p_value(p)}"
    return _unbroken(Markup("<i>p</i>") + NO_BREAK + text)


def interval(bounds: Interval, decimals: int = 2, *, bounded: bool = False) -> str:
    """Write an interval: "[3.70, 11.43]"."""
    write = fraction if bounded else number
    return f"[{write(bounds.low, decimals)},{NO_BREAK}{write(bounds.high, decimals)}]"


def degrees(result: EffectResult) -> str:
    """Write degrees of freedom: whole ones without decimals."""
    known = [df for df in (result.df1, result.df2) if df is not None]
    texts = [f"{df:.0f}" if abs(df - round(df)) < 1e-9 else f"{df:.1f}" for df in known]
    return f",{NO_BREAK}".join(texts)


def statistic(result: EffectResult) -> Markup:
    """Write a statistic for a table: "F = 18.56"."""
    name = Markup("<i>{}</i>").format(result.statistic_name)
    return _unbroken(name + f"{NO_BREAK}={NO_BREAK}{_value(result)}")


def _value(result: EffectResult) -> str:
    """Write a statistic's value; a sum of ranks is whole or a half."""
    return number(result.statistic, 1 if result.statistic_name == "V" else 2)


def plain_statistic(result: EffectResult) -> str:
    """Write a statistic as plain text, for figures: "F(1, 11) = 18.56"."""
    inside = f"({known})" if (known := degrees(result)) else ""
    return f"{result.statistic_name}{inside} = {_value(result)}".replace(NO_BREAK, " ")


def equation(result: EffectResult) -> Markup:
    """Write a statistic for running text: "F(1, 11) = 18.56, p = .001"."""
    return equation_alone(result) + ", " + p_equation(result.p)


def equation_alone(result: EffectResult) -> Markup:
    """Write a statistic for running text without its p: "F(1, 11) = 18.56"."""
    name = Markup("<i>{}</i>").format(result.statistic_name)
    inside = f"({known})" if (known := degrees(result)) else ""
    return _unbroken(name + f"{inside}{NO_BREAK}={NO_BREAK}{number(result.statistic)}")


def effect(size: EffectSize) -> Markup:
    """Write an effect size with its interval: "d_z 1.24 [0.46, 1.99]"."""
    bounded = size.name in _BOUNDED
    value = fraction(size.value) if bounded else number(size.value)
    text = effect_symbol(size.name) + NO_BREAK + value
    if size.interval is not None:
        text += NO_BREAK + interval(size.interval, bounded=bounded)
    return _unbroken(text)


def effect_symbol(name: str) -> Markup:
    """Return an effect size's symbol."""
    return _SYMBOLS.get(name, escape(name))


def utc(stamp: str) -> str:
    """Write a time in ISO 8601 for people, in UTC: "2026-11-26 01:56:38 UTC"."""
    moment = datetime.fromisoformat(stamp).astimezone(UTC)
    return f"{moment:%Y-%m-%d %H:%M:%S} UTC"


_NAMED = {
    "own": "own scorer",
    "own, cross-validated": "own scorer, cross-validated",
    "luce": "Luce",
}


def scorer_name(name: str) -> str:
    """Return what a report calls a scorer: its name in recordings and tables, made readable.

    A name that a protocol or an analyst gave stays but for its underscores.
    """
    bare = name.removeprefix("scorer:")
    return _NAMED.get(bare, bare.replace("_", " "))


def listed(words: Sequence[str]) -> str:
    """Join words: "a", "a and b", "a, b and c"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} and {words[-1]}"


def counted(count: int, singular: str, plural: str = "") -> str:
    """Write a count with its noun: "1 trial", "12 trials"."""
    return f"{count}{NO_BREAK}{singular if count == 1 else plural or singular + 's'}"


_WORDS = (
    *("no", "one", "two", "three", "four", "five", "six"),
    *("seven", "eight", "nine", "ten", "eleven", "twelve"),
)


def in_words(count: int, *, capital: bool = False) -> str:
    """Write a small count in words, a larger one in digits."""
    text = _WORDS[count] if count < len(_WORDS) else str(count)
    return text.capitalize() if capital else text


def _unbroken(text: Markup) -> Markup:
    return Markup('<span class="nb">{}</span>').format(text)
