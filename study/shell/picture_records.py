"""Makes records of the pictures that follow a fleet's answers; the session never sees them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

from study.events.shell import Note, PicturesTaken
from study.screens import CountdownScreen, FleetScreen, Screen
from study.session.effects import StartFleet, StepFleet
from study.shell.picture_packing import Keep, Packed


@dataclasses.dataclass(frozen=True, slots=True)
class _Answered:
    """When the answer was taken that pictures belong to, and what was shown then."""

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
        self._awaited = 0
        self._answered: dict[int, _Answered] = {}
        self._whole = True
        self._failed = False

    @property
    def awaited(self) -> bool:
        """Whether pictures are under way."""
        return self._awaited > 0

    def ask(self, effect: StartFleet | StepFleet) -> Keep:
        """Return which pictures of the next answer are to follow it."""
        if self._failed or not self._has_room():
            self._whole = True
            return "none"
        self._awaited += 1
        whole, self._whole = self._whole or isinstance(effect, StartFleet), False
        return "all" if whole else "changed"

    def note(self, request_id: int, t_ns: int, trial_id: int, screen: Screen | None) -> None:
        """Take note of an answer, once the session has seen it."""
        if self._awaited:
            answered = _Answered(t_ns, trial_id, _timestep(screen))
            self._answered[request_id] = answered

    def take(self, packed: Packed, now_ns: int) -> PicturesTaken | Note | None:
        """Return what is to be recorded of pictures that have come; None if they are nobody's."""
        self._awaited -= 1
        answered = self._answered.get(packed.request_id)
        # What is older will not come any more.
        self._answered = {
            number: later for number, later in self._answered.items() if number > packed.request_id
        }
        if packed.failure:
            self._failed = True
            return Note(now_ns, f"pictures are no longer recorded: {packed.failure}")
        if answered is None:
            # Later ones lean on those of a trial broken off, which are in no record.
            self._whole = True
            return None
        return PicturesTaken(
            t_ns=answered.t_ns,
            trial_id=answered.trial_id,
            timestep=answered.timestep,
            robots=packed.robots,
            width=packed.size[0],
            height=packed.size[1],
            encoding="jpeg",
            changed=packed.changed,
            lengths=packed.lengths,
            data=packed.data,
        )


def _timestep(screen: Screen | None) -> int:
    fleet = screen.fleet if isinstance(screen, CountdownScreen) else screen
    return fleet.timestep if isinstance(fleet, FleetScreen) else -1
