"""Drawing pseudonyms, and telling ids that are none."""

from __future__ import annotations

import re
import secrets
from collections.abc import Callable

from study.errors import StudyError

PARTICIPANT = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}")
_DEVICE_NAMES = re.compile(r"(?i)(con|prn|aux|nul|com[0-9]|lpt[0-9])")
_LETTERS = "BCDFGHJKMNPQRSTVWXZ"
_DIGITS = "23456789"
_TRIES = 1000


def check_participant(given: str) -> str:
    """Return the id if it can be used as one.

    Raises:
        StudyError: it could not be part of a file's name, or looks like more than an id.
    """
    if _DEVICE_NAMES.fullmatch(given):
        raise StudyError(
            f'participant id "{given}" cannot be used',
            "Windows keeps that name for a device, and no file can have it. "
            "Give a pseudonym such as P01.",
        )
    if not PARTICIPANT.fullmatch(given):
        raise StudyError(
            f'participant id "{given[:60]}" cannot be used',
            "Give a pseudonym such as P01: up to 32 letters, digits, - and _; never a name.",
        )
    return given


def refuse_name(given: str) -> None:
    """Raise where an id that nobody has yet may be a person's name.

    Raises:
        StudyError: it may be one. Ids go into every file, and cannot be taken back from there.
    """
    if looks_like_a_name(given):
        raise StudyError(
            f'participant id "{given}" looks like a name, and ids go into every file',
            "Leave out --participant, and a pseudonym is drawn; or give a code with a digit in it, "
            "such as P01.",
        )


def looks_like_a_name(given: str) -> bool:
    """Return whether an id may be a person's name: letters without a digit, as no code has."""
    return not any(sign.isdigit() for sign in given) and re.search("[A-Za-z]{3}", given) is not None


def draw_pseudonym(is_taken: Callable[[str], bool]) -> str:
    """Return a random pseudonym such as P4KX9R that is not taken.

    It says nothing of the person or of the order in which people came. Letters that look like
    digits and vowels, which make words, are left out: 4.4 million are possible.

    Args:
        is_taken: whether a pseudonym was given out before.

    Raises:
        StudyError: nearly all are taken.
    """
    for _ in range(_TRIES):
        signs = [secrets.choice(_DIGITS + _LETTERS) for _ in range(4)]
        drawn = "P" + secrets.choice(_DIGITS) + "".join(signs)
        if not is_taken(drawn):
            return drawn
    raise StudyError("no pseudonym is left to draw", "Give one with --participant.")
