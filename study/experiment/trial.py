"""One trial: a whole world, and everything that is measured in it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from study.events.codes import Outcome
from study.experiment.choices import asked_choices, first_rows, free_choices, joined
from study.experiment.driving import FleetRun, drive
from study.experiment.protocol import (
    CORRECTED,
    GROUND_TRUTH,
    ExperimentProtocol,
    ScorerPart,
    SeedSet,
    parse_experiment,
)
from study.experiment.world import Demonstrations, World
from study.families import load_member
from study.policies.base import Arrays, Policy
from study.scorers.base import Scorer
from study.seeding import stream_seed
from study.simulated.value_gain import ValueGain

Row = dict[str, Any]
Tables = dict[str, list[Row]]


def run_trial(protocol: ExperimentProtocol, seeds: SeedSet, trial: int) -> Tables:
    """Run one trial; what it returns depends on protocol, seed set and number alone.

    Args:
        protocol: the experiment.
        seeds: which set of worlds.
        trial: its number, from 0.

    Returns:
        Rows by table; see `study.trial_tables` for the tables' columns.
    """
    world = World(protocol, stream_seed(protocol.world_seed_of(seeds), "world", trial))
    part = protocol.phase_two
    choices = free_choices(world, world.phi, part.temperature, part.runs)
    scorers = fitted_scorers(world, choices)
    three = protocol.phase_three
    runs = drive(
        world,
        world.phi,
        scorers,
        dwells=three.dwells,
        robots=three.robots,
        timesteps=three.timesteps,
        name="phase three",
        unassisted=True,
    )
    tables = {
        "worlds": [_world_row(world, choices)],
        "runs": [_run_row(run) for run in runs],
        "policies": _phase_four(world, runs),
        "sensitivity": [],
        "fleet_sizes": [],
    }
    if protocol.sensitivity and trial < protocol.sensitivity.trials:
        tables["sensitivity"] = _sensitivity(world)
    if protocol.fleet_sizes and trial < protocol.fleet_sizes.trials:
        tables["fleet_sizes"] = _fleet_sizes(world, scorers)
    for rows in tables.values():
        for row in rows:
            row["trial"] = trial
    return tables


def run_trial_from_text(text: str, seeds: SeedSet, trial: int) -> Tables:
    """Run one trial in a worker process: on one thread, whatever the machine has.

    Args:
        text: the experiment's file.
        seeds: which set of worlds.
        trial: its number.
    """
    import torch  # noqa: PLC0415 - a worker loads it; reading results does not
    from threadpoolctl import threadpool_limits  # noqa: PLC0415

    # With more threads a matrix product may round otherwise: results would differ by machine.
    torch.set_num_threads(1)
    threadpool_limits(limits=1)
    return run_trial(parse_experiment(text, "the experiment"), seeds, trial)


def fitted_scorers(world: World, choices: Arrays) -> dict[str, Scorer]:
    """Return the protocol's scorers, ground truth first; the learned ones fitted to choices."""
    scorers: dict[str, Scorer] = {GROUND_TRUTH: world.phi}
    for name, part in world.protocol.scorers.items():
        scorers[name] = fitted_scorer(world, part, choices)
    if correction := world.protocol.correction:
        part = world.protocol.scorers[correction.scorer]
        kept = round(len(choices["chosen"]) * (1 - correction.fraction))
        before = first_rows(choices, kept)
        first = fitted_scorer(world, part, before)
        asked = asked_choices(world, first, len(choices["chosen"]) - kept)
        scorers[CORRECTED] = fitted_scorer(world, part, joined(before, asked))
    return scorers


def fitted_scorer(world: World, part: ScorerPart, choices: Arrays) -> Scorer:
    """Return one scorer; novelty is measured from where the user demonstrated in phase one."""
    module = load_member("study.scorers", "scorer", part.name)
    arrays = choices
    if part.name == "novelty":
        states = world.demonstrations.states[:, None, :]
        arrays = {"states": states, "chosen": np.zeros(len(states), np.int32)}
    seed = world.stream(f"fit {part.name}")
    fitted = module.fit(arrays, world.description, part.parameters, seed)
    scorer: Scorer = module.load(fitted.weights, world.description)
    return scorer


def _world_row(world: World, choices: Arrays) -> Row:
    part = world.protocol.phase_two
    worth = world.phi.scores(choices["states"].reshape(-1, choices["states"].shape[-1]))
    best = worth.reshape(-1, part.robots).argmax(axis=1)
    return {
        "seed": str(world.seed),
        "demonstrations": len(world.demonstrations.actions),
        "user_points": float(world.user_points.mean()),
        "values_r_squared": float(world.values_r_squared),
        "phi_deviation": float(worth.std()),
        "choices": len(best),
        "choices_best": float((choices["chosen"] == best).mean()),
    }


def _run_row(run: FleetRun) -> Row:
    row = {
        field.name: getattr(run, field.name)
        for field in dataclasses.fields(run)
        if field.name != "demonstrations"
    }
    row["demonstrations"] = len(run.demonstrations.actions)
    return {name: _null_if_nan(value) for name, value in row.items()}


def _null_if_nan(value: Any) -> Any:  # noqa: ANN401 - a cell of any type
    return None if isinstance(value, float) and math.isnan(value) else value


def _phase_four(world: World, runs: list[FleetRun]) -> list[Row]:
    """Return the reward of each policy alone, and of phase one's on the same starts."""
    labels: list[tuple[str, int, str, int]] = [
        ("none", 0, "phase_one_only", len(world.demonstrations.actions))
    ]
    policies: list[Policy] = [world.policy]
    for run in runs:
        if run.scorer == "none":
            continue
        for training in world.protocol.phase_four.training:
            given = _training_set(world, run, training)
            labels.append((run.scorer, run.dwell, training, len(given.actions)))
            policies.append(world.fit_policy(given) if len(given.actions) else world.policy)
    points = policies_alone(world, policies, world.protocol.phase_four.episodes)
    return [
        {
            "scorer": scorer,
            "dwell": dwell,
            "training": training,
            "demonstrations": demonstrations,
            "policy_reward": reward,
            "data_impact": reward - float(points[0]),
        }
        for (scorer, dwell, training, demonstrations), reward in zip(
            labels, points.tolist(), strict=True
        )
    ]


def _training_set(world: World, run: FleetRun, training: str) -> Demonstrations:
    if training == "phase_three_only":
        return run.demonstrations
    return world.demonstrations.followed_by(run.demonstrations)


def policies_alone(
    world: World, policies: list[Policy], episodes: int
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Return the mean points of an episode of each policy, on the same starts and noise."""
    task = world.task.create(len(policies) * episodes, world.parameters)
    random = world.random("phase four episodes")
    seeds = np.tile(random.integers(2**63, size=episodes, dtype=np.uint64), len(policies))
    running = np.ones(task.robots, np.bool_)
    states = task.reset(running, seeds)
    points = np.zeros(task.robots)
    actions = np.full(task.robots, world.description.idle_action, np.int32)
    idle = np.random.default_rng(0)
    while running.any():
        for place, policy in enumerate(policies):
            rows = place * episodes + np.flatnonzero(
                running[place * episodes : (place + 1) * episodes]
            )
            if len(rows):
                actions[rows] = policy.actions(states[rows], idle)
        step = task.step(actions, running)
        states, running = step.states, step.outcomes == Outcome.RUNNING
        points += step.rewards
    means: np.ndarray[tuple[int], np.dtype[np.float64]] = points.reshape(-1, episodes).mean(axis=1)
    return means


def _sensitivity(world: World) -> list[Row]:
    """Return the agreement of scorers as each dial is turned, the others as in the file."""
    protocol, dials = world.protocol, world.protocol.sensitivity
    if dials is None:
        return []
    two = protocol.phase_two
    rows: list[Row] = []

    def measure(dial: str, setting: float, phi: Scorer, temperature: float, runs: int) -> None:
        choices = free_choices(world, phi, temperature, runs)
        rows.extend(_agreements(world, phi, choices, dial, setting))

    for temperature in dials.temperatures:
        measure("temperature", temperature, world.phi, temperature, two.runs)
    for runs in dials.runs:
        measure("choices", runs * two.timesteps, world.phi, two.temperature, runs)
    for units in dials.hidden:
        layers = len(protocol.values.hidden)
        values = protocol.values.model_copy(update={"hidden": (units,) * layers})
        phi = ValueGain(world.user, world.fit_robot_values(values))
        measure("hidden", units, phi, two.temperature, two.runs)
    return rows


def _agreements(world: World, phi: Scorer, choices: Arrays, dial: str, setting: float) -> list[Row]:
    dials, three = world.protocol.sensitivity, world.protocol.phase_three
    names = dials.scorers if dials else ()
    scorers: Mapping[str, Scorer] = {
        name: fitted_scorer(world, world.protocol.scorers[name], choices) for name in names
    }
    runs = drive(
        world,
        phi,
        scorers,
        dwells=three.dwells[:1],
        robots=three.robots,
        timesteps=three.timesteps,
        name="phase three",
    )
    return [
        {
            "dial": dial,
            "setting": float(setting),
            "scorer": run.scorer,
            "own_agreement": run.own_agreement,
            "reference_agreement": run.reference_agreement,
        }
        for run in runs
    ]


def _fleet_sizes(world: World, scorers: Mapping[str, Scorer]) -> list[Row]:
    """Return what each scorer's help is worth in fleets of each size."""
    part = world.protocol.fleet_sizes
    if part is None:
        return []
    rows: list[Row] = []
    for robots in part.sizes:
        runs = drive(
            world,
            world.phi,
            {name: scorers[name] for name in part.scorers},
            dwells=(1,),
            robots=robots,
            timesteps=part.timesteps,
            name=f"fleet of {robots}",
            unassisted=True,
        )
        alone = next(run.team_reward for run in runs if run.scorer == "none")
        rows += [
            {
                "robots": robots,
                "scorer": run.scorer,
                "team_reward": run.team_reward,
                "gain": run.team_reward - alone,
                "reference_agreement": _null_if_nan(run.reference_agreement),
            }
            for run in runs
        ]
    return rows
