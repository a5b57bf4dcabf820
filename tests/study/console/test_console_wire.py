"""Lines from a socket: a command, or a refusal in words; never anything else."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from study.console.wire import (
    LONGEST_COMMAND,
    LONGEST_TEXT,
    Answer,
    Command,
    Ended,
    parse_command,
    parse_said,
)
from study.errors import StudyError


def command_or_refusal(line: bytes) -> Command | str:
    """Return the command in a line, or why it is refused."""
    try:
        return parse_command(line)
    except StudyError as error:
        return str(error)


@given(line=st.binary(max_size=200))
def test_noise_is_refused_in_words(line: bytes) -> None:
    """Whatever the bytes are."""
    found = command_or_refusal(line)
    assert isinstance(found, Command) or 0 < len(found) < 600


@given(
    given_value=st.recursive(
        st.none() | st.booleans() | st.floats() | st.integers() | st.text(max_size=20),
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
        max_leaves=8,
    )
)
def test_any_json_is_a_command_or_refused(given_value: object) -> None:
    """Other types, missing and unknown keys; as the text of a command too."""
    for value in (given_value, {"command": "annotate", "text": given_value}):
        try:
            found = parse_command(json.dumps(value).encode())
        except StudyError:
            continue
        assert found.command in ("pause", "resume", "annotate", "end")


@given(text=st.text(max_size=LONGEST_TEXT))
def test_a_note_is_one_printable_line(text: str) -> None:
    """Any signs at all, lone surrogates included; what is kept can be recorded."""
    line = json.dumps({"command": "annotate", "text": text}).encode()
    if len(line) > LONGEST_COMMAND:
        return
    command = command_or_refusal(line)
    if isinstance(command, str):
        assert "needs a note" in command or "no command" in command
        return
    assert command.text.isprintable()
    assert command.text
    command.text.encode()
    assert set(command.text) <= set(text) | {" "}


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (b"", "no command"),
        (b"[" * 8000, "no command"),
        (b'{"command": "dance"}', "command"),
        (b'{"command": "pause", "text": "x"}', "takes no text"),
        (b'{"command": "pause", "then": 1}', "then"),
        (b'{"command": "end", "text": " \\t "}', "needs a reason"),
        (b'{"command": "annotate"}', "needs a note"),
        (b'{"command": "annotate", "text": 7}', "text"),
        (b'{"command": "annotate", "text": "' + b"x" * 501 + b'"}', "at most 500"),
        (b'{"command": "annotate", "text": "' + b"x" * 9000 + b'"}', "at most 8192"),
    ],
)
def test_each_refusal_says_what_is_wrong(line: bytes, words: str) -> None:
    with pytest.raises(StudyError, match=words):
        parse_command(line)


@given(line=st.binary(max_size=200))
def test_a_console_takes_no_noise_either(line: bytes) -> None:
    """What is no line of a session is said to be of another version."""
    with pytest.raises(StudyError, match="does not understand"):
        parse_said(line)


def test_what_a_session_says_is_understood() -> None:
    """Keys that a later version adds are passed over."""
    said = parse_said(b'{"kind": "answer", "command": "pause", "refused": "", "new": [1]}')
    assert said == Answer(command="pause")
    ended = Ended(complete=False, reason="fire drill")
    assert parse_said(ended.model_dump_json().encode()) == ended
