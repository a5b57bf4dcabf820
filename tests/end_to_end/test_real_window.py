"""`study run` in a real window, driven by real X11 events."""

from __future__ import annotations

from pathlib import Path

import pytest

from driven_session import check, run_session
from patience import PATIENCE_S
from protocols import variant


@pytest.mark.parametrize(
    "mouse",
    [
        pytest.param(False, id="keyboard"),
        pytest.param(True, id="mouse", marks=pytest.mark.acceptance),
    ],
)
def test_smoke_protocol_by_real_events(tmp_path: Path, mouse: bool) -> None:
    """Every stage is passed, each key sent is recorded in order, and a report is built."""
    folder = tmp_path / "recordings"
    path, sent = run_session("protocols/smoke.toml", folder, mouse=mouse, timeout_s=PATIENCE_S)
    check(path, sent, tmp_path / "report")


@pytest.mark.acceptance
def test_pilot_protocol_by_real_events(tmp_path: Path) -> None:
    """The ten-minute pilot is driven from welcome to thanks in real time."""
    folder = tmp_path / "recordings"
    path, sent = run_session("protocols/pilot.toml", folder, mouse=True, timeout_s=1500)
    check(path, sent, tmp_path / "report")
    assert len(sent) > 500


SHORT_CARTS = (
    ("episodes = 4", "episodes = 1"),
    ("timesteps = 200", "timesteps = 20"),
    ("trials = 2", "trials = 1"),
    ("trial_timesteps = 300", "trial_timesteps = 60"),
    ("epochs = 100", "epochs = 2"),
    ("at_least = 4", "at_least = 2"),
)


@pytest.mark.acceptance
def test_gymnasium_by_real_events(tmp_path: Path) -> None:
    """Carts of Gymnasium are driven in a window: every key sent is recorded, and it replays."""
    pytest.importorskip("gymnasium")
    carts = variant(tmp_path, *SHORT_CARTS, base="cart_pole")
    folder = tmp_path / "recordings"
    path, sent = run_session(str(carts), folder, mouse=False, timeout_s=2 * PATIENCE_S)
    check(path, sent, tmp_path / "report")
    assert any(key in ("left", "right") for key, _ in sent)
