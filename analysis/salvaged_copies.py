"""Salvaged copies beside their originals: one of the two is analysed."""

from __future__ import annotations

from collections.abc import Sequence

from analysis.left_out import SetAside
from study.recording.parts import part_number
from study.recording.reader import Recording


def without_copies(recordings: Sequence[Recording]) -> tuple[list[Recording], list[SetAside]]:
    """Return recordings with one file for each part of a session, and those left out for it.

    Both hold the same records. The original is taken, unless the copy alone is whole: its index
    was missing, and the session would count as one that is not complete.
    """
    kept: list[Recording] = []
    aside: list[SetAside] = []
    originals = {
        (each.session_id, part_number(each)): each for each in recordings if not each.salvaged_from
    }
    replaced: set[Recording] = set()
    for each in recordings:
        original = originals.get((each.session_id, part_number(each)))
        if not each.salvaged_from or not each.session_id or original is None:
            kept.append(each)
            continue
        better = each.complete and not original.complete and original not in replaced
        taken, other = (each, original) if better else (original, each)
        if better:
            kept.append(each)
            replaced.add(original)
        reason = f"{'the original' if better else 'a salvaged copy'} of {taken.path.name}, which is"
        aside.append(SetAside(other.path.name, "", f"{reason} analysed"))
    return [each for each in kept if each not in replaced], aside
