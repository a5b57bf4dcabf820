"""The catalogue of what participants read: complete, and made by rule for the pseudo-locale."""

from __future__ import annotations

import ast
import re
import sys
from pathlib import Path

import pytest
from babel.messages.catalog import Message
from babel.messages.pofile import read_po
from hypothesis import given
from hypothesis import strategies as st

from study.errors import StudyError
from study.messages import LOCALES_FOLDER, PSEUDO_GROWTH, locales, messages_for, noted, pseudo

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

import write_catalogue  # noqa: E402 - a tool, not a package


def test_catalogue_holds_every_text_of_the_sources() -> None:
    """What `tools/write_catalogue.py` would write is what there is."""
    template = write_catalogue.collected()
    written = write_catalogue.written(template)
    assert (LOCALES_FOLDER / "study.pot").read_bytes() == written, "run tools/write_catalogue.py"
    english = write_catalogue.english(template)
    folder = LOCALES_FOLDER / "en" / "LC_MESSAGES"
    assert (folder / "study.po").read_bytes() == write_catalogue.written(english)
    assert (folder / "study.mo").read_bytes() == write_catalogue.compiled(english)


def _texts(message: Message) -> list[str]:
    given = message.string
    return [given] if isinstance(given, str) else [str(text) for text in given or ()]


def test_every_language_is_complete() -> None:
    """Each catalogue has each text with no other fields, none empty or marked as doubtful."""
    template = write_catalogue.collected()
    for path in LOCALES_FOLDER.glob("*/LC_MESSAGES/study.po"):
        with path.open("rb") as file:
            catalogue = read_po(file)
        for message in template:
            if not message.id:
                continue
            found = catalogue.get(message.id)
            assert found is not None, (path, message.id)
            assert not found.fuzzy, (path, message.id)
            fields = set(re.findall(r"\{\w+\}", str(message.id)))
            for text in _texts(found):
                assert text, (path, message.id)
                assert set(re.findall(r"\{\w+\}", text)) <= fields, (path, message.id)


def _calls(path: Path) -> list[tuple[str, list[ast.expr]]]:
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.Call):
            continue
        name = (
            node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        )
        found.append((name, node.args))
    return found


@pytest.mark.parametrize("folder", write_catalogue.SOURCES)
def test_no_text_is_put_together_before_it_is_looked_up(folder: str) -> None:
    """No f-string and no sum goes into the catalogue: such a text is never found there."""
    for path in sorted((ROOT / folder).rglob("*.py")):
        for name, arguments in _calls(path):
            if name in {"say", "noted"} and arguments:
                assert not isinstance(arguments[0], ast.JoinedStr | ast.BinOp), path


def test_english_stands_for_itself() -> None:
    """A text of the catalogue and one that is not in it come back as they were."""
    messages = messages_for("en")
    assert messages.say("Not in any catalogue") == "Not in any catalogue"
    assert messages.say("Robot {number}", number=7) == "Robot 7"
    assert messages.say("100 {percent}") == "100 {percent}"
    assert messages.say("") == ""
    assert [messages.count("{n} robot", "{n} robots", n) for n in (1, 2)] == ["1 robot", "2 robots"]
    assert noted("goal") == "goal"


def test_the_same_locale_is_the_same_object() -> None:
    """Texts depend on the locale alone, and are read once."""
    assert messages_for("en") is messages_for("en")
    assert messages_for("en") == messages_for("en")


def test_unknown_locale_is_refused_with_those_there_are() -> None:
    """The message names what was given and what there is."""
    with pytest.raises(StudyError, match='"xx"') as caught:
        messages_for("xx")
    assert "en, pseudo" in str(caught.value)
    assert locales()[0] == "en"
    assert locales()[-1] == "pseudo"


@given(st.text(st.characters(codec="ascii", exclude_characters="{}"), min_size=1, max_size=80))
def test_pseudo_texts_are_accented_bracketed_and_longer(text: str) -> None:
    """No plain letter is left, and a text of eight letters or more is about 40% longer."""
    made = pseudo(text)
    assert made.startswith("[")
    assert made.endswith("]")
    assert not re.search("[A-Za-z]", made)
    assert len(made) >= (1 + PSEUDO_GROWTH) * len(text) or len(text) < 5
    assert len(made) <= (1 + PSEUDO_GROWTH) * len(text) + 3
    assert (" " in made) == (" " in text)


def test_pseudo_keeps_fields() -> None:
    """What is filled in stays as it is."""
    made = messages_for("pseudo").say("Press {key} to drive {robot}", key="Space", robot=8)
    assert "Space" in made
    assert "8" in made
    assert not re.search("[A-Za-z]", made.replace("Space", ""))
