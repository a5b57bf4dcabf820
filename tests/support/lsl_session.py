"""Drives a simulated session whose markers go to Lab Streaming Layer, in a process of its own.

    python lsl_session.py FOLDER

records into the folder, once somebody receives.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from cut_sessions import drive, study_loaded
from patience import PATIENCE_S
from short_study import opened
from study.commands.composing import start_failover_recorder
from study.session.session import Session
from study.shell.lsl import LslOutlet
from study.shell.markers import MarkerPublisher

if __name__ == "__main__":
    loaded = study_loaded()
    first = opened(loaded)
    outlet = LslOutlet(first)
    deadline = time.monotonic() + PATIENCE_S
    while not outlet.has_consumers():
        assert time.monotonic() < deadline, "nobody receives"
        time.sleep(0.05)
    recorder = start_failover_recorder(Path(sys.argv[1]), loaded, first)
    drive(
        loaded,
        recorder,
        Session(),
        first,
        prepare=lambda conductor, now: conductor.watch(
            MarkerPublisher(outlet, now, conductor.observe).publish
        ),
    )
    outlet.close()
