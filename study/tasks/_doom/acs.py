"""A small assembler for the engine's script language: labels, variables, one lump of bytes.

The engine's compiled scripts ("ACS0") are 32-bit little-endian words: an instruction's number,
then its operands. The numbers here are those of the engine's public header; only the ones that
the map's scripts need are listed.
"""

from __future__ import annotations

import struct
from enum import IntEnum

FIXED = 65536
"""One unit in the engine's 16.16 fixed-point numbers."""

_ENTER = 4000
"""Added to a script's number: it starts by itself when the player enters the map."""


class Op(IntEnum):
    """Instructions by number. Operands come from the stack unless noted."""

    TERMINATE = 1
    PUSH = 3  # a word
    ADD = 14
    SUBTRACT = 15
    LESS = 21
    GREATER = 22
    AT_MOST = 23
    AT_LEAST = 24
    STORE_LOCAL = 25  # a variable
    STORE_MAP = 26  # a variable
    LOAD_LOCAL = 28  # a variable
    LOAD_MAP = 29  # a variable
    GO = 52  # an address
    GO_IF = 53  # an address
    DROP = 54
    DELAY = 55
    AND = 70
    AND_BITS = 72
    SHIFT_RIGHT = 77
    GO_UNLESS = 79  # an address
    FIXED_MULTIPLY = 136
    STORE_GLOBAL = 181  # a variable
    LOAD_GLOBAL = 182  # a variable
    ACTOR_X = 196
    ACTOR_Y = 197
    SET_PROPERTY = 245
    SET_ANGLE = 276
    SET_POSITION = 283
    CALL = 351  # how many arguments, which function


SET_VELOCITY = 23
"""Number of the engine's function that `Op.CALL` names."""


class Program:
    """Scripts in the making; `behavior` gives the lump."""

    def __init__(self) -> None:
        self._words: list[int | str] = []
        self._labels: dict[str, int] = {}
        self._scripts: list[tuple[int, int, int]] = []

    def script(self, number: int, arguments: int, *, at_enter: bool = False) -> None:
        """Begin a script.

        Args:
            number: by which it is called.
            arguments: how many it takes; they are its first variables.
            at_enter: start it when the player enters the map.
        """
        self._scripts.append((number + _ENTER * at_enter, len(self._words), arguments))

    def label(self, name: str) -> None:
        """Name the place that the next instruction has."""
        self._labels[name] = len(self._words)

    def add(self, *words: Op | int | str) -> None:
        """Append instructions and operands; a text operand is a label."""
        self._words += words

    def push(self, *values: int) -> None:
        """Append instructions that put numbers onto the stack."""
        for value in values:
            self.add(Op.PUSH, value)

    def behavior(self) -> bytes:
        """Return the compiled lump.

        Raises:
            KeyError: a label is used but not set.
            struct.error: a number needs more than 32 bits.
        """
        head = struct.pack("<4sI", b"ACS\0", 8 + 4 * len(self._words))
        addresses = [
            8 + 4 * self._labels[word] if isinstance(word, str) else word for word in self._words
        ]
        code = struct.pack(f"<{len(addresses)}i", *addresses)
        directory = struct.pack("<I", len(self._scripts))
        for number, start, arguments in self._scripts:
            directory += struct.pack("<III", number, 8 + 4 * start, arguments)
        return head + code + directory + struct.pack("<I", 0)
