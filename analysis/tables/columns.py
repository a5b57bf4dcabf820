"""Declared columns, and the table that checks its data against them."""

from __future__ import annotations

import dataclasses
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal

import pandas as pd

DType = Literal["text", "label", "integer", "number", "boolean"]

_PANDAS_DTYPE: dict[DType, str] = {
    "text": "str",
    "label": "category",
    "integer": "int64",
    "number": "float64",
    "boolean": "bool",
}
_FORMULA_SIGNS = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
"""With what a text begins that spreadsheets run; the wide forms are theirs in some locales."""


@dataclasses.dataclass(frozen=True, slots=True)
class Column:
    """One column of a table.

    Attributes:
        name: its name in the file.
        dtype: "label" is text with few distinct values, held compactly.
        text: what it means.
        unit: its unit, or empty.
    """

    name: str
    dtype: DType
    text: str
    unit: str = ""


SESSION_COLUMNS = (
    Column("participant", "label", "pseudonymous id of the participant"),
    Column("session", "label", "identifier of the session"),
)
"""The first columns of every table."""

DATA_COLUMN = Column("data", "label", "who produced the data: persons, or simulated participants")
"""The last column of every exported table."""


class Table:
    """A data frame whose columns are what was declared.

    Args:
        name: the file's stem.
        text: what a row is.
        columns: the declared columns, in order.
        data: the columns' values, by name.

    Raises:
        ValueError: names differ from those declared, lengths differ, or values cannot be
            held by the declared type.
    """

    def __init__(
        self, name: str, text: str, columns: Sequence[Column], data: Mapping[str, Any]
    ) -> None:
        self.name = name
        self.text = text
        self.columns = tuple(columns)
        expected = [column.name for column in columns]
        if list(data) != expected:
            missing = sorted(set(expected) - set(data))
            extra = sorted(set(data) - set(expected))
            raise ValueError(
                f"table {name}: columns differ from those declared: missing {missing}, "
                f"not declared {extra}, or in another order"
            )
        series = {column.name: _checked(name, column, data[column.name]) for column in columns}
        lengths = {len(values) for values in series.values()}
        if len(lengths) > 1:
            raise ValueError(f"table {name}: columns have different lengths: {sorted(lengths)}")
        self.frame = pd.DataFrame(series)

    @classmethod
    def from_rows(
        cls,
        name: str,
        text: str,
        columns: Sequence[Column],
        rows: Sequence[Mapping[str, Any]],
    ) -> Table:
        """Build a table from one mapping a row; each must hold exactly the declared columns."""
        expected = {column.name for column in columns}
        for row in rows:
            if set(row) != expected:
                raise ValueError(f"table {name}: a row differs in {sorted(set(row) ^ expected)}")
        data = {column.name: [row[column.name] for row in rows] for column in columns}
        return cls(name, text, columns, data)

    def __len__(self) -> int:
        return len(self.frame)

    def to_csv(self, data: str | None, *, header: bool = True, points: bool = True) -> str:
        """Return the table as CSV.

        Args:
            data: who produced the data: the value of the last column; None for no such column.
            header: whether the first line names the columns.
            points: whether a whole value in a column of numbers is written "2.0", not "2".
        """
        buffer = io.StringIO()
        frame = self._safe_frame(data)
        written = None if points else _without_point
        frame.to_csv(buffer, index=False, header=header, lineterminator="\n", float_format=written)
        return buffer.getvalue()

    def _safe_frame(self, data: str | None) -> pd.DataFrame:
        """Return the data as they are exported, with who produced them in the last column.

        Text that a spreadsheet would take for a formula gets a leading apostrophe.
        """
        frame = self.frame.copy(deep=False)
        for column in self.columns:
            if column.dtype in ("text", "label"):
                frame[column.name] = _neutralised(frame[column.name])
        if data is not None:
            frame[DATA_COLUMN.name] = data
        return frame


def _without_point(value: object) -> str:
    """Write a number in full, a whole one without a point."""
    return repr(float(str(value))).removesuffix(".0")


def _checked(table: str, column: Column, values: object) -> pd.Series[Any]:
    series: pd.Series[Any] = pd.Series(values)
    if column.dtype in ("integer", "boolean", "text", "label") and bool(series.isna().any()):
        raise ValueError(f"table {table}: column {column.name} has missing values")
    if column.dtype == "integer" and len(series) and series.dtype.kind not in "iu":
        raise ValueError(f"table {table}: column {column.name} holds {series.dtype}, not integers")
    if column.dtype == "boolean" and len(series) and series.dtype.kind != "b":
        raise ValueError(f"table {table}: column {column.name} holds {series.dtype}, not booleans")
    if column.dtype in ("text", "label") and len(series) and series.dtype.kind in "iufb":
        raise ValueError(f"table {table}: column {column.name} holds {series.dtype}, not text")
    try:
        return series.astype(_PANDAS_DTYPE[column.dtype])  # type: ignore[call-overload, no-any-return]
    except (TypeError, ValueError) as error:
        raise ValueError(f"table {table}: column {column.name}: {error}") from error


def joined(parts: Sequence[Table]) -> Table:
    """Put tables with the same columns one below the other.

    Args:
        parts: at least one.
    """
    first = parts[0]
    if len(parts) == 1:
        return first
    data: dict[str, Any] = {}
    for column in first.columns:
        pieces = [part.frame[column.name] for part in parts]
        if column.dtype == "label":
            # As plain text: a session without rows has categories of no type to unite.
            data[column.name] = pd.concat([p.astype("str") for p in pieces], ignore_index=True)
        else:
            data[column.name] = pd.concat(pieces, ignore_index=True)
    return Table(first.name, first.text, first.columns, data)


def csv_pieces(parts: Iterable[Table], data: str) -> Iterator[str]:
    """Yield tables with the same columns as one text of CSV, piece by piece.

    Args:
        parts: the tables, in order.
        data: who produced the data: the value of the last column.
    """
    for place, part in enumerate(parts):
        yield part.to_csv(data, header=place == 0)


def _neutralised(values: pd.Series[Any]) -> pd.Series[Any]:
    """Put an apostrophe before text that a spreadsheet would run as a formula."""
    distinct = [str(value) for value in values.unique()]
    harmful = {value: f"'{value}" for value in distinct if value.startswith(_FORMULA_SIGNS)}
    if not harmful:
        return values
    text: pd.Series[Any] = values.astype("str")
    return text.replace(harmful)
