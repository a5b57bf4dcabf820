"""Which characters a font file has: no function of pygame tells."""

from __future__ import annotations

import functools
import struct
from pathlib import Path


@functools.lru_cache(maxsize=8)
def letters_of(file: Path) -> frozenset[str]:
    """Return the characters that a font file (OpenType) has a glyph for.

    Args:
        file: one of the program's own, whose table of characters has format 4 or 12.
    """
    font = file.read_bytes()
    table = _character_table(font)
    best: dict[int, int] = {}
    (count,) = struct.unpack_from(">H", font, table + 2)
    for number in range(count):
        (offset,) = struct.unpack_from(">I", font, table + 4 + 8 * number + 4)
        (kind,) = struct.unpack_from(">H", font, table + offset)
        best[kind] = table + offset
    # One of format 12 has all of what one of format 4 has, and what lies beyond 16 bits.
    codes = _groups(font, best[12]) if 12 in best else _segments(font, best[4])
    return frozenset(map(chr, codes))


def _character_table(font: bytes) -> int:
    """Return where the table "cmap" begins."""
    (count,) = struct.unpack_from(">H", font, 4)
    for number in range(count):
        tag, _, offset, _ = struct.unpack_from(">4sIII", font, 12 + 16 * number)
        if tag == b"cmap":
            return int(offset)
    raise ValueError("the font has no table of its characters")


def _groups(font: bytes, start: int) -> list[int]:
    """Return the characters of a table of format 12: groups with running glyphs."""
    (count,) = struct.unpack_from(">I", font, start + 12)
    codes: list[int] = []
    for number in range(count):
        first, last, glyph = struct.unpack_from(">III", font, start + 16 + 12 * number)
        codes += (code for code in range(first, last + 1) if glyph + code - first)
    return codes


def _segments(font: bytes, start: int) -> list[int]:
    """Return the characters of a table of format 4: segments whose glyphs may stand in a list."""
    (doubled,) = struct.unpack_from(">H", font, start + 6)
    count = doubled // 2
    read = struct.Struct(f">{count}H")
    lasts = read.unpack_from(font, start + 14)
    firsts = read.unpack_from(font, start + 16 + doubled)
    shifts = read.unpack_from(font, start + 16 + 2 * doubled)
    lists = start + 16 + 3 * doubled
    codes: list[int] = []
    for number, offset in enumerate(read.unpack_from(font, lists)):
        for code in range(firsts[number], min(lasts[number], 0xFFFE) + 1):
            glyph = code
            if offset:
                place = lists + 2 * number + offset + 2 * (code - firsts[number])
                (glyph,) = struct.unpack_from(">H", font, place)
            if offset and not glyph:
                continue
            if (glyph + shifts[number]) % 0x10000:
                codes.append(code)
    return codes
