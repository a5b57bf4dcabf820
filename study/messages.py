"""What participants read, in their language: one catalogue for session and window.

Every text is written in English where it is used, and looked up in the participant's language:

    messages = messages_for("en")
    messages.say("Press Enter to begin")
    messages.say("Robot {number} is yours", number=7)
    messages.count("{n} robot", "{n} robots", 12)

The first argument (of ``count`` the first two) is a plain literal, never an f-string:
``tools/write_catalogue.py`` collects these literals for translators. Literals in a table, said
later, are marked where they stand:

    WORDS = {"goal": noted("goal")}
    messages.say(WORDS["goal"])

A text from elsewhere, such as a task's reward terms or a questionnaire's items, is said as well
(``messages.say(term.per)``): it is translated where the catalogue has it, else shown as it is.
Numbers are filled in as they are given; write them as text first where their form matters.

`messages_for` depends on its argument alone: catalogues are part of the program, like its code.
The locale ``pseudo`` is made from English by rule: accented letters in brackets, and longer by
`PSEUDO_GROWTH`. A text that appears without accents does not come from the catalogue, and a text
without its closing bracket is clipped.
"""

from __future__ import annotations

import dataclasses
import functools
import gettext
import math
import re
from pathlib import Path

from study.errors import StudyError

LOCALES_FOLDER = Path(__file__).parent / "locales"
DOMAIN = "study"
SOURCE = "en"
PSEUDO = "pseudo"
PSEUDO_GROWTH = 0.4
"""Share by which pseudo texts are longer: translations from English grow about so much."""
_ACCENTED = str.maketrans(
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ",
    "áßçðéſğĥíĵķļŋñöþøřšţüųŵ×ýžÁßÇÐÉ£ĞĤÍĴĶĻŊÑÖÞØŘŠŢÜŲŴ×ÝŽ",
)
_FIELD = re.compile(r"(\{[^{}]*\})")
_FILLER = "àèïòûäëøâêîô"


def noted(text: str) -> str:
    """Mark a literal that is said later; return it."""
    return text


@dataclasses.dataclass(frozen=True)
class Messages:
    """The texts of one locale.

    Attributes:
        locale: "en", "pseudo" or another of `locales`.
    """

    locale: str
    _translations: gettext.NullTranslations = dataclasses.field(repr=False, compare=False)

    def say(self, text: str, /, **values: object) -> str:
        """Return a text in this locale.

        Args:
            text: the English text; with values, its fields are written "{name}".
            values: what the fields stand for.
        """
        if not text:
            return ""
        return self._filled(self._translations.gettext(text), values)

    def count(self, one: str, many: str, n: int, /, **values: object) -> str:
        """Return a text in the grammatical number of ``n``, which fills the field "{n}".

        Args:
            one: the English text for 1.
            many: the English text for other numbers.
            n: the number.
            values: what other fields stand for.
        """
        return self._filled(self._translations.ngettext(one, many, n), {"n": n, **values})

    def _filled(self, text: str, values: dict[str, object]) -> str:
        shown = pseudo(text) if self.locale == PSEUDO else text
        return shown.format(**values) if values else shown


def pseudo(text: str) -> str:
    """Return a text with accents, in brackets, about `PSEUDO_GROWTH` longer; fields stay."""
    letters = len(_FIELD.sub("", text))
    parts = [
        part if _FIELD.fullmatch(part) else part.translate(_ACCENTED) for part in _FIELD.split(text)
    ]
    extra = max(0, math.ceil(PSEUDO_GROWTH * letters) - 2)
    filler = (_FILLER * (extra // len(_FILLER) + 1))[:extra]
    if " " in text:
        # One word stays one word, but more words may be broken into lines like the text's.
        filler = "".join(" " if place % 8 == 0 else sign for place, sign in enumerate(filler))
    return f"[{''.join(parts)}{filler}]"


def locales() -> tuple[str, ...]:
    """Return the locales there are, the source's first and the pseudo-locale last."""
    found = sorted(
        path.parents[1].name for path in LOCALES_FOLDER.glob(f"*/LC_MESSAGES/{DOMAIN}.mo")
    )
    return (SOURCE, *(name for name in found if name != SOURCE), PSEUDO)


@functools.cache
def messages_for(locale: str) -> Messages:
    """Return the texts of a locale.

    Raises:
        StudyError: there is no such locale.
    """
    if locale not in locales():
        raise StudyError(
            f'no texts in the language "{locale}"', f"There are: {', '.join(locales())}."
        )
    folder = SOURCE if locale == PSEUDO else locale
    path = LOCALES_FOLDER / folder / "LC_MESSAGES" / f"{DOMAIN}.mo"
    with path.open("rb") as file:
        return Messages(locale, gettext.GNUTranslations(file))
