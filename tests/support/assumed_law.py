"""Assumptions for tests of plans, as far from each other as studies are."""

from __future__ import annotations

import dataclasses

from analysis.planning.assumptions import Assumptions
from analysis.planning.stated import PlannedStudy

AB_BA = ((0, 1), (1, 0))
LATIN = ((0, 1, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0), (0, 2, 1), (1, 0, 2))
PLAIN = Assumptions((0.0, 6.0), 5.0, 10.5, AB_BA, level_sd=11.0)


def law(**changes: object) -> Assumptions:
    """Return assumptions of two conditions with some changed."""
    return dataclasses.replace(PLAIN, **changes)  # type: ignore[arg-type]


def three(**changes: object) -> Assumptions:
    """Return assumptions of three conditions with some changed."""
    return law(**{"effects": (0.0, 3.0, 6.0), "orders": LATIN, **changes})


def planned(**changes: object) -> PlannedStudy:
    """Return a study of two conditions of eight trials."""
    settings: dict[str, object] = {
        "title": "A study",
        "sha256": "ab" * 32,
        "levels": ("manual", "assisted"),
        "labels": ("Manual", "Assisted"),
        "orders": AB_BA,
        "participants": 12,
        "trials": 8,
        "trial_seconds": 30.0,
        "needed": 0.0,
        "bound": None,
    }
    return PlannedStudy(**{**settings, **changes})  # type: ignore[arg-type]
