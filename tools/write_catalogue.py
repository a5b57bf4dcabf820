"""Collect the texts that participants read, and compile the catalogues.

Writes study/locales/study.pot, brings each language's study.po up to date and compiles it. To
begin a language: make study/locales/LANGUAGE/LC_MESSAGES, copy study.pot into it as study.po, run
this, translate, run this again. English stands for itself.
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po, write_po

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ("study/session", "study/shell", "study/tasks", "study/commands")
LOCALES = ROOT / "study" / "locales"
KEYWORDS: dict[str, tuple[int, ...] | None] = {"say": None, "noted": None, "count": (1, 2)}


class Plain(Catalog):
    """A catalogue whose header says nothing of when, by whom and with what it was made.

    Args:
        locale: the language; None for the template.
    """

    def __init__(self, locale: str | None = None) -> None:
        super().__init__(locale=locale, header_comment="", fuzzy=False)

    @property
    def mime_headers(self) -> list[tuple[str, str]]:
        """The header's lines."""
        lines = [("Content-Type", "text/plain; charset=utf-8")]
        if self.locale is not None:
            lines += [("Language", self.locale_identifier), ("Plural-Forms", self.plural_forms)]
        return lines

    @mime_headers.setter
    def mime_headers(self, given: list[tuple[str, str]]) -> None:
        """Take in nothing: the locale says all."""


def collected(root: Path = ROOT) -> Plain:
    """Return all texts of the sources, each with the files that say it."""
    catalogue = Plain()
    for folder in SOURCES:
        for path in sorted((root / folder).rglob("*.py")):
            with path.open("rb") as file:
                # A call of count whose arguments are no literals (a list's) holds no text.
                for _, text, comments, context in extract("python", file, KEYWORDS, ("Note:",)):
                    where = [(path.relative_to(root).as_posix(), 1)]
                    catalogue.add(text, None, where, auto_comments=comments, context=context)
    return catalogue


def written(catalogue: Catalog) -> bytes:
    """Return a catalogue as the bytes of a PO file."""
    buffer = io.BytesIO()
    write_po(buffer, catalogue, include_lineno=False, sort_output=True, width=98)
    return buffer.getvalue()


def compiled(catalogue: Catalog) -> bytes:
    """Return a catalogue as the bytes of an MO file."""
    buffer = io.BytesIO()
    write_mo(buffer, catalogue)
    return buffer.getvalue()


def english(template: Catalog) -> Plain:
    """Return the catalogue of English, in which each text stands for itself."""
    catalogue = Plain("en")
    for message in template:
        if message.id:
            catalogue.add(message.id, message.id, message.locations)
    return catalogue


def updated(path: Path, language: str, template: Catalog) -> Plain:
    """Return a language's catalogue with the template's texts, those translated kept."""
    with path.open("rb") as file:
        before = read_po(file, locale=language)
    catalogue = Plain(language)
    for message in template:
        if message.id:
            known = before.get(message.id)
            translation = known.string if known is not None and not known.fuzzy else ""
            catalogue.add(message.id, translation, message.locations)
    return catalogue


def main() -> int:
    """Collect, bring up to date and compile."""
    template = collected()
    LOCALES.mkdir(exist_ok=True)
    (LOCALES / "study.pot").write_bytes(written(template))
    languages = {path.parents[1].name for path in LOCALES.glob("*/LC_MESSAGES/study.po")} | {"en"}
    for language in sorted(languages):
        folder = LOCALES / language / "LC_MESSAGES"
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / "study.po"
        catalogue = english(template) if language == "en" else updated(path, language, template)
        path.write_bytes(written(catalogue))
        (folder / "study.mo").write_bytes(compiled(catalogue))
    print(
        f"{sum(1 for message in template if message.id)} texts, in {', '.join(sorted(languages))}"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
