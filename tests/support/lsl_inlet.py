"""Receives a session's markers from Lab Streaming Layer, in a process of its own.

    python lsl_inlet.py FILE [SOURCE_ID]

takes the first stream of markers there is, says "ready" once it is connected, and writes a line
for each marker: its time and its text, as a JSON list. Ends with the session.
"""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import pylsl

from patience import PATIENCE_S
from study.shell.lsl import STREAM_NAME

if __name__ == "__main__":
    deadline = time.monotonic() + PATIENCE_S
    streams = pylsl.resolve_byprop("name", STREAM_NAME, minimum=1, timeout=PATIENCE_S)
    inlet = pylsl.StreamInlet(streams[0])
    inlet.open_stream(timeout=PATIENCE_S)
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    with Path(sys.argv[1]).open("w", encoding="utf-8") as target:
        while time.monotonic() < deadline:
            sample, stamp = inlet.pull_sample(timeout=1.0)
            if sample is not None:
                print(json.dumps([stamp, sample[0]]), file=target, flush=True)
                if json.loads(sample[0])["topic"] == "event/session_ended":
                    break
