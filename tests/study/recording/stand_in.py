"""Stands in for a study in the kill tests: streams records and logs which it handed over.

python stand_in.py FOLDER LOG SEED
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import numpy as np

from study.events.inputs import FleetObserved
from study.recording.client import Recorder


def main(folder: Path, log: Path, seed: int) -> None:
    recorder = Recorder.start(folder, "killed", {"protocol.toml": b"name = 'x'\n"}, {})
    generator = np.random.default_rng(seed)
    descriptor = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)
    for number in range(1_000_000):
        robots = int(generator.integers(1, 13))
        record = FleetObserved(
            t_ns=number,
            request_id=number,
            robots=robots,
            states=generator.random((robots, 4)).astype(np.float32),
            rewards=np.zeros(robots, np.float32),
            outcomes=np.zeros(robots, np.int32),
            policy_actions=np.zeros(robots, np.int32),
            scores=np.zeros(0),
        )
        os.write(descriptor, b"%d\n" % recorder.write(record, time.time_ns()))
        time.sleep(0.0005)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]))
