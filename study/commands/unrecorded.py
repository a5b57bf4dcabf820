"""A simulated session that is only looked at: nothing of it is recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from study.commands.composing import Assignment, picture_records, session_opened
from study.events.fields import Record
from study.loading import LoadedProtocol
from study.messages import Messages
from study.screens import Screen
from study.seeding import stream_seed
from study.session.consent import Consent
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.fitting import Fitter
from study.shell.fleet import open_fleet
from study.shell.virtual_loop import VirtualClock, run_virtual
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import draw_parameters


class NoRecorder:
    """Takes records and keeps none."""

    def write(self, record: Record, log_time_ns: int) -> int:  # noqa: ARG002
        """Take one record."""
        return 0

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Take records."""
        for record, log_time_ns in records:
            self.write(record, log_time_ns)
        return 0

    def ensure_durable(self, timeout_s: float) -> bool:  # noqa: ARG002
        """Nothing is kept."""
        return True


def run_unrecorded(
    loaded: LoadedProtocol,
    assignment: Assignment,
    messages: Messages,
    clock: VirtualClock,
    *,
    fitter: Fitter,
    on_show: Callable[[Screen], None],
    on_pictures: Callable[[npt.NDArray[np.uint8]], None] | None = None,
    recorder: NoRecorder | None = None,
) -> Session:
    """Run a session with a simulated participant in virtual time.

    Args:
        loaded: the protocol.
        assignment: seed and order.
        messages: the texts of the participant's language.
        clock: goes on with the session.
        fitter: what fits.
        on_show: called with every screen, that of the consent first: simulated participants are
            not asked.
        on_pictures: called with the pictures that the task took of its robots, before the screen
            that they belong to; None if nobody looks.
        recorder: sees the records; None if nobody looks at them.

    Returns:
        The session at its end.

    Raises:
        StudyError: the simulated participant found no way on.
    """
    if loaded.protocol.consent:
        on_show(Consent(loaded.protocol, messages).screen())
    session = Session(messages)
    fleet = open_fleet(loaded.protocol.task.name, loaded.protocol.task.parameters)
    try:
        conductor = Conductor(
            session,
            recorder or NoRecorder(),
            fleet,
            fitter,
            epoch_ns=0,
            waits_for_disk=False,
            on_show=on_show,
            on_pictures=on_pictures,
            picture_records=picture_records(loaded, lambda: recorder is not None),
        )
        operator = SimulatedOperator(
            draw_parameters(1, 0), stream_seed(assignment.seed, "operator")
        )
        conductor.feed(session_opened(loaded, assignment))
        run_virtual(conductor, operator, clock)
    finally:
        fleet.close()
    return session
