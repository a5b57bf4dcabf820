"""Settings for all tests."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

# Imports only add objects; until all are collected, walking them would be in vain.
gc.disable()

# A property holds or fails however busy the machine is: no example has to be quick.
settings.register_profile(
    "patient", deadline=None, suppress_health_check=[HealthCheck.too_slow], print_blob=True
)
settings.load_profile("patient")


def pytest_collection_finish() -> None:
    """Leave what was imported out of every later garbage collection: it stays to the end."""
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.fixture
def fonts() -> Iterator[None]:
    """Fonts without a window; they are forgotten before the next test."""
    # Most tests draw nothing.
    import pygame

    from study.shell.drawing.lettering import clear_fonts

    pygame.font.init()
    yield
    clear_fonts()
