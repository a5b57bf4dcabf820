"""Sessions whose choices are made by a scorer that is known: the one that the recording holds."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import numpy.typing as npt

from patience import PATIENCE_S
from study.events import events as ev
from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource, Phase
from study.events.inputs import FitCompleted
from study.features import encode, standardisation
from study.policies import nearest_neighbor
from study.recording.client import Recorder
from study.scorers._network import Network
from study.tasks import navigation
from synthetic_study import SECOND, Plan, Session, study_plans

HIDDEN = 12
SPREAD = 2.0
"""Standard deviation of phi over the states, log-odds: large enough to be told from chance."""


def known_scorer(index: int) -> Network:
    """Return a participant's phi: a random network over the task's states."""
    random = np.random.default_rng([4242, index])
    task = navigation.describe({})
    states = navigation.spread_states({}, np.random.default_rng(5), 600)
    standard = standardisation(states, task.state_fields)
    features = encode(states, task.state_fields, standard=standard)
    first = (random.normal(size=(HIDDEN, features.shape[1])), random.normal(size=HIDDEN))
    last = (random.normal(size=(1, HIDDEN)), np.zeros(1))
    raw = Network((first, last), standard, task.state_fields).scores(states)
    scaled = (last[0] * SPREAD / raw.std(), last[1])
    return Network((first, scaled), standard, task.state_fields)


class ChoosingSession(Session):
    """A session of made-up states in which the participant chooses by their own phi."""

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan)
        self.phi = known_scorer(plan.index)
        self._states = np.random.default_rng([77, plan.index])

    def fit(self, kind: str, artefact: str, rows: int) -> None:
        """Apply a fit whose weights can be used: phi itself, or a nearest-neighbour policy."""
        self.request_id += 1
        weights = self.phi.to_bytes() if kind == "scorer" else self._policy()
        algorithm = "luce" if kind == "scorer" else "nearest_neighbor"
        digest = hashlib.sha256(weights).hexdigest()
        request, none = self.request_id, np.zeros(0)
        self.add(ev.FitRequested(self.now, request, artefact, kind, algorithm, rows, "0" * 64))
        self.add(FitCompleted(self.now, request, artefact, weights, 0.5, (), none, none, b""))
        self.add(ev.FitApplied(self.now, request, artefact, kind, digest, (), none, none))

    def _policy(self) -> bytes:
        random = np.random.default_rng([9, self.plan.index])
        arrays: dict[str, npt.NDArray[np.generic]] = {
            "states": navigation.spread_states({}, random, 40),
            "actions": random.integers(0, 4, 40).astype(np.int32),
        }
        return nearest_neighbor.fit(arrays, self.task, {}, 0).weights

    def trial(self, phase: Phase, block: int, condition: str, number: int, robots: int) -> None:
        """Run one fleet in which a robot is chosen anew at every timestep."""
        trial_id, steps, random = self.trial_id, self.plan.timesteps, self._states
        manual = phase == Phase.TWO or condition.startswith("manual")
        allocation = {1: "correction", 4: "none"}.get(
            int(phase), "manual" if manual else "assisted"
        )
        states = navigation.spread_states({}, random, steps * robots).reshape(steps, robots, 4)
        place = (int(phase), block, condition, number, robots, steps, allocation, "tiles")
        which = ("policy:1", "" if manual else "scorer:luce")
        self.add(ev.TrialStarted(self.now, trial_id, *place, 15, *which, True, states[0]))
        scores = self.phi.scores(states)
        noisy = scores + random.gumbel(size=scores.shape) * manual
        chosen = noisy.argmax(axis=1)
        source = ChoiceSource.OPERATOR if manual else ChoiceSource.SCORER
        if robots == 1 or phase == Phase.FOUR:
            source = ChoiceSource.NONE
        flag = ChoiceFlag.NO_CHOICE if source == ChoiceSource.NONE else ChoiceFlag.USABLE
        rewards = random.normal(0.1, 1.0, (steps, robots)).astype(np.float32)
        running, ones = np.zeros(robots, np.int32), np.ones(robots, np.int32)
        for step in range(steps):
            operated = -1 if phase == Phase.FOUR else int(chosen[step])
            sources = np.full(robots, int(ActionSource.POLICY), np.int32)
            if operated >= 0:
                sources[operated] = int(ActionSource.OPERATOR)
            self.add(
                ev.Timestep(
                    t_ns=self.now,
                    due_ns=self.now,
                    trial_id=trial_id,
                    timestep=step,
                    robots=robots,
                    operated=operated,
                    choice_source=int(source),
                    choice_flag=int(flag),
                    states=states[step],
                    actions=running,
                    action_sources=sources,
                    rewards=rewards[step],
                    outcomes=running,
                    available=ones,
                    scores=np.zeros(0) if manual else scores[step],
                )
            )
        total = float(rewards.astype(np.float64).sum())
        self.add(ev.TrialEnded(self.now, trial_id, steps, total, complete=True))
        self.now += SECOND
        self.trial_id += 1


def write_choosing(folder: Path, plan: Plan) -> Path:
    """Write one session as a recording and return its path."""
    recorder = Recorder.start(
        folder,
        f"choosing_{plan.index:02d}",
        {},
        {"session_id": f"s{plan.index:04d}", "participant": plan.participant},
    )
    for place, record in enumerate(ChoosingSession(plan).run()):
        if place % 400 == 399:
            assert recorder.ensure_durable(PATIENCE_S)
        recorder.write(record, record.t_ns)
    return recorder.close()


def choosing_study(folder: Path, participants: int, **changes: object) -> list[Path]:
    """Write a study of participants with known scorers; return its recordings."""
    folder.mkdir(parents=True, exist_ok=True)
    return [write_choosing(folder, plan) for plan in study_plans(participants, **changes)]
