"""Scoring a fleet and finding its highest score, from 12 robots to 100,000.

python -m benchmarks.scoring [--quick]

Ours is the float64 NumPy pass of a live session. The alternative is the same network in torch,
float32, on one thread and on all, states made into features in the same way. Both must name the
same robot, or one whose score is as high to float32.
"""

from __future__ import annotations

import sys

import numpy as np
import torch

from benchmarks.growth import best_seconds, print_growth, print_row, versions
from benchmarks.luce_fit import drawn_choices
from benchmarks.made_up_sessions import machine
from study.features import encode
from study.scorers import luce
from study.seeding import generator
from study.tasks import navigation


def main() -> None:
    """Measure and print."""
    sizes = [12, 120, 1200] if "--quick" in sys.argv else [12, 100, 1000, 10_000, 100_000]
    print(machine())
    print(versions("numpy", "torch"))
    description = navigation.describe({})
    fields = description.state_fields
    parameters = {"hidden": [32, 32], "epochs": 3, "held_out_fraction": 0.0}
    fitted = luce.fit(drawn_choices(800), description, parameters, 1)
    scorer = luce.load(fitted.weights, description)
    parts: list[torch.nn.Module] = []
    for weight, bias in scorer.layers:
        layer = torch.nn.Linear(weight.shape[1], weight.shape[0])
        with torch.no_grad():
            layer.weight.copy_(torch.from_numpy(weight))
            layer.bias.copy_(torch.from_numpy(bias))
        parts += [layer, torch.nn.ReLU()]
    module = torch.nn.Sequential(*parts[:-1])
    threads = torch.get_num_threads()
    every = f"torch, {threads} thread" + ("s" if threads > 1 else "")
    print(f"A network of 5-32-32-1 scores n robots; the highest is found ({every} at most):")
    times: dict[str, list[float]] = {}
    for size in sizes:
        states = navigation.spread_states({}, generator(1, "benchmark_fleet", size), size)

        def by_torch(states: np.ndarray = states) -> int:  # type: ignore[type-arg]
            features = torch.from_numpy(encode(states, fields, standard=scorer.standard)).float()
            with torch.inference_mode():
                return int(module(features)[:, 0].argmax())

        def by_us(states: np.ndarray = states) -> int:  # type: ignore[type-arg]
            return int(scorer.scores(states).argmax())

        scores = scorer.scores(states)
        assert scores[by_us()] - scores[by_torch()] < 1e-4
        measured = {}
        for count in sorted({1, threads}):
            torch.set_num_threads(count)
            measured[f"torch on {count}"] = best_seconds(by_torch)
        mine = best_seconds(by_us)
        for name, taken in {"ours": mine, **measured}.items():
            times.setdefault(name, []).append(taken)
        print_row(f"{size:,}", mine, measured)
    print("Growth with the number of robots:")
    print_growth(sizes, times)


if __name__ == "__main__":
    main()
