"""What `study whatif` found: a folder of CSV tables and one file that vouches for them.

    FOLDER/whatif.json    what was asked, versions, and the SHA-256 and columns of each table
    FOLDER/choices.csv    ... one file a table of `study.whatif_tables`

Written by `study`, read by `analysis`. Reading trusts nothing: size, hash, columns and types are
checked. Tables are for their owner alone: they tell of participants.
"""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import io
import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from study.errors import StudyError
from study.whatif_tables import COLUMNS
from study.whole_file import replace_text

FORMAT = 1
HEAD = "whatif.json"
MAX_HEAD_BYTES = 1_000_000
MAX_TABLE_BYTES = 500_000_000

FORMULA_SIGNS = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
"""With what a text begins that spreadsheets run: such a text gets an apostrophe before it."""

Columns = dict[str, list[Any]]
"""A table: a list of values for each column, all of one length."""


@dataclasses.dataclass(frozen=True, slots=True)
class Head:
    """What a folder of tables says of itself.

    Attributes:
        settings: what was asked for, and in words what could not be answered.
        versions: of program and packages, by name.
        digests: SHA-256 of each table's file, hexadecimal.
    """

    settings: Mapping[str, Any]
    versions: Mapping[str, str]
    digests: Mapping[str, str]


def write_what_if(
    folder: Path,
    tables: Mapping[str, Columns],
    settings: Mapping[str, Any],
    versions: Mapping[str, str],
) -> None:
    """Write all tables; those of an earlier time are replaced, and the head comes last.

    Raises:
        StudyError: the folder cannot be made or holds other files, or one cannot be written.
        ValueError: a table's columns are not as `COLUMNS` says.
    """
    ours = {HEAD, *(f"{name}.csv" for name in COLUMNS)}
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        there = [path.name for path in folder.iterdir()]
        others = sorted(name for name in there if not name.startswith(".") and name not in ours)
        if others:
            raise StudyError(
                f"{folder} holds other files ({others[0]})", "Give another folder with --output."
            )
        # Without its head a folder of tables is none: nobody reads half of it.
        (folder / HEAD).unlink(missing_ok=True)
        described: dict[str, Any] = {}
        for name, declared in COLUMNS.items():
            text = _as_csv(name, declared, tables[name])
            replace_text(folder / f"{name}.csv", text, private=True)
            described[name] = {
                "sha256": hashlib.sha256(text.encode()).hexdigest(),
                "rows": len(next(iter(tables[name].values()))),
                "columns": {
                    column: {"type": kind, "unit": unit, "meaning": meaning}
                    for column, (kind, unit, meaning) in declared.items()
                },
            }
        content = {
            "format": FORMAT,
            "kind": "what_if",
            "settings": dict(settings),
            "versions": dict(versions),
            "tables": described,
        }
        text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        replace_text(folder / HEAD, text, private=True)
    except OSError as error:
        raise StudyError(
            f"{folder} cannot be written: {error.strerror}", "Give another folder with --output."
        ) from error


def read_head(folder: Path) -> Head:
    """Read what a folder says of itself.

    Raises:
        StudyError: it is no folder of `study whatif`, or damaged.
    """
    path = folder / HEAD
    hint = "Give the folder that `study whatif` wrote."
    try:
        if path.stat().st_size > MAX_HEAD_BYTES:
            raise StudyError(f"{path}: larger than {MAX_HEAD_BYTES} bytes", hint)
        content = json.loads(path.read_bytes())
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}", hint) from error
    except (ValueError, RecursionError) as error:
        raise StudyError(f"{path}: damaged: no JSON", hint) from error
    if not isinstance(content, dict) or content.get("kind") != "what_if":
        raise StudyError(f"{path}: no tables of `study whatif`", hint)
    if content.get("format") != FORMAT:
        raise StudyError(
            f"{path}: format {str(content.get('format'))[:20]}; this program reads {FORMAT}",
            "Make the tables anew with `study whatif`.",
        )
    tables, settings = content.get("tables"), content.get("settings")
    versions = content.get("versions")
    if not (isinstance(tables, dict) and isinstance(settings, dict) and isinstance(versions, dict)):
        raise StudyError(f"{path}: damaged: a part of it is missing", hint)
    digests = {
        name: str(tables[name].get("sha256"))
        for name in COLUMNS
        if isinstance(tables.get(name), dict)
    }
    if set(digests) != set(COLUMNS):
        raise StudyError(f"{path}: damaged: it does not name every table", hint)
    return Head(
        settings=settings,
        versions={str(name)[:100]: str(value)[:100] for name, value in versions.items()},
        digests=digests,
    )


def read_table(folder: Path, head: Head, name: str) -> Columns:
    """Read one table and check it against the head.

    Raises:
        StudyError: it is missing, too large, damaged, or not as `COLUMNS` says.
    """
    path = folder / f"{name}.csv"
    try:
        if path.stat().st_size > MAX_TABLE_BYTES:
            raise StudyError(f"{path}: larger than {MAX_TABLE_BYTES} bytes")
        data = path.read_bytes()
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror}") from error
    if hashlib.sha256(data).hexdigest() != head.digests[name]:
        raise StudyError(
            f"{path}: not the table that {HEAD} vouches for",
            "It was changed or damaged: make the tables anew with `study whatif`.",
        )
    declared = COLUMNS[name]
    try:
        rows = list(csv.reader(io.StringIO(data.decode("utf-8"), newline="")))
        if rows[0] != list(declared):
            raise ValueError("other columns")
        values = list(zip(*rows[1:], strict=True)) or [()] * len(declared)
        return {
            column: [_parsed(text, kind) for text in texts]
            for (column, (kind, _, _)), texts in zip(declared.items(), values, strict=True)
        }
    except (ValueError, IndexError, csv.Error) as error:
        raise StudyError(f"{path}: not as declared: {error}") from error


def _as_csv(name: str, declared: Mapping[str, Any], table: Columns) -> str:
    """Return a table as CSV: true and false as words, a missing number as nothing."""
    if list(table) != list(declared):
        raise ValueError(f"table {name}: columns {list(table)}, declared {list(declared)}")
    if len({len(values) for values in table.values()}) > 1:
        raise ValueError(f"table {name}: columns of different lengths")
    columns = [
        _written(values, kind)
        for values, (kind, _, _) in zip(table.values(), declared.values(), strict=True)
    ]
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(declared)
    writer.writerows(zip(*columns, strict=True))
    return buffer.getvalue()


def _written(values: Sequence[Any], kind: str) -> Sequence[Any]:
    if kind == "boolean":
        return ["true" if value else "false" for value in values]
    if kind == "number":
        return ["" if value is None or math.isnan(value) else value for value in values]
    if kind == "text":
        return [f"'{text}" if text.startswith(FORMULA_SIGNS) else text for text in values]
    return values


def _parsed(text: str, kind: str) -> Any:  # noqa: ANN401 - by the column's type
    if kind == "text":
        return text[1:] if text.startswith("'") and text[1:].startswith(FORMULA_SIGNS) else text
    if kind == "whole":
        return int(text)
    if kind == "boolean":
        if text not in ("true", "false"):
            raise ValueError(f"{text[:20]!r} is neither true nor false")
        return text == "true"
    value = float(text) if text else math.nan
    if math.isinf(value):
        raise ValueError("a number is not finite")
    return value
