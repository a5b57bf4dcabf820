"""What the benchmarks of this folder share: times, ratios, and how times grow."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version

import numpy as np


def best_seconds(work: Callable[[], object], least: float = 0.3, most: int = 200) -> float:
    """Return the least time of a call, s, over calls that take some time together."""
    work()
    taken: list[float] = []
    while len(taken) < 3 or (sum(taken) < least and len(taken) < most):
        begun = time.perf_counter()
        work()
        taken.append(time.perf_counter() - begun)
    return min(taken)


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """Return b of seconds ~ size ** b, by least squares on the logarithms."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def print_row(label: str, ours: float, others: Mapping[str, float]) -> None:
    """Print the time of ours and of each alternative, with how many times ours it takes."""
    parts = [f"{name} {taken * 1e3:.3f} ms ({taken / ours:.2f}x)" for name, taken in others.items()]
    print(f"  {label:>12s}   ours {ours * 1e3:.3f} ms   " + "   ".join(parts), flush=True)


def print_growth(sizes: Sequence[int], columns: Mapping[str, Sequence[float]]) -> None:
    """Print each column's growth exponent over all sizes, and over the larger half of them."""
    half = len(sizes) // 2
    for name, seconds in columns.items():
        known = [
            (size, taken) for size, taken in zip(sizes, seconds, strict=True) if np.isfinite(taken)
        ]
        listed, times = [size for size, _ in known], [taken for _, taken in known]
        text = f"  {name}: time ~ size^{exponent(listed, times):.2f}"
        upper = [place for place, size in enumerate(listed) if size >= sizes[half]]
        if len(upper) > 1:
            at = upper[0]
            text += f", from {listed[at]:,} on size^{exponent(listed[at:], times[at:]):.2f}"
        print(text)


def versions(*names: str) -> str:
    """Return the versions of packages, to print; "not installed" for those missing."""
    found = []
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            found.append(f"{name} not installed")
    return ", ".join(found)
