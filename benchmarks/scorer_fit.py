"""How long a participant waits for a scorer after the last choice: warm start against cold.

    python benchmarks/scorer_fit.py [--participants 4] [--choices 2000]

Simulated participants run phases one and two of the paper's study, with trials enough for that
many choices. Each scorer is fitted to all of them twice: cold, and going on from a cold fit to all
trials but the last, which in a session is made in the background meanwhile. The waits are medians
of several fits in turn, each answered by a fitting process as in a session. Whether a fit is good
is asked of further trials that neither has seen.
"""

from __future__ import annotations

import argparse
import json
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from study.commands.simulating import simulate_session, simulated_assignments
from study.events.codes import Phase
from study.events.events import Timestep, TrialStarted
from study.families import load_member
from study.loading import LoadedProtocol, load_protocol
from study.protocol import Protocol
from study.recording.reader import read_recording
from study.scorers._choices import Choices, fit_metrics, validated_choices
from study.session.effects import RequestFit
from study.shell.fitting import FitAnswer, ProcessFitter
from study.training_sets import choice_sets

ROUNDS = 5
UNSEEN_TRIALS = 3
Arrays = dict[str, npt.NDArray[np.generic]]


def main() -> int:
    """Print waits, their ratio and held-out likelihoods, a line a scorer and participant."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--participants", type=int, default=4)
    parser.add_argument("--choices", type=int, default=2000)
    given = parser.parse_args()
    print(f"{given.choices} choices; wait in ms, median of {ROUNDS}; log-likelihood a choice of ")
    print(f"{UNSEEN_TRIALS} trials that no fit has seen, nats")
    print("scorer      who  cold ms  warm ms  ratio  cold log-lik.  warm log-lik.  chance")
    with tempfile.TemporaryDirectory() as folder:
        loaded = load_protocol(str(_long_phase_two(Path(folder))))
        fitter = ProcessFitter(loaded.description)
        for assignment in simulated_assignments(loaded, given.participants, seed=1):
            path = simulate_session(str(loaded.path), assignment, 1, Path(folder))
            arrays = _recorded_choices(path, loaded)
            for name in loaded.protocol.scorers:
                _compare(fitter, loaded, name, assignment.participant, arrays, given.choices)
        fitter.close()
    return 0


def _compare(
    fitter: ProcessFitter, loaded: LoadedProtocol, name: str, who: str, arrays: Arrays, count: int
) -> None:
    trials = np.unique(arrays["trials"])
    unseen = np.isin(arrays["trials"], trials[-UNSEEN_TRIALS:])
    if int((~unseen).sum()) < count:
        print(f"{name:10} {who:>4}  made only {int((~unseen).sum())} choices")
        return
    seen = _rows(arrays, np.flatnonzero(~unseen)[:count])
    last = seen["trials"] == seen["trials"].max()
    start = _answer(fitter, _request(loaded.protocol, name, _rows(seen, ~last))).preparation
    requests = {
        "cold": _request(loaded.protocol, name, seen),
        "warm": _request(loaded.protocol, name, seen, start),
    }
    waits: dict[str, list[float]] = {"cold": [], "warm": []}
    likelihood: dict[str, float] = {}
    chance = 0.0
    test = validated_choices(_rows(arrays, unseen))
    for _ in range(ROUNDS):
        for kind, request in requests.items():
            began = time.perf_counter()
            answer = _answer(fitter, request)
            waits[kind].append(1000 * (time.perf_counter() - began))
            likelihood[kind], chance = _likelihood(loaded, request.algorithm, answer, test)
    cold, warm = statistics.median(waits["cold"]), statistics.median(waits["warm"])
    print(
        f"{name:10} {who:>4} {cold:8.0f} {warm:8.0f} {cold / warm:6.1f} "
        f"{likelihood['cold']:14.4f} {likelihood['warm']:14.4f} {chance:7.4f}",
        flush=True,
    )


def _request(protocol: Protocol, name: str, arrays: Arrays, start: bytes = b"") -> RequestFit:
    member = protocol.scorers[name]
    return RequestFit(
        request_id=1,
        artefact_id=f"scorer:{name}",
        kind="scorer",
        algorithm=member.name,
        parameters_json=json.dumps(member.parameters),
        arrays=arrays,
        seed=1,
        budget_seconds=60.0,
        start=start,
    )


def _answer(fitter: ProcessFitter, request: RequestFit) -> FitAnswer:
    fitter.request(request)
    while True:
        answer = fitter.poll(1.0)
        if answer is not None:
            assert not answer.reason, answer.reason
            return answer


def _likelihood(
    loaded: LoadedProtocol, algorithm: str, answer: FitAnswer, test: Choices
) -> tuple[float, float]:
    module: Any = load_member("study.scorers", "scorer", algorithm)
    network = module.load(answer.weights, loaded.description)
    found = fit_metrics(network.scores(test.states), test)
    return found["log_likelihood_per_choice"], found["chance_log_likelihood"]


def _rows(arrays: Arrays, which: npt.NDArray[Any]) -> Arrays:
    return {name: array[which] for name, array in arrays.items()}


def _recorded_choices(path: Path, loaded: LoadedProtocol) -> Arrays:
    recording = read_recording(path)
    two = {
        record.trial_id
        for _, record in recording.records(TrialStarted.topic)
        if isinstance(record, TrialStarted) and record.phase == Phase.TWO
    }
    rows = [
        record
        for _, record in recording.records(Timestep.topic)
        if isinstance(record, Timestep) and record.trial_id in two
    ]
    fields = loaded.description.state_fields
    return choice_sets(rows, loaded.protocol.phase_two.robots, len(fields)).arrays()


def _long_phase_two(folder: Path) -> Path:
    """Write the paper's protocol with a longer phase two, and little after it."""
    text = load_protocol("scaled_autonomy").text
    for old, new in (
        ("trials = 6\ntrial_timesteps = 320", "trials = 11\ntrial_timesteps = 320"),
        ("trials = 8\ntrial_timesteps = 240", "trials = 1\ntrial_timesteps = 15"),
        ("trials = 2\ntrial_timesteps = 200", "trials = 1\ntrial_timesteps = 10"),
        ("at_least = 16", "at_least = 2"),
    ):
        assert old in text, old
        text = text.replace(old, new)
    path = folder / "long_phase_two.toml"
    path.write_text(text, encoding="utf-8")
    return path


if __name__ == "__main__":
    sys.exit(main())
