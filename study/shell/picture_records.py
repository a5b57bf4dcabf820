"""Makes records of the pictures that follow a fleet's answers; the session never sees them."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Callable

from study.events.shell import Note, PicturesTaken
from study.screens import CountdownScreen, FleetScreen, Screen
from study.session.effects import StartFleet, StepFleet
from study.shell.fleet import Fleet
from study.shell.fleet_host import FleetAnswer
from study.shell.picture_packing import Packed


@dataclasses.dataclass(frozen=True, slots=True)
class _Answered:
    """When the answer was taken that pictures came with, and what was shown then."""

    request_id: int
    t_ns: int
    trial_id: int
    timestep: int


class PictureRecords:
    """What is known of pictures that are under way to the recording.

    Args:
        has_room: says whether the recording takes more now. While it does not, pictures are left
            out: nothing else may wait for the disk because of them.
    """

    def __init__(self, has_room: Callable[[], bool]) -> None:
        self._has_room = has_room
        self._kept = -1
        self._under_way: deque[_Answered] = deque()
        self._anew = True
        self._failed = False

    @property
    def awaited(self) -> bool:
        """Whether pictures are under way."""
        return bool(self._under_way)

    def asked(self, effect: StartFleet | StepFleet, *, seen: bool) -> bool:
        """Return whether the pictures of an effect's answer are to be kept.

        Args:
            effect: what the session asks for.
            seen: whether somebody will look at the fleet.
        """
        # What one fleet run's records lean on is in its own.
        self._anew |= isinstance(effect, StartFleet)
        wanted = seen and not self._failed and self._has_room()
        self._kept = effect.request_id if wanted else -1
        return wanted

    def answered(
        self, answer: FleetAnswer, t_ns: int, trial_id: int, screen: Screen | None, fleet: Fleet
    ) -> None:
        """Have packed what is shown of an answer that the session has seen."""
        if answer.request_id != self._kept:
            return
        shown = screen.fleet if isinstance(screen, CountdownScreen) else screen
        # Where no robots are shown yet, as in a pause, any may be.
        robots, timestep = tuple(range(len(answer.states))), -1
        if isinstance(shown, FleetScreen) and shown.robots == len(robots):
            robots, timestep = tuple(sorted(tile.robot for tile in shown.tiles)), shown.timestep
        self._under_way.append(_Answered(answer.request_id, t_ns, trial_id, timestep))
        fleet.pack(robots, anew=self._anew)
        self._anew = False

    def packed(self, packed: Packed, now_ns: int) -> PicturesTaken | Note | None:
        """Return what is to be recorded of pictures that have come; None if nothing is."""
        answered = self._under_way.popleft()
        failure = packed.failure
        if not failure and packed.request_id != answered.request_id:
            failure = "they came with another answer"
        if failure:
            told, self._failed = self._failed, True
            return None if told else Note(now_ns, f"no more pictures are recorded: {failure}")
        return PicturesTaken(
            t_ns=answered.t_ns,
            trial_id=answered.trial_id,
            timestep=answered.timestep,
            robots=packed.robots,
            width=packed.size[0],
            height=packed.size[1],
            encoding="jpeg",
            shown=packed.shown,
            changed=packed.changed,
            lengths=packed.lengths,
            data=packed.data,
        )
