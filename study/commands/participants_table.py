"""Participants in a table for each study, as wide as the terminal; no pseudonym is broken."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from rich.markup import escape
from rich.table import Table

from study.enrolment.participants import HOLDING, Participant

_CHANGED = "changed, UTC"
_DROPPED = (_CHANGED, "sessions")
"""Columns that a narrow terminal goes without, the first first; --json has them all."""
_WHOLE = ("pseudonym", _CHANGED)
"""Columns whose cells are never broken over lines."""
_FOLDED = ("remarks", "order")
"""Columns whose words are broken if there is no room for them, the first first."""
_FRAME = 3
"""What a column takes beside its cells; the frame's end is one more."""


def participants_tables(found: Sequence[Participant], width: int) -> Iterator[Table]:
    """Yield a table for each study, by its name: slots and orders are counted within one.

    Args:
        found: those to show.
        width: of the terminal, in characters.
    """
    for study in sorted({each.study for each in found}):
        yield _table(study, [each for each in found if each.study == study], width)


def _table(study: str, found: Sequence[Participant], width: int) -> Table:
    """Return the table of one study, with how often each order is used below it."""
    columns = {
        "slot": [_slot(each) for each in found],
        "pseudonym": [each.pseudonym for each in found],
        "state": [each.shown_state for each in found],
        "order": [", ".join(each.order) for each in found],
        "sessions": [str(each.sessions) for each in found],
        _CHANGED: [each.changed_utc.replace("T", " ")[:16] for each in found],
        "remarks": ["; ".join(filter(None, (each.reason, each.note))) for each in found],
    }
    if not any(columns["remarks"]):
        del columns["remarks"]
    least = {name: _least(name, cells) for name, cells in columns.items()}
    if _width(least) > width:
        # The day says most of it; --json has the time.
        columns[_CHANGED] = [each.changed_utc[:10] for each in found]
        least[_CHANGED] = _least(_CHANGED, columns[_CHANGED])
    for name in _DROPPED:
        if _width(least) > width:
            del least[name]
    table = Table(title=escape(study), caption=_balance(study, found))
    natural = {name: max(map(len, (name, *columns[name]))) for name in least}
    for name, given in _shared(least, natural, width).items():
        table.add_column(name, width=given, no_wrap=name in _WHOLE, overflow="fold")
    for row in zip(*(columns[name] for name in least), strict=True):
        table.add_row(*map(escape, row))
    return table


def _slot(each: Participant) -> str:
    slot = str(each.slot) if each.state in HOLDING else "-"
    return f"pilot {slot}" if each.pilot else slot


def _least(name: str, cells: Sequence[str]) -> int:
    """Return the width that a column needs so that no word of it is broken, or no cell."""
    if name in _WHOLE:
        return max(map(len, (name, *cells)))
    return max(len(word) for cell in (name, *cells) for word in cell.split() or [""])


def _shared(least: Mapping[str, int], natural: Mapping[str, int], width: int) -> dict[str, int]:
    """Return how wide each column is, so that no word is broken wherever that can be had."""
    widths = dict(least)
    # Rather than an order, which is a row of names, remarks are broken.
    for name in _FOLDED:
        excess = _width(widths) - width
        if name in widths and excess > 0:
            widths[name] = max(min(len(name), widths[name]), widths[name] - excess)
    for _ in range(width - _width(widths)):
        # To the column that needs most lines, for what is left.
        name = max(widths, key=lambda name: natural[name] / widths[name])
        if natural[name] > widths[name]:
            widths[name] += 1
    return widths


def _width(least: Mapping[str, int]) -> int:
    """Return the least width of the table."""
    return sum(least.values()) + _FRAME * len(least) + 1


def _balance(study: str, found: Sequence[Participant]) -> str:
    holding = [each for each in found if each.state in HOLDING and not each.pilot]
    balance = Counter(", ".join(each.order) for each in holding)
    counts = "; ".join(f"{number} x {order}" for order, number in sorted(balance.items()))
    return f"{escape(study)}: {counts or 'no slot taken'}"
