"""An experiment's results made up for the report's tests: every number is known."""

from __future__ import annotations

import hashlib
import tomllib
from pathlib import Path

import numpy as np

from protocols import ROOT
from study.trial_files import Head, Row, Tables, write_head, write_trial

VERSIONS = {"numpy": "2.0", "trained user": "abc"}


def made_up_results(
    folder: Path,
    *,
    trials: int = 12,
    luce_ahead: float = 0.3,
    seeds: str = "held_out",
    label: str = "Classifier",
) -> Path:
    """Write results in which Luce's scorer leads the classifier by a share and by ten points.

    Args:
        folder: of the results.
        trials: how many.
        luce_ahead: how much more often it agrees; negative turns reward around too.
        seeds: which worlds they say they come from.
        label: what the classifier is called.
    """
    text = (ROOT / "protocols" / "simulation.toml").read_text(encoding="utf-8")
    text = text.replace('label = "Classifier"', f'label = "{label}"')
    protocol = tomllib.loads(text)
    head = Head(text, hashlib.sha256(text.encode()).hexdigest(), seeds, VERSIONS)
    write_head(folder, head)
    scorers = ["ground_truth", *protocol["scorers"], "corrected"]
    random = np.random.default_rng(7)
    for trial in range(trials):
        write_trial(
            folder,
            trial,
            _tables(trial, scorers, luce_ahead, random),
            protocol_sha256=head.sha256,
            seconds=2.0,
            versions=VERSIONS,
        )
    return folder


def _tables(trial: int, scorers: list[str], ahead: float, random: np.random.Generator) -> Tables:
    level = 500 + 100 * float(random.normal())
    share = {
        "ground_truth": 1.0,
        "luce": 0.4 + ahead / 2,
        "classifier": 0.4 - ahead / 2,
        "corrected": 0.45 + ahead / 2,
    }
    runs: list[Row] = []
    policies: list[Row] = []
    for dwell in (1, 15):
        for scorer in scorers:
            agreed = share.get(scorer, 0.1)
            if scorer != "ground_truth":
                agreed += 0.02 * float(random.normal())
            points = level + 200 * share.get(scorer, 0.1) + float(random.normal())
            runs.append(_run(trial, scorer, dwell, points, agreed, 350))
            for training in ("phase_one_and_three", "phase_three_only"):
                reward = 10 + 5 * share.get(scorer, 0.1) + float(random.normal())
                policies.append(_policy(trial, scorer, dwell, training, reward))
    runs.append(_run(trial, "none", 0, level, None, 0))
    policies.append(_policy(trial, "none", 0, "phase_one_only", 9.0))
    dials = [("temperature", 0.25), ("temperature", 1.0), ("choices", 200.0), ("choices", 1600.0)]
    return {
        "worlds": [
            {
                "trial": trial,
                "seed": str(trial),
                "demonstrations": 700,
                "user_points": 22.0,
                "values_r_squared": 0.6,
                "phi_deviation": 3.0,
                "choices": 1600,
                "choices_best": 0.75,
            }
        ],
        "runs": runs,
        "policies": policies,
        "sensitivity": [
            {
                "trial": trial,
                "dial": dial,
                "setting": setting,
                "scorer": scorer,
                "own_agreement": share[scorer],
                "reference_agreement": share[scorer] / 2,
            }
            for dial, setting in dials
            for scorer in ("luce", "classifier")
        ],
        "fleet_sizes": [
            {
                "trial": trial,
                "robots": robots,
                "scorer": scorer,
                "team_reward": level,
                "gain": gain * robots**0.25 + float(random.normal()),
                "reference_agreement": None,
            }
            for robots in (4, 12, 10_000)
            for scorer, gain in (("ground_truth", 20.0), ("luce", 15.0), ("none", 0.0))
        ],
    }


def _run(
    trial: int, scorer: str, dwell: int, points: float, agreed: float | None, given: int
) -> Row:
    return {
        "trial": trial,
        "scorer": scorer,
        "dwell": dwell,
        "team_reward": points,
        "own_agreement": agreed,
        "reference_agreement": agreed,
        "goals": 30,
        "lost": 2,
        "demonstrations": given,
    }


def _policy(trial: int, scorer: str, dwell: int, training: str, reward: float) -> Row:
    return {
        "trial": trial,
        "scorer": scorer,
        "dwell": dwell,
        "training": training,
        "demonstrations": 1000,
        "policy_reward": reward,
        "data_impact": reward - 9.0,
    }
