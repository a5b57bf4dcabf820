"""Which core each worker keeps to.

A worker and the engine that it waits for take turns many times a millisecond. Left alone, the
kernel puts the one that is woken on an idle core, which has to wake up first: that takes longer
than the engine's work. On one core they hand over at once.
"""

from __future__ import annotations

import os
from pathlib import Path

_TOPOLOGY = Path("/sys/devices/system/cpu")


def cores_of(workers: int, number: int) -> list[int | None]:
    """Return a core for each worker of a fleet; None where it may run anywhere.

    Cores that share their units (hyper-threads) are taken last. Fleets of processes that were
    started one after the other begin at different cores.

    Args:
        workers: how many there are.
        number: of the fleet's process.
    """
    if not hasattr(os, "sched_getaffinity"):
        return [None] * workers
    allowed = sorted(os.sched_getaffinity(0), key=lambda core: (_place_among_siblings(core), core))
    if len(allowed) < workers:
        # Not even one each: the kernel knows better who is to wait.
        return [None] * workers
    return [allowed[(number * workers + each) % len(allowed)] for each in range(workers)]


def keep_to(core: int | None) -> None:
    """Keep this process, and those that it will start, to a core; None changes nothing."""
    if core is not None:
        os.sched_setaffinity(0, {core})


def _place_among_siblings(core: int) -> int:
    """Return how many of the cores that share their units with this one come before it."""
    try:
        listed = (_TOPOLOGY / f"cpu{core}" / "topology" / "thread_siblings_list").read_text()
    except OSError:
        return 0
    siblings: list[int] = []
    for part in listed.strip().split(","):
        first, _, last = part.partition("-")
        siblings += range(int(first), int(last or first) + 1)
    return sum(other < core for other in siblings)
