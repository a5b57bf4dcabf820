"""Proof that a recording's events follow from its inputs.

Three checks, each stronger in another way: replay (exact, any machine, any task), stepping
the task anew (for tasks that declare it), and nothing else is believed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from study.errors import RecordingError
from study.events.inputs import FitCompleted, FleetObserved, Input, SessionOpened
from study.protocol import parse_protocol
from study.recording.parts import SessionRecording, read_whole_session
from study.recording.reader import Recording
from study.session.effects import Effect, RequestFit, StartFleet, StepFleet
from study.shell.fleet_host import FleetAnswer, FleetHost
from study.shell.replay.follower import Follower


@dataclasses.dataclass(frozen=True, slots=True)
class Verdict:
    """What a check found.

    Attributes:
        inputs: inputs fed.
        events: events compared.
        matches: whether everything agreed.
        difference: the first disagreement, in words; empty if none.
        resimulated: timesteps stepped anew and compared; 0 if not asked for.
        largest_deviation: largest absolute difference of a state stepped anew.
        problems: why the files are not whole, in words; what could be read was compared.
        parts: files that the session was recorded in.
        left_out_trials: fleet runs broken off, which a resume went back behind.
    """

    inputs: int
    events: int
    matches: bool
    difference: str = ""
    resimulated: int = 0
    largest_deviation: float = 0.0
    problems: tuple[str, ...] = ()
    parts: int = 1
    left_out_trials: int = 0


def verify(path: Path, *, resimulate: bool = False) -> Verdict:
    """Replay a session's inputs and compare the encoded events byte for byte.

    Args:
        path: the recording. If it is a part, the others beside it belong to the replay.
        resimulate: also step the task anew and compare what the fleet answered. Exact on
            the same platform and lock; the largest deviation is reported elsewhere.

    Raises:
        RecordingError: the file is no recording of ours, or the first part is not beside it.
    """
    recording = read_whole_session(path)
    try:
        found = verify_recording(recording, resimulate=resimulate)
    except RecordingError as error:
        # What a damaged record said is refused by the session, which knows no file.
        raise RecordingError(f"{path}: {error.message}", error.hint) from error
    verdict = dataclasses.replace(
        found,
        parts=len(recording.parts),
        left_out_trials=recording.left_out_trials,
    )
    if recording.complete:
        return verdict
    problems = recording.problems or ("The recording was not finished.",)
    if recording.losses and recording.losses[0].last is not None:
        text = f"Compared up to record {recording.losses[0].first - 1}, the last before the loss."
        problems = (*problems, text)
    return dataclasses.replace(verdict, problems=problems)


def verify_recording(
    recording: Recording | SessionRecording, *, resimulate: bool = False
) -> Verdict:
    """As `verify`, for a recording already opened."""
    follower = Follower()
    twin = _Twin() if resimulate else None
    # What follows a loss cannot follow from the inputs that are left.
    first_lost = recording.losses[0].first if recording.losses else None
    for raw in recording.raw("input", "event"):
        if first_lost is not None and raw.sequence > first_lost:
            break
        fed = follower.take(raw)
        if follower.difference:
            break
        if twin and fed:
            twin.compare(fed.given)
            twin.expect(fed.step.effects)
    if not follower.difference and not follower.inputs and first_lost is None:
        follower.difference = "the recording holds no inputs to replay"
    follower.end(complete=recording.complete)
    difference = follower.difference
    if twin and not difference:
        difference = twin.difference
    return Verdict(
        inputs=follower.inputs,
        events=follower.compared,
        matches=not difference,
        difference=difference,
        resimulated=twin.compared if twin else 0,
        largest_deviation=twin.largest_deviation if twin else 0.0,
    )


class _Twin:
    """Steps the task again and compares its answers with those recorded."""

    def __init__(self) -> None:
        self._host: FleetHost | None = None
        self._scorers: dict[str, str] = {}
        self._policy = ""
        self._answers: dict[int, FleetAnswer] = {}
        self._background: set[int] = set()
        self.compared = 0
        self.largest_deviation = 0.0
        self.difference = ""

    def expect(self, effects: Sequence[Effect]) -> None:
        for effect in effects:
            if isinstance(effect, RequestFit) and effect.background:
                self._background.add(effect.request_id)
            elif isinstance(effect, StartFleet | StepFleet) and self._host:
                self._answers[effect.request_id] = self._host.answer(effect)

    def compare(self, given: Input) -> None:
        if isinstance(given, SessionOpened):
            protocol = parse_protocol(given.protocol_toml, "the recorded protocol")
            self._host = FleetHost(protocol.task.name, protocol.task.parameters)
            self._policy = protocol.policy.name
            self._scorers = {f"scorer:{key}": part.name for key, part in protocol.scorers.items()}
            if self._host.description.resimulable == "no":
                name = protocol.task.name
                self.difference = f'the task "{name}" gives other states when stepped again'
                self._host = None
        elif isinstance(given, FitCompleted) and self._host:
            if given.request_id in self._background:
                return
            algorithm = self._scorers.get(given.artefact_id)
            kind = "scorer" if algorithm else "policy"
            self._host.add_artefact(
                given.artefact_id, kind, algorithm or self._policy, given.weights
            )
        elif isinstance(given, FleetObserved) and given.request_id in self._answers:
            answer = self._answers.pop(given.request_id)
            self.compared += 1
            deviation = float(np.max(np.abs(answer.states - given.states), initial=0.0))
            self.largest_deviation = max(self.largest_deviation, deviation)
            same = all(
                getattr(answer, name).tobytes() == getattr(given, name).tobytes()
                for name in ("states", "rewards", "outcomes", "policy_actions", "scores")
            )
            if not same and not self.difference:
                self.difference = (
                    f"request {given.request_id}: the task stepped anew answers differently "
                    f"(largest difference of a state {deviation:g})"
                )
