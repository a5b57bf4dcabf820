"""Reserves a slot as soon as a file appears, prints it, and lives on until its input ends.

Arguments: folder, file that is waited for.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

from study.enrolment.register import Register

ORDERS = [("manual", "assisted"), ("assisted", "manual")]


def main(folder: Path, signal: Path) -> None:
    """Reserve, print slot, pseudonym and order, and wait."""
    sys.stdout.write("ready\n")
    sys.stdout.flush()
    while not signal.exists():
        time.sleep(0.001)
    with Register(folder) as register:
        got = register.reserve("race", ORDERS)
    sys.stdout.write(f"{got.slot} {got.pseudonym} {','.join(got.order)}\n")
    sys.stdout.flush()
    sys.stdin.read()


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
