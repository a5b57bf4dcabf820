"""Hypothesis strategies for every declared record, made from the declarations themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from study.events.fields import Record, Wire, record_types, wire_fields
from study.recording.protobuf_format import ARRAY_DTYPES

_TEXT = st.text(st.characters(exclude_categories=["Cs"]), max_size=200)
_SCALARS: dict[str, st.SearchStrategy[Any]] = {
    "fixed64": st.integers(0, 2**64 - 1),
    "sfixed32": st.integers(-(2**31), 2**31 - 1),
    "double": st.floats(),
    "bool": st.booleans(),
    "string": _TEXT,
    "bytes": st.binary(max_size=300),
    "strings": st.lists(_TEXT, max_size=4).map(tuple),
}
_NUMBERS: dict[str, st.SearchStrategy[Any]] = {
    "floats": st.floats(width=32),
    "doubles": st.floats(),
    "ints": st.integers(-(2**31), 2**31 - 1),
}


def _size(draw: st.DrawFn, wire: Wire, robots: int) -> tuple[int, ...]:
    if wire.shape == "n,d":
        return (robots, draw(st.integers(1, 5)) if robots else 0)
    if wire.shape == "n":
        return (robots,)
    if wire.shape == "n or 0":
        return (draw(st.sampled_from([0, robots])),)
    return (draw(st.integers(0, 40)),)


@st.composite
def records_of(draw: st.DrawFn, record_type: type[Record]) -> Record:
    """Draw a record of one type; arrays have the shapes that are declared."""
    fields = wire_fields(record_type)
    robots = draw(st.integers(0, 20)) if "robots" in fields else 0
    values: dict[str, Any] = {}
    for name, wire in fields.items():
        if name == "robots":
            values[name] = robots
        elif wire.kind in ARRAY_DTYPES:
            shape = _size(draw, wire, robots)
            count = int(np.prod(shape))
            numbers = draw(st.lists(_NUMBERS[wire.kind], min_size=count, max_size=count))
            values[name] = np.array(numbers, ARRAY_DTYPES[wire.kind]).reshape(shape)
        else:
            values[name] = draw(_SCALARS[wire.kind])
    made: Any = record_type
    return made(**values)  # type: ignore[no-any-return]


def any_record() -> st.SearchStrategy[Record]:
    """Draw a record of any type."""
    return st.sampled_from(list(record_types().values())).flatmap(records_of)
