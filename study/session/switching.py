"""Around an automatic switch: announced before, and what was done just after it is flagged."""

from __future__ import annotations

from study.events.events import GraceDemonstration, SwitchAnnounced
from study.protocol import Protocol
from study.session.allocation import AnyAllocation, AssistedAllocation
from study.session.context import Outbox

SECOND = 1_000_000_000


class SwitchWatch:
    """Says when a switch is near, and which demonstrations came too soon after one.

    Args:
        protocol: its ``[switching]`` settings.
        trial_id: which fleet run.
    """

    def __init__(self, protocol: Protocol, trial_id: int) -> None:
        self._settings = protocol.switching
        self._rate = protocol.timing.timesteps_per_second
        self._trial_id = trial_id
        self._switched_ns = -1
        self._announced = False

    def switched(self, t_ns: int) -> None:
        """An automatic switch happened."""
        self._switched_ns = t_ns

    def seconds_left(self, allocation: AnyAllocation) -> float:
        """Return the time to the next automatic choice, s, if that is announced now; else -1."""
        if not isinstance(allocation, AssistedAllocation) or allocation.operated < 0:
            return -1.0
        if not allocation.scored:
            return -1.0
        seconds = allocation.timesteps_left() / self._rate
        return seconds if seconds <= self._settings.cue_seconds else -1.0

    def announce(self, allocation: AnyAllocation, t_ns: int, timestep: int, out: Outbox) -> None:
        """Record the moment at which the announcement begins."""
        seconds = self.seconds_left(allocation)
        if seconds >= 0 and not self._announced and self._settings.cue_seconds > 0:
            out.events.append(SwitchAnnounced(t_ns, self._trial_id, timestep, seconds))
        self._announced = seconds >= 0

    def demonstrated(self, t_ns: int, due_ns: int, timestep: int, out: Outbox) -> None:
        """Flag a demonstration made within the time of grace after a switch."""
        since_ns = due_ns - self._switched_ns
        if self._switched_ns >= 0 and 0 <= since_ns < self._settings.grace_seconds * SECOND:
            out.events.append(GraceDemonstration(t_ns, self._trial_id, timestep, since_ns))
