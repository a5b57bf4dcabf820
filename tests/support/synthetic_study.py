"""Made-up sessions of a whole study, written as real recordings."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from patience import PATIENCE_S
from study.events import events as ev
from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource, Outcome, Phase
from study.events.experimenter_records import ExperimenterNoted
from study.events.fields import Record
from study.events.fit_events import FitGateJudged
from study.events.inputs import FitCompleted, SessionOpened
from study.events.participant_events import InstrumentScored, TextAnswered
from study.events.shell import FrameIntervals
from study.events.task_description import TaskDescription
from study.recording.client import Recorder
from study.tasks import navigation

PROTOCOL = """
format = 1
[study]
name = "synthetic"
title = "{title}"
planned_participants = {planned}
[timing]
timesteps_per_second = 8
[phase_three]
trials = {trials}
{conditions}
[[questionnaires]]
name = "ease_and_success"
when = ["before_reveal", "after_reveal"]
[[exclusions]]
name = "enough_trials"
measure = "complete_trials"
at_least = 2
reason = "A mean of fewer trials says little."
[assumptions]
"timing.timesteps_per_second" = "The source gives no rate; 8 keeps a dwell near two seconds."
"phase_one.refit" = "Refitted after every episode."
"""

QUESTIONNAIRES = {
    "ease_and_success": {
        "low": 1,
        "high": 7,
        "labels": {"1": "Strongly Disagree", "7": "Strongly Agree"},
        "items": [
            {"id": "q1", "text": "It was easy to guide the robots to their goals"},
            {"id": "q2", "text": "I was successful at guiding the robots"},
        ],
    },
    "workload": {
        "version": 2,
        "title": "Workload",
        "low": 1,
        "high": 5,
        "items": [
            {"id": "mental", "text": "It was demanding"},
            {"id": "hurried", "text": "It was hurried"},
            {"id": "relaxed", "text": "It was relaxed"},
        ],
        "scales": [{"name": "load", "method": "percent", "reverse": ["relaxed"]}],
    },
}

CROSSED = ("manual_4", "manual_12", "assisted_4", "assisted_12")
"""Conditions that cross allocation with fleet size."""
CROSSED_THREE = tuple(
    f"{allocation}_{robots}"
    for robots in (4, 12)
    for allocation in ("manual", "suggested", "assisted")
)
"""Conditions that cross three allocations with two fleet sizes."""
CUBED = tuple(f"{cell}_{dwell}" for cell in CROSSED for dwell in (5, 15))
"""Conditions that cross allocation, fleet size and dwell."""
THREE = ("manual", "suggested", "assisted")

HOSTILE = "<script>alert(1)</script>"
"""An id that tries to be markup."""

SECOND = 1_000_000_000


@dataclasses.dataclass(frozen=True)
class Plan:
    """What one synthetic session holds."""

    participant: str
    index: int
    effect: float = 8.0
    trials: int = 8
    timesteps: int = 24
    stop_after: int | None = None
    """End the session, incomplete, after so many fleet runs."""
    operator_kind: str = "simulated"
    title: str = "Assisted choice in a fleet of twelve robots"
    planned: int = 12
    phase_four: bool = True
    conditions: tuple[str, ...] = ("manual", "assisted")
    """Allocation, then fleet size and dwell after underscores; 12 and none without them."""
    scored: bool = True
    """Whether the session records scores, as sessions do since rules 1."""


def declared(condition: str) -> str:
    """Return a condition's table in a protocol."""
    allocation, robots, dwell = (*condition.split("_"), "", "")[:3]
    label = allocation.capitalize() + (f", {robots} robots" if robots else "")
    label += f", dwell {dwell}" if dwell else ""
    lines = ["[[conditions]]", f'name = "{condition}"', f'label = "{label}"']
    lines += [f"dwell = {dwell}"] if dwell else []
    return "\n".join([*lines, f'allocation = "{allocation}"', f"robots = {robots or 12}"])


class Session:
    """Collects the records of one synthetic session."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.generator = np.random.default_rng(1000 + plan.index)
        self.task: TaskDescription = navigation.describe({})
        self.records: list[Record] = []
        self.now = 0
        self.trial_id = 0
        self.request_id = 0
        turn = plan.index // 2 % (len(plan.conditions) // 2 + len(plan.conditions) % 2)
        turned = (*plan.conditions[2 * turn :], *plan.conditions[: 2 * turn])
        self.order = turned if plan.index % 2 == 0 else turned[::-1]
        self.skill = float(self.generator.normal(45.0, 10.0))
        self.benefit = float(self.generator.normal(plan.effect, 5.0))

    def add(self, record: Record) -> None:
        """Append a record and let a little time pass."""
        self.records.append(record)
        self.now += SECOND // 8

    def open(self) -> None:
        """Write the first input and event."""
        plan = self.plan
        conditions = "\n".join(declared(name) for name in plan.conditions)
        protocol = PROTOCOL.format(
            title=plan.title, planned=plan.planned, trials=plan.trials, conditions=conditions
        )
        simulated = plan.operator_kind == "simulated"
        parameters = {"attention_tiles": 3, "lapse_rate": 0.02 + 0.001 * plan.index}
        self.add(
            SessionOpened(
                t_ns=0,
                session_id=f"s{plan.index:04d}",
                participant=plan.participant,
                seed=500 + plan.index,
                order=self.order,
                protocol_toml=protocol,
                protocol_sha256=f"{hash_text(protocol)}",
                task_json=self.task.to_json(),
                operator_kind=plan.operator_kind,
                operator_json=json.dumps(parameters) if simulated else "",
                versions_json='{"numpy": "2.4", "study": "0.1.0"}',
                started_utc=f"2026-11-{3 + plan.index // 2:02d}T09:{plan.index:02d}:00Z",
                planned_index=plan.index,
                questionnaires_json=json.dumps(QUESTIONNAIRES),
                rules=1,
                consent_sha256="",
                consented_utc="",
            )
        )
        self.add(ev.SessionStarted(self.now, plan.participant, self.order, 20))

    def fit(self, kind: str, artefact: str, rows: int) -> None:
        """Request and apply a fit; a scorer gets a score grid with one hill."""
        self.request_id += 1
        algorithm = "luce" if kind == "scorer" else "nearest_neighbor"
        request = self.request_id
        digest = hash_text(f"{artefact}{self.plan.index}")
        names: tuple[str, ...] = ("demonstrations",)
        values = np.array([float(rows)])
        grid = np.zeros(0)
        if kind == "scorer":
            names = ("choices", "held_out_top1", "held_out_log_likelihood_per_choice", "top1")
            top = 0.3 + 0.4 * float(self.generator.random())
            values = np.array([float(rows), top, -1.1, top + 0.05])
            held_out = _held_out(top)
            names += tuple(held_out)
            values = np.append(values, list(held_out.values()))
            grid = self.grid().ravel()
        self.add(ev.FitRequested(self.now, request, artefact, kind, algorithm, rows, digest))
        seconds = 0.5 + float(self.generator.random())
        self.add(
            FitCompleted(self.now, request, artefact, b"weights", seconds, names, values, grid, b"")
        )
        self.add(ev.FitApplied(self.now, request, artefact, kind, digest, names, values, grid))
        if kind == "scorer":
            measured = (0.2, 0.1, 0.05, 0.0, 0.0, 1.0)
            self.add(
                FitGateJudged(self.now, request, artefact, 1, 1, True, "use", "", *measured, "")
            )

    def grid(self) -> np.ndarray:
        """Return scores over the map grid: hills at two places of the map."""
        shape = self.task.map_grid
        assert shape is not None
        x, y = np.meshgrid(shape.xs, shape.ys)
        hills = np.zeros_like(x)
        for _ in range(2):
            cx, cy = self.generator.uniform(1, 19), self.generator.uniform(1, 14)
            width = self.generator.uniform(1.2, 2.5)
            hills += self.generator.uniform(1, 4) * np.exp(
                -((x - cx) ** 2 + (y - cy) ** 2) / (2 * width**2)
            )
        headings = np.linspace(0, 0.6, len(shape.headings))[None, :, None, None]
        healths = np.linspace(0.8, 0, len(shape.healths))[:, None, None, None]
        return 3.0 + hills[None, None] * (1 + headings) + healths * (x / 20)[None, None]

    def trial(self, phase: Phase, block: int, condition: str, number: int, robots: int) -> None:
        """Run one fleet: its start, its timesteps, an episode's end, a switch, its end."""
        plan, generator, d = self.plan, self.generator, len(self.task.state_fields)
        if plan.stop_after is not None and self.trial_id >= plan.stop_after:
            return
        trial_id = self.trial_id
        allocation = {
            Phase.ONE: "correction",
            Phase.TWO: "manual",
            Phase.THREE: condition.partition("_")[0],
            Phase.FOUR: "none",
        }[phase]
        starts = np.random.default_rng([int(phase), number, plan.index]).uniform(
            1, 8, size=(robots, d)
        )
        self.add(
            ev.TrialStarted(
                t_ns=self.now,
                trial_id=trial_id,
                phase=phase,
                block=block,
                condition=condition,
                trial=number,
                robots=robots,
                timesteps=plan.timesteps,
                allocation=allocation,
                view="operated_only" if allocation == "assisted" else "tiles",
                dwell=15 if allocation == "assisted" else 0,
                policy_id=f"policy:{condition}" if phase == Phase.FOUR else "policy:1",
                scorer_id="scorer:luce" if allocation in ("assisted", "suggested") else "",
                scored=True,
                states=starts.astype(np.float32),
            )
        )
        helped = condition.startswith("assisted")
        target = self.skill + (self.benefit if helped else 0.0) + 0.5 * number
        target += 6.0 if "_4" in condition else 0.0
        target += float(generator.normal(0, 8.0)) - (15 if phase == Phase.FOUR else 0)
        rewards = np.full((plan.timesteps, robots), target / (plan.timesteps * robots))
        operates = phase != Phase.FOUR
        total = 0.0
        for step in range(plan.timesteps):
            operated = (step // 8) % robots if operates else -1
            sources = np.full(robots, int(ActionSource.POLICY), dtype=np.int32)
            if operates:
                source = ActionSource.OPERATOR if step % 5 else ActionSource.OPERATOR_IDLE
                sources[operated] = int(source)
            assisted = allocation == "assisted"
            choice = ChoiceSource.SCORER if assisted else ChoiceSource.OPERATOR
            row = rewards[step].astype(np.float32)
            total += float(row.astype(np.float64).sum())
            self.add(
                ev.Timestep(
                    t_ns=self.now + int(generator.integers(0, 2_000_000)),
                    due_ns=self.now,
                    trial_id=trial_id,
                    timestep=step,
                    robots=robots,
                    operated=operated,
                    choice_source=int(choice if operates else ChoiceSource.NONE),
                    choice_flag=int(ChoiceFlag.USABLE if operates else ChoiceFlag.NO_CHOICE),
                    states=generator.uniform(0, 9, size=(robots, d)).astype(np.float32),
                    actions=generator.integers(0, 4, size=robots).astype(np.int32),
                    action_sources=sources,
                    rewards=row,
                    outcomes=np.zeros(robots, dtype=np.int32),
                    available=np.ones(robots, dtype=np.int32),
                    scores=generator.normal(size=robots if assisted else 0),
                )
            )
            if operates and step % 8 == 0:
                chosen_by = int(choice)
                cause = "dwell" if assisted else "number"
                self.add(
                    ev.Switched(self.now, trial_id, step, operated - 1, operated, chosen_by, cause)
                )
        last = plan.timesteps - 1
        self.add(ev.EpisodeEnded(self.now, trial_id, 0, 1, last, last + 1, int(Outcome.GOAL), 9.5))
        if operates:
            intervals = generator.normal(1 / 60, 5e-4, size=40)
            self.add(FrameIntervals(self.now, trial_id, intervals))
        self.add(ev.TrialEnded(self.now, trial_id, plan.timesteps, total, complete=True))
        self.trial_id += 1

    def survey(self, block: int, condition: str, occasion: str) -> None:
        """Answer both items."""
        lift = 1.6 if condition.startswith("assisted") else 0.0
        for item in ("q1", "q2"):
            shift = lift if occasion == "before_reveal" or item == "q1" else 0.3
            value = int(np.clip(round(float(self.generator.normal(2.8 + shift, 1.3))), 1, 7))
            self.add(
                ev.QuestionAnswered(
                    self.now,
                    "ease_and_success",
                    item,
                    value,
                    int(Phase.THREE),
                    block,
                    condition,
                    occasion,
                    3 * SECOND,
                    1,
                )
            )

    def workload(self, block: int, condition: str) -> None:
        """Answer the scored instrument, and record its score as a session does."""
        own = np.random.default_rng([77, self.plan.index, block])
        burden = float(own.normal(3.4 if condition.startswith("manual") else 2.6, 1.0))
        place = (int(Phase.THREE), block, condition, "before_reveal")
        total = 0
        for item in ("mental", "hurried", "relaxed"):
            felt = int(np.clip(round(burden + float(own.normal(0, 0.6))), 1, 5))
            total += felt
            value = 6 - felt if item == "relaxed" else felt
            self.add(ev.QuestionAnswered(self.now, "workload", item, value, *place, 2 * SECOND, 0))
        score = 100 * (total - 3) / 12
        if self.plan.scored:
            self.add(InstrumentScored(self.now, "workload", 2, "load", score, *place))

    def run(self) -> list[Record]:
        """Return every record of the session, in order."""
        plan = self.plan
        self.open()
        for episode in range(1, 4):
            self.trial(Phase.ONE, 1, "", episode, 1)
        self.fit("policy", "policy:1", 60)
        for number in range(1, 4):
            self.trial(Phase.TWO, 1, "", number, 4)
        self.fit("scorer", "scorer:luce", 70 + plan.index)
        for block, condition in enumerate(self.order, start=1):
            for number in range(1, plan.trials + 1):
                robots = int((*condition.split("_"), "12")[1])
                self.trial(Phase.THREE, block, condition, number, robots)
            if plan.stop_after is None:
                self.survey(block, condition, "before_reveal")
                self.workload(block, condition)
                self.add(
                    ev.RewardRevealed(self.now, int(Phase.THREE), block, condition, 8 * self.skill)
                )
                self.survey(block, condition, "after_reveal")
        if plan.phase_four:
            for block, condition in enumerate(sorted(self.order), start=1):
                rows = 90 + int(self.generator.integers(0, 60))
                self.fit("policy", f"policy:{condition}", rows)
                self.trial(Phase.FOUR, block, condition, 1, 12)
        if plan.index % 5 == 3:
            self.add(ev.Resumed(self.now, 12 * SECOND))
            self.add(ev.Deviation(self.now, "practice_repeated", "Practice was repeated", -1))
            self.add(ExperimenterNoted(self.now, "Wore gloves", -1, 9))
        words = "" if plan.index % 2 else "I lost sight of robot 7."
        self.add(TextAnswered(self.now, "remarks", "words", words, 0, 0, "", "once", 4 * SECOND))
        complete = plan.stop_after is None
        reason = "complete" if complete else "window closed"
        self.add(ev.SessionEnded(self.now, complete, reason))
        return self.records


def hash_text(text: str) -> str:
    """Return the SHA-256 of a text, hexadecimal."""
    return hashlib.sha256(text.encode()).hexdigest()


def write_session(folder: Path, plan: Plan) -> Path:
    """Write one session as a recording and return its path."""
    recorder = Recorder.start(
        folder,
        f"session_{plan.index:02d}",
        {},
        {"session_id": f"s{plan.index:04d}", "participant": plan.participant},
    )
    records = Session(plan).run()
    for place, record in enumerate(records):
        if place % 400 == 399:
            # What is on disk by now survives when the end of the file is torn off.
            assert recorder.ensure_durable(PATIENCE_S)
        recorder.write(record, record.t_ns)
    return recorder.close()


def study_plans(participants: int = 12, **changes: object) -> Iterator[Plan]:
    """Plan the sessions of a study, counterbalanced."""
    for index in range(participants):
        plan = Plan(participant=f"P{index + 1:02d}", index=index, planned=participants)
        yield dataclasses.replace(plan, **changes)  # type: ignore[arg-type]


def tear(path: Path, share: float = 0.8) -> None:
    """Cut the end of a recording off, as a crash would."""
    content = path.read_bytes()
    path.write_bytes(content[: int(len(content) * share)])


def _held_out(top: float) -> dict[str, float]:
    """Return measures of two held-out trials and two bins of predicted probability."""
    found: dict[str, float] = {}
    for trial, by in ((12, -0.1), (13, 0.1)):
        found |= {
            f"held_out_trial_{trial}_choices": 20.0,
            f"held_out_trial_{trial}_log_likelihood_per_choice": -1.1 + by,
            f"held_out_trial_{trial}_chance_log_likelihood": -1.4,
            f"held_out_trial_{trial}_top1": top + by,
            f"held_out_trial_{trial}_chance_top1": 0.25,
        }
    for number, chosen in ((2, 0.1), (6, 0.6)):
        found |= {
            f"held_out_calibration_bin_{number}_robots": 40.0,
            f"held_out_calibration_bin_{number}_predicted": number / 10 - 0.05,
            f"held_out_calibration_bin_{number}_chosen": chosen,
        }
    return found
