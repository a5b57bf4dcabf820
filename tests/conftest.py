"""Settings for all tests."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator

import pytest
from hypothesis import HealthCheck, settings

# Tests that run side by side have a core each; threads of their own would only wait for one.
# It has to be said before numpy is imported, and reaches the programs that tests start.
if "PYTEST_XDIST_WORKER" in os.environ:
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

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
