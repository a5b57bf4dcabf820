"""Deviations as the report tells them: each fact once, in words."""

from __future__ import annotations

import dataclasses

from analysis.tables.study_tables import StudyTables

_PAUSED_BY = {
    "experimenter_paused": "experimenter",
    "recording_interrupted": "recording interrupted",
}
"""Deviations that bring a pause about, and the reason that the pause's own row then gives."""


@dataclasses.dataclass(frozen=True, slots=True)
class Told:
    """One deviation.

    Attributes:
        participant: whose.
        session: identifier of the session.
        trial_id: the fleet run; -1 outside one.
        kept: false if a resumed session began anew before it.
        code: what kind it is.
        text: what happened, in words; the kind is among them.
    """

    participant: str
    session: str
    trial_id: int
    kept: bool
    code: str
    text: str


def told(tables: StudyTables) -> tuple[Told, ...]:
    """List the deviations; how long one made the session stand still is told with it."""
    found: list[Told] = []
    waiting: dict[tuple[str, bool, str], int] = {}
    rows = tables.frame("deviations")
    names = ("participant", "session", "trial_id", "kept", "code", "text")
    for who, session, trial_id, kept, code, text in zip(*(rows[n] for n in names), strict=True):
        if code == "paused":
            stood, _, why = str(text).rpartition(": ")
            place = waiting.pop((session, kept, why), None)
            if place is not None:
                longer = f"{found[place].text}; {stood[:1].lower()}{stood[1:]}"
                found[place] = dataclasses.replace(found[place], text=longer)
                continue
        elif code in _PAUSED_BY:
            waiting[session, kept, _PAUSED_BY[code]] = len(found)
        told_text = in_words(str(code), str(text))
        found.append(Told(str(who), str(session), int(trial_id), bool(kept), str(code), told_text))
    return tuple(found)


def in_words(code: str, text: str) -> str:
    """Write a deviation's kind and its text as one, so that neither is said twice."""
    if code == "paused" or all(word in text.lower() for word in code.split("_")):
        return text[:1].upper() + text[1:]
    kind = code.replace("_", " ").capitalize()
    # "Ended early by the experimenter", not "ended early: ended by".
    if code == "ended_early" and text.startswith("ended "):
        return f"{kind} {text.removeprefix('ended ')}"
    return f"{kind}: {text}" if text else kind
