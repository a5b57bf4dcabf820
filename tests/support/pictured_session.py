"""A simulated session on slippery ice whose recording holds its pictures.

python pictured_session.py FOLDER simulates one whose trials are long, to be killed.
"""

from __future__ import annotations

import sys
from pathlib import Path

from protocols import SHORT_ICE, variant
from study.commands.simulating import simulate_session, simulated_assignments
from study.loading import load_protocol

SEED = 3
RECORDED = '\n[recording]\npictures = "jpeg"\n'


def pictured_session(
    folder: Path, setting: str = RECORDED, changes: tuple[tuple[str, str], ...] = SHORT_ICE
) -> Path:
    """Simulate it; return the recording.

    Args:
        folder: for protocol and recording.
        setting: what the protocol says of recording, at its end.
        changes: of the shipped protocol.
    """
    protocol = variant(folder, *changes, base="frozen_lake")
    protocol.write_text(protocol.read_text() + setting)
    (assignment,) = simulated_assignments(load_protocol(str(protocol)), 1, SEED)
    return simulate_session(str(protocol), assignment, SEED, folder)


if __name__ == "__main__":
    longer = ("trial_timesteps = 120", "trial_timesteps = 1500")
    pictured_session(Path(sys.argv[1]), changes=(*SHORT_ICE[:3], longer, *SHORT_ICE[4:]))
