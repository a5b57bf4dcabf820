"""Phase two: what the user chose, in a small fleet or when asked about a larger one.

Luce's choice model (the paper's): robot i is chosen with probability
exp(phi_i / T) / sum_j exp(phi_j / T). It is drawn by adding Gumbel noise to phi / T and taking
the largest (the two are the same distribution).
"""

from __future__ import annotations

import numpy as np

from study.experiment.fleets import drawn_actions
from study.experiment.world import World
from study.policies.base import Arrays
from study.scorers.base import Scorer


def free_choices(world: World, phi: Scorer, temperature: float, runs: int) -> Arrays:
    """Return the choices of phase two: the user drives whom they choose, at every timestep.

    Each run has streams of its own, so that fewer runs are the first of more.

    Args:
        world: the trial's.
        phi: what the user goes by.
        temperature: T, points.
        runs: how many.

    Returns:
        ``states`` [m, n, d], ``available``, ``chosen`` and ``trials`` (the run), as scorers are
        fitted to.
    """
    part = world.protocol.phase_two
    shape = (runs, part.robots)
    fleets = world.fleets("phase two", fleets=runs, robots=part.robots, paired=False)
    streams = [world.random("phase two", run) for run in range(runs)]
    noise = np.stack([s.gumbel(size=(part.timesteps, part.robots)) for s in streams], axis=1)
    marks = np.stack([s.random(part.timesteps) for s in streams], axis=1)
    idle = np.random.default_rng(0)
    rows = np.arange(runs)
    states = np.zeros((part.timesteps, *fleets.states.shape), np.float32)
    chosen = np.zeros((part.timesteps, runs), np.int32)
    for timestep in range(part.timesteps):
        now = fleets.states
        worth = phi.scores(now.reshape(-1, now.shape[-1])).reshape(shape)
        picked = (worth / temperature + noise[timestep]).argmax(axis=1)
        states[timestep], chosen[timestep] = now, picked
        actions = fleets.policy_actions(world.policy, idle)
        driven = drawn_actions(world.user.probabilities(now[rows, picked]), marks[timestep])
        actions[rows, picked] = driven
        fleets.step(actions)
    # Run after run, as one after the other would have been recorded.
    ordered = states.transpose(1, 0, 2, 3).reshape(-1, part.robots, states.shape[-1])
    return {
        "states": ordered,
        "available": np.ones(ordered.shape[:2], np.bool_),
        "chosen": chosen.T.reshape(-1),
        "trials": np.repeat(rows, part.timesteps).astype(np.int32),
    }


def asked_choices(world: World, first: Scorer, count: int) -> Arrays:
    """Return the choices of a correction round.

    A first scorer drives a larger fleet; at each timestep the user says whom of a few robots,
    drawn at random, they would choose. They go on driving the robot that the scorer chose.

    Args:
        world: the trial's.
        first: the scorer fitted to the first round.
        count: how many are asked, m.
    """
    part = world.protocol.correction
    if part is None:
        raise ValueError("the protocol has no correction round")
    temperature = world.protocol.phase_two.temperature
    fleets = world.fleets("correction", fleets=1, robots=part.robots, paired=True)
    random = world.random("correction")
    noise = random.gumbel(size=(count, part.asked))
    marks = random.random((count, 1))
    asked = random.random((count, part.robots)).argsort(axis=1)[:, : part.asked]
    idle = np.random.default_rng(0)
    if hasattr(first, "begin"):
        first.begin(part.robots, world.stream("correction scorer"))
    shown, chosen = [], []
    for timestep in range(count):
        now = fleets.states[0]
        few = now[asked[timestep]]
        chosen.append(int((world.phi.scores(few) / temperature + noise[timestep]).argmax()))
        shown.append(few)
        picked = int(first.scores(now).argmax())
        actions = fleets.policy_actions(world.policy, idle)
        chances = world.user.probabilities(now[picked : picked + 1])
        actions[0, picked] = drawn_actions(chances, marks[timestep])[0]
        fleets.step(actions)
    return {
        "states": np.stack(shown),
        "available": np.ones((count, part.asked), np.bool_),
        "chosen": np.array(chosen, np.int32),
        "trials": np.zeros(count, np.int32),
    }


def joined(first: Arrays, second: Arrays) -> Arrays:
    """Return two sets of choices as one; robots that a choice did not have are not available."""
    robots = max(first["states"].shape[1], second["states"].shape[1])
    parts = [
        {
            "states": np.pad(part["states"], ((0, 0), (0, missing), (0, 0))),
            "available": np.pad(part["available"], ((0, 0), (0, missing))),
            "chosen": part["chosen"],
            "trials": part["trials"] + shift,
        }
        for part, missing, shift in (
            (first, robots - first["states"].shape[1], 0),
            (second, robots - second["states"].shape[1], 1 + int(first["trials"].max())),
        )
    ]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def first_rows(choices: Arrays, count: int) -> Arrays:
    """Return the first ``count`` choices."""
    return {name: array[:count] for name, array in choices.items()}
