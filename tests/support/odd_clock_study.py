"""`study` on a computer whose wall clock is set forwards and back, an hour and more, every second.

python odd_clock_study.py COMMAND ...
"""

from __future__ import annotations

import sys
import time

STEPS_S = (0, 3600, -7200, 40)
_real = time.time_ns
_began = time.monotonic()


def _odd() -> int:
    step = STEPS_S[int(time.monotonic() - _began) % len(STEPS_S)]
    return _real() + step * 1_000_000_000


if __name__ == "__main__":
    time.time_ns = _odd
    time.time = lambda: _odd() / 1e9
    from study.commands.main import main

    sys.argv[0] = "study"
    main()
