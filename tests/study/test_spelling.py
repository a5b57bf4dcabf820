"""A word is taken for a known one where it is close to that, not where it only resembles it."""

from __future__ import annotations

import pytest

from study.errors import UnknownNameError
from study.protocol import Protocol
from study.spelling import closest


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ("timming", "timing"),
        ("task_", "task"),
        ("condition", "conditions"),
        ("phase_thre", "phase_three"),
        ("nonsense", ""),
        ("comment", ""),
        ("x", ""),
    ],
)
def test_only_what_is_close_is_suggested(given: str, meant: str) -> None:
    """Of the tables of a protocol."""
    assert closest(given, list(Protocol.model_fields)) == meant


def test_names_of_members_are_suggested_alike() -> None:
    """A name far from all that there are gets none."""
    assert "Did you mean" not in UnknownNameError("task", "nonsense", ["consent"]).hint
    assert 'Did you mean "luce"?' in UnknownNameError("scorer", "luze", ["luce"]).hint
