"""What `study whatif` refuses before it reads anything."""

from __future__ import annotations

from pathlib import Path

from command_line import study


def test_a_single_part_is_refused(tmp_path: Path) -> None:
    """With all trials held out nothing is left to fit to; nothing is written."""
    done = study("whatif", tmp_path, "--cross-validate", "1", "-o", tmp_path / "out")
    assert done.returncode == 2
    assert done.stderr.startswith("Error: --cross-validate: 1 given")
    assert not (tmp_path / "out").exists()
