"""The tables that `study whatif` hands to the analysis: columns, types, units and meanings."""

from __future__ import annotations

from collections.abc import Mapping

Declared = Mapping[str, tuple[str, str, str]]

_WHO: Declared = {
    "participant": ("text", "", "whose choices"),
    "session": ("text", "", "identifier of the session"),
}
_RUN: Declared = {
    **_WHO,
    "trial_id": ("whole", "", "number of the fleet run in the session, from 0"),
    "phase": ("whole", "", "phase, 1 to 4"),
    "condition": ("text", "", "name of the condition; empty outside phases three and four"),
    "trial": ("whole", "", "number within the block, from 1"),
}
_SEEN: Declared = {
    "fitted": ("boolean", "", "whether this participant's own scorer was fitted to the choices"),
    "seen": ("boolean", "", "whether this scorer was fitted to them"),
}
_MEASURES: Declared = {
    "choices": ("whole", "", "choices among two or more available robots"),
    "agreement": ("number", "", "part of them that fell on the scorer's first robot"),
    "chance_agreement": ("number", "", "the same for choosing with equal chances"),
    "log_likelihood": (
        "number", "nats", "mean log-likelihood of a choice; missing if scores are no log-odds"
    ),
    "chance_log_likelihood": ("number", "nats", "the same for choosing with equal chances"),
}  # fmt: skip

COLUMNS: Mapping[str, Declared] = {
    "recordings": {
        **_WHO,
        "file": ("text", "", "name of the file"),
        "sha256": ("text", "", "SHA-256 of the file, hexadecimal"),
        "protocol_sha256": ("text", "", "SHA-256 of the protocol, hexadecimal"),
        "choices": ("whole", "", "choices of the operator's own that were looked at"),
    },
    "scorers": {
        "scorer": ("text", "", "what it is called here"),
        "participant": ("text", "", "whose choices it was asked about; empty for everyone's"),
        "fitted_to": ("text", "", "whose choices it was fitted to; empty if to nobody's"),
        "origin": ("text", "", "recorded, fitted, cross_validated, control or file"),
        "algorithm": ("text", "", "name of the member of study/scorers"),
        "weights_sha256": ("text", "", "SHA-256 of its weights, hexadecimal"),
        "source": ("text", "", "file that the weights come from; empty if fitted here"),
        "source_sha256": ("text", "", "SHA-256 of that file, hexadecimal"),
    },
    "choices": {
        **_RUN,
        "timestep": ("whole", "timesteps", "number within the fleet run, from 0"),
        "seconds": ("number", "s", "time since the fleet run's first timestep"),
        "robots": ("whole", "", "fleet size, n"),
        "available": ("whole", "", "robots that could be chosen"),
        "scorer": ("text", "", "which scorer was asked"),
        **_SEEN,
        "chosen": ("whole", "", "number of the robot that the operator chose, from 1"),
        "first": ("whole", "", "number of the robot that the scorer puts first, from 1"),
        "rank": ("whole", "", "1 if no available robot scored higher than the one chosen"),
        "log_likelihood": (
            "number", "nats", "of the choice by Luce's model; missing if scores are no log-odds"
        ),
        "chance_log_likelihood": ("number", "nats", "the same for equal chances"),
    },
    "trials": {
        **_RUN,
        "robots": ("whole", "", "fleet size, n"),
        "scorer": ("text", "", "which scorer was asked"),
        **_SEEN,
        **_MEASURES,
        "rank": ("number", "", "mean rank of the robot chosen, from 1"),
        "chance_rank": ("number", "", "the same for choosing with equal chances"),
    },
    "matrix": {
        "scorer_of": ("text", "", "whose own scorer"),
        **_WHO,
        **_SEEN,
        **_MEASURES,
    },
    "states": {
        "scorer": ("text", "", "which scorer was asked"),
        **_WHO,
        "field": ("text", "", "number of the chosen robot's state"),
        "unit": ("text", "", "its unit"),
        "bin": ("whole", "", "bin of its range, from 1"),
        "low": ("number", "", "lower end of the bin, in that unit"),
        "high": ("number", "", "upper end of the bin, in that unit"),
        **_MEASURES,
    },
    "times": {
        "scorer": ("text", "", "which scorer was asked"),
        **_WHO,
        "bin": ("whole", "", "tenth of the planned length of the fleet run, from 1"),
        **_MEASURES,
    },
    "regret": {
        **_RUN,
        "timestep": ("whole", "timesteps", "number within the fleet run, from 0"),
        "available": ("whole", "", "robots that could be chosen"),
        "fitted": _SEEN["fitted"],
        "who": ("text", "", 'who chose: "operator", "chance", or a scorer'),
        "seen": ("boolean", "", "whether who chose is a scorer fitted to this choice"),
        "robot": ("whole", "", "number of the robot chosen, from 1; 0 for chance"),
        "best": ("whole", "", "number of the best robot to take over, from 1"),
        "gain": ("number", "points", "what taking it over adds within the horizon"),
        "best_gain": ("number", "points", "the same of the best robot"),
        "regret": ("number", "points", "the difference: 0 for the best robot"),
    },
}  # fmt: skip
"""Every table's columns in order: (type, unit, meaning). A number can be missing (empty)."""
