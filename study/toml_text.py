"""Texts and TOML files that people write: read within bounds, refused in one message."""

from __future__ import annotations

import codecs
import tomllib
from typing import Any

from study.errors import ProtocolError, StudyError

DEEPEST = 64
"""Tables and lists within one another; what people write has half a dozen."""
_BOM = "\ufeff"
_LARGEST = 2**63
_TOO_LARGE = "not TOML: a whole number beyond 64 bits"
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def decoded(data: bytes, source: str) -> str:
    """Return the text of a file's bytes, without the mark that some editors put before it.

    Args:
        data: all of them.
        source: the file's name, for messages.

    Raises:
        StudyError: it is no UTF-8; the message says what it is instead, if that can be told.
    """
    # Latin letters in UTF-16 have a zero byte each; no TOML holds one.
    if data.startswith(_UTF16) or data[:4:2] == b"\0\0" or data[1:4:2] == b"\0\0":
        raise StudyError(
            f"{source}: UTF-16 text, not UTF-8",
            "Save the file as UTF-8: most editors offer the encoding under Save As.",
        )
    try:
        return data.decode("utf-8").removeprefix(_BOM)
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise StudyError(
            f"{source}: not UTF-8 text: line {line} has the byte 0x{data[error.start]:02x}",
            "Save the file as UTF-8: most editors offer the encoding under Save As.",
        ) from error


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Read TOML, whoever wrote it and however odd it is.

    Args:
        text: the file's.
        source: its name, for messages.

    Raises:
        ProtocolError: it is no TOML, or nested deeper than anything that is meant.
    """
    try:
        raw = tomllib.loads(text.removeprefix(_BOM))
    except RecursionError as error:
        raise _too_deep(source) from error
    except tomllib.TOMLDecodeError as error:
        raise ProtocolError(source, [f"not TOML: {error}"]) from error
    except ValueError as error:
        # Python refuses to make a number of so many digits.
        raise ProtocolError(source, [_TOO_LARGE]) from error
    # Dotted keys nest without recursion here, but not in what reads the result.
    level: list[Any] = [raw]
    for _ in range(DEEPEST):
        level = [inner for outer in level for inner in _inside(outer)]
        if any(isinstance(each, int) and abs(each) > _LARGEST for each in level):
            raise ProtocolError(source, [_TOO_LARGE])
        if not level:
            return raw
    raise _too_deep(source)


def _inside(outer: object) -> list[Any]:
    if isinstance(outer, dict):
        return list(outer.values())
    return outer if isinstance(outer, list) else []


def _too_deep(source: str) -> ProtocolError:
    problem = f"nested too deeply: tables and lists stand at most {DEEPEST} deep in one another"
    return ProtocolError(source, [problem])
