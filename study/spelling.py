"""Which known word somebody meant who misspelt it."""

from __future__ import annotations

from collections.abc import Sequence

_CLOSE = 0.74
"""How alike two words are, from 0 to 1, where one is taken for the other: one letter of four is
another."""


def closest(given: str, known: Sequence[str]) -> str:
    """Return the known word closest to ``given``; empty if none is close."""
    from difflib import get_close_matches  # noqa: PLC0415 - needed only where one is misspelt

    return next(iter(get_close_matches(given, known, n=1, cutoff=_CLOSE)), "")
