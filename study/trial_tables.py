"""The tables of an experiment's results: columns, types and meanings."""

from __future__ import annotations

from collections.abc import Mapping

COLUMNS: Mapping[str, Mapping[str, tuple[str, str]]] = {
    "worlds": {
        "trial": ("whole", "number of the trial, from 0"),
        "seed": ("text", "seed of the trial's world"),
        "demonstrations": ("whole", "demonstrations of phase one"),
        "user_points": ("number", "points of an episode that the user drives, mean"),
        "values_r_squared": ("number", "R^2 of the policy's V against held-out rollouts"),
        "phi_deviation": ("number", "standard deviation of phi over phase two's states, points"),
        "choices": ("whole", "choices of phase two"),
        "choices_best": ("number", "part of them that fell on the robot with the largest phi"),
    },
    "runs": {
        "trial": ("whole", "number of the trial, from 0"),
        "scorer": ("text", 'who chose; "none" for a fleet that nobody helps'),
        "dwell": ("whole", "timesteps between two choices; 0 for none"),
        "team_reward": ("number", "points of all robots in the run"),
        "own_agreement": ("number", "top-1 agreement with phi, states of its own fleet"),
        "reference_agreement": ("number", "top-1 agreement with phi, states of phi's own fleet"),
        "goals": ("whole", "episodes that ended at the goal"),
        "lost": ("whole", "episodes that ended with the robot lost"),
        "demonstrations": ("whole", "demonstrations that the user gave"),
    },
    "policies": {
        "trial": ("whole", "number of the trial, from 0"),
        "scorer": ("text", 'whose demonstrations; "none" for phase one alone'),
        "dwell": ("whole", "dwell of the run that they come from"),
        "training": ("text", "which demonstrations the policy was fitted to"),
        "demonstrations": ("whole", "how many they were"),
        "policy_reward": ("number", "points of an episode of the policy alone, mean"),
        "data_impact": ("number", "the same less that of phase one's policy, same starts"),
    },
    "sensitivity": {
        "trial": ("whole", "number of the trial, from 0"),
        "dial": ("text", "which setting was turned"),
        "setting": ("number", "what it was set to"),
        "scorer": ("text", "which scorer"),
        "own_agreement": ("number", "top-1 agreement with phi, states of its own fleet"),
        "reference_agreement": ("number", "top-1 agreement with phi, states of phi's own fleet"),
    },
    "fleet_sizes": {
        "trial": ("whole", "number of the trial, from 0"),
        "robots": ("whole", "fleet size, n"),
        "scorer": ("text", 'who chose; "none" for a fleet that nobody helps'),
        "team_reward": ("number", "points of all robots in the run"),
        "gain": ("number", "the same less that of the fleet that nobody helps"),
        "reference_agreement": ("number", "top-1 agreement with phi, states of phi's own fleet"),
    },
}
"""Every table's columns in order: (type, meaning). A number can be missing (null)."""
