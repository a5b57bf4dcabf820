"""How a record's fields are declared: once, with number, wire kind, unit and shape.

A record is a frozen dataclass whose fields are made by the functions below. The same
declaration serves the encoder, the descriptor embedded in every recording and the
reference of the format, so the three cannot drift apart.

Field numbers are part of the file format: they are never changed and never reused.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, ClassVar, Literal, Self, TypeVar, dataclass_transform

Kind = Literal[
    "fixed64",
    "sfixed32",
    "double",
    "bool",
    "string",
    "bytes",
    "floats",
    "doubles",
    "ints",
    "strings",
]
Family = Literal["input", "event", "shell"]
T = TypeVar("T")


@dataclasses.dataclass(frozen=True, slots=True)
class Wire:
    """One field's place in the file: its number, wire kind, unit, shape and meaning."""

    number: int
    kind: Kind
    text: str
    unit: str = ""
    shape: str = ""


def _declare(kind: Kind) -> Callable[..., Any]:
    def make(number: int, text: str, *, unit: str = "", shape: str = "") -> Any:  # noqa: ANN401
        wire = Wire(number=number, kind=kind, text=text, unit=unit, shape=shape)
        return dataclasses.field(metadata={"wire": wire})

    make.__doc__ = f"Declare a field of wire kind ``{kind}``."
    return make


fixed64 = _declare("fixed64")
"""A whole number from 0 to 2**64 - 1 (``int``)."""
sfixed32 = _declare("sfixed32")
"""A whole number from -2**31 to 2**31 - 1 (``int``)."""
double = _declare("double")
"""A ``float``."""
boolean = _declare("bool")
"""A ``bool``."""
string = _declare("string")
"""A ``str``."""
blob = _declare("bytes")
"""Opaque ``bytes``."""
floats = _declare("floats")
"""A NumPy float32 array, flattened in C order."""
doubles = _declare("doubles")
"""A NumPy float64 array, flattened in C order."""
ints = _declare("ints")
"""A NumPy int32 array, flattened in C order."""
strings = _declare("strings")
"""A ``tuple`` of ``str``."""


class Record:
    """Base of everything a recording holds.

    Attributes:
        family: whether the record is an input, an event or a shell observation.
        topic: the MCAP topic it is written to.
    """

    family: ClassVar[Family]
    topic: ClassVar[str]
    t_ns: int

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """Return the record itself: nobody changes one."""
        return self


def wire_fields(record_type: type[Record]) -> dict[str, Wire]:
    """Return the declared fields of a record type, by name, in field-number order."""
    declared = {
        field.name: field.metadata["wire"]
        for field in dataclasses.fields(record_type)  # type: ignore[arg-type]
    }
    return dict(sorted(declared.items(), key=lambda item: item[1].number))


_REGISTRY: dict[str, type[Record]] = {}


@dataclass_transform(
    eq_default=False,
    frozen_default=True,
    field_specifiers=(
        fixed64,
        sfixed32,
        double,
        boolean,
        string,
        blob,
        floats,
        doubles,
        ints,
        strings,
    ),
)
def record(family: Family, topic: str) -> Callable[[type[T]], type[T]]:
    """Class decorator: make a frozen dataclass a record under ``<family>/<topic>``.

    Raises:
        ValueError: the topic is taken, or two fields share a number.
    """

    def decorate(cls: type[T]) -> type[T]:
        made: Any = dataclasses.dataclass(frozen=True, slots=True, eq=False)(cls)
        made.family = family
        made.topic = f"{family}/{topic}"
        if made.topic in _REGISTRY:
            raise ValueError(f"topic {made.topic} is declared twice")
        numbers = [wire.number for wire in wire_fields(made).values()]
        if len(set(numbers)) != len(numbers):
            raise ValueError(f"{made.__name__}: two fields share a number: {numbers}")
        _REGISTRY[made.topic] = made
        return made  # type: ignore[no-any-return]

    return decorate


def record_types() -> dict[str, type[Record]]:
    """Return every declared record type by topic, in order of topic."""
    # The registry fills on import; these three modules declare every record there is.
    from study.events import events, inputs, shell  # noqa: F401, PLC0415

    return dict(sorted(_REGISTRY.items()))
