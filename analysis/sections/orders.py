"""Orders that were not run as the design or the plan has them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from analysis.formatting import counted
from analysis.places import UNKNOWN, holds_slot
from analysis.protocol_facts import ProtocolFacts
from analysis.recordings import Session, StudyRecordings
from study.orders import possible_orders


def changed_orders(study: StudyRecordings, facts: ProtocolFacts) -> list[tuple[str, str]]:
    """Say of whom another order was run than the plan had, or one that is none of the design.

    Returns:
        (participant, what is so) for each of them.
    """
    found = []
    for session in study.sessions:
        ran, planned = session.opened.order, session.planned_order
        designed = _designed(session.protocol)
        parts = [f"{_in_words(ran, facts)} was run"]
        if planned and ran != planned:
            parts.append(f"the plan had {_in_words(planned, facts)}")
        if designed and ran not in designed:
            parts.append("it is none of the design's orders")
        if len(parts) > 1:
            text = "; ".join(parts)
            found.append((session.opened.participant, text[:1].upper() + text[1:]))
    return found


def uneven_orders(study: StudyRecordings, facts: ProtocolFacts) -> str:
    """Say how often each order was run if that differs by more than one; empty otherwise.

    As in the register, those count who hold a slot; how many do not is said beside it. Nothing is
    said of sessions that were pooled from several designs.
    """
    designs = {tuple(_designed(session.protocol)) for session in study.sessions}
    if len(designs) != 1:
        return ""
    (designed,) = designs
    ran = Counter(session.opened.order for session in study.sessions if holds_slot(session))
    counts = [ran[order] for order in designed]
    if not counts or max(counts) - min(counts) <= 1:
        return ""
    told = [
        f"{count} × {_in_words(order, facts)}"
        for order, count in zip(designed, counts, strict=True)
    ]
    return "; ".join(filter(None, (*told, _drop_outs_in_words(study.sessions))))


def _drop_outs_in_words(sessions: Sequence[Session]) -> str:
    """Say which of these sessions count in no order's balance; empty if all do."""
    gone = [session for session in sessions if not holds_slot(session)]
    early = sum(session.slot == UNKNOWN for session in gone)
    parts = []
    if len(gone) > early:
        count = len(gone) - early
        verbs = ("holds", "is") if count == 1 else ("hold", "are")
        parts.append(
            f"{counted(count, 'drop-out')}, who {verbs[0]} no slot, {verbs[1]} not counted"
        )
    if early:
        verb = "is" if early == 1 else "are"
        parts.append(f"{counted(early, 'session')} that ended early {verb} not counted")
    return "; ".join(parts)


def _designed(protocol: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the orders that a recorded protocol uses; none if it does not say."""
    phase, declared = protocol.get("phase_three"), protocol.get("conditions")
    design = phase.get("order") if isinstance(phase, Mapping) else None
    if not isinstance(design, str) or not isinstance(declared, list):
        return []
    names = [str(entry.get("name")) for entry in declared if isinstance(entry, Mapping)]
    return possible_orders(names, design)


def _in_words(order: tuple[str, ...], facts: ProtocolFacts) -> str:
    return " then ".join(facts.label(name) for name in order)
