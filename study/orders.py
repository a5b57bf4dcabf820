"""Orders of conditions: who gets which first."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence


def balanced_latin_square(count: int) -> list[tuple[int, ...]]:
    """Return orders in which each condition stands in each place equally often.

    For an even count (and, with the reversed rows added, an odd one) each condition also
    follows each other one equally often (Williams 1949, "Experimental designs balanced
    for the estimation of residual effects of treatments").

    Args:
        count: number of conditions, at least 1.

    Returns:
        ``count`` orders if it is even or 1, else ``2 * count``; each a permutation of
        range(count).
    """
    zigzag = [0]
    low, high = 1, count - 1
    while len(zigzag) < count:
        zigzag.append(low if len(zigzag) % 2 else high)
        if len(zigzag) % 2:
            high -= 1
        else:
            low += 1
    rows = [tuple((start + place) % count for place in zigzag) for start in range(count)]
    if count % 2 and count > 1:
        rows += [row[::-1] for row in rows]
    return rows


def possible_orders(names: Sequence[str], design: str) -> list[tuple[str, ...]]:
    """Return the orders that a design uses, in the sequence in which they are given out.

    Args:
        names: the conditions, as listed in the protocol.
        design: "ab_ba", "latin_square" or "fixed".
    """
    if design == "fixed":
        return [tuple(names)]
    return [tuple(names[place] for place in row) for row in balanced_latin_square(len(names))]


def least_used_order(
    orders: Sequence[tuple[str, ...]], used: Sequence[tuple[str, ...]]
) -> tuple[str, ...]:
    """Return the order given out least often so far; ties go to the first listed."""
    counts = Counter(used)
    return min(orders, key=lambda order: (counts[order], orders.index(order)))
