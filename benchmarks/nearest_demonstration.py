"""The nearest demonstration: our tree against scikit-learn's and against brute force.

python -m benchmarks.nearest_demonstration [--quick]

Twelve robots ask which of m demonstrations is nearest, as once a timestep in a session. All
answer the same queries on the same features in one run, and their answers must agree. Making
states into features is part of each time.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from benchmarks.growth import best_seconds, print_growth, print_row, versions
from benchmarks.made_up_sessions import machine
from study.features import encode
from study.policies import nearest_neighbor
from study.seeding import generator
from study.tasks import navigation

QUERIES = 12
Ask = Callable[[], npt.NDArray[np.intp]]


def askers(demonstrations: int) -> dict[str, Ask]:
    """Return by name what finds the nearest of m demonstrations for the same queries."""
    description = navigation.describe({})
    fields = description.state_fields
    random = generator(1, "benchmark_demonstrations", demonstrations)
    states = navigation.spread_states({}, random, demonstrations)
    queries = navigation.spread_states({}, random, QUERIES)
    features = encode(states, fields)
    actions = np.zeros(demonstrations, np.int32)
    policy = nearest_neighbor.NearestNeighbor(states, actions, description, "sine_cosine")

    def by_brute_force() -> npt.NDArray[np.intp]:
        asked = encode(queries, fields)
        away = [((features - query) ** 2).sum(axis=1) for query in asked]
        return np.array([distances.argmin() for distances in away])

    found: dict[str, Ask] = {
        "ours": lambda: policy.nearest(queries),
        "brute force": by_brute_force,
    }
    try:
        from sklearn.neighbors import NearestNeighbors  # noqa: PLC0415
    except ImportError:
        print("  scikit-learn is not installed: pip install --group benchmarks")
        return found
    for algorithm in ("kd_tree", "brute"):
        tree = NearestNeighbors(n_neighbors=1, algorithm=algorithm).fit(features)

        def ask(tree: object = tree) -> npt.NDArray[np.intp]:
            answer = tree.kneighbors(encode(queries, fields), return_distance=False)  # type: ignore[attr-defined]
            return np.asarray(answer[:, 0], np.intp)

        found[f"scikit-learn {algorithm}"] = ask
    return found


def main() -> None:
    """Measure and print."""
    sizes = [10**power for power in range(2, 5 if "--quick" in sys.argv else 7)]
    print(machine())
    print(versions("scipy", "scikit-learn", "numpy"))
    print(f"{QUERIES} queries among m demonstrations:")
    times: dict[str, list[float]] = {}
    for size in sizes:
        asked = askers(size)
        answers = {name: ask() for name, ask in asked.items()}
        for name, answer in answers.items():
            assert (answer == answers["ours"]).all(), name
        measured = {name: best_seconds(ask) for name, ask in asked.items()}
        for name, taken in measured.items():
            times.setdefault(name, []).append(taken)
        print_row(f"{size:,}", measured.pop("ours"), measured)
    print("Growth with the number of demonstrations:")
    print_growth(sizes, times)


if __name__ == "__main__":
    main()
