"""Sessions that break off, and are resumed, in virtual time and with real recordings."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

from short_study import opened, short_study
from study.commands.composing import start_failover_recorder
from study.commands.resuming import Boundary, find_end
from study.events.inputs import Input
from study.loading import LoadedProtocol
from study.recording.failover import FailoverRecorder
from study.recording.parts import base_name
from study.recording.reader import RawRecord
from study.recording.wire import decode
from study.screens import Screen
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.fitting import InlineFitter
from study.shell.fleet import open_fleet
from study.shell.virtual_loop import VirtualClock, run_virtual
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import draw_parameters

EPOCH_NS = 1_700_000_000_000_000_000

LONGER = (("horizon = 6", "horizon = 30"), ("trial_timesteps = 8", "trial_timesteps = 24"))
"""Long enough for the simulated operator to drive, so that policies are fitted too."""


def study_loaded() -> LoadedProtocol:
    """Load the study that is run here."""
    return short_study(*LONGER)


def drive(
    loaded: LoadedProtocol,
    recorder: FailoverRecorder,
    session: Session,
    first: Input,
    boundary: Boundary | None = None,
    pause_s: float = 0.0,
    prepare: Callable[[Conductor, Callable[[], int]], None] = lambda *_: None,
    seen: Callable[[int, Screen], None] = lambda *_: None,
) -> None:
    """Drive a session to its end by a simulated operator.

    ``prepare`` is called with the conductor and what tells the session's time, before the start;
    ``seen`` with the session's time and each screen when it is shown.
    """
    task = loaded.protocol.task
    fleet, fitter = open_fleet(task.name, task.parameters), InlineFitter(loaded.description)
    for fit in boundary.fits if boundary else ():
        fleet.add_artefact(fit.artefact_id, fit.kind, fit.algorithm, fit.weights)
    clock = VirtualClock()
    clock.now_ns = first.t_ns

    def shown(screen: Screen) -> None:
        time.sleep(pause_s)
        seen(clock.now_ns, screen)

    conductor = Conductor(
        session,
        recorder,
        fleet,
        fitter,
        epoch_ns=EPOCH_NS,
        waits_for_disk=False,
        on_show=shown,
    )
    prepare(conductor, lambda: clock.now_ns)
    try:
        conductor.feed(first)
        run_virtual(conductor, SimulatedOperator(draw_parameters(1, 0), 5), clock)
    finally:
        fleet.close()
        fitter.close()
        recorder.close()


def whole_session(folder: Path, pause_s: float = 0.0) -> Path:
    """Record a session that nothing disturbs."""
    loaded, first = study_loaded(), opened(study_loaded())
    recorder = start_failover_recorder(folder, loaded, first)
    drive(loaded, recorder, Session(), first, pause_s=pause_s)
    return recorder.path


def seen_session(
    folder: Path, loaded: LoadedProtocol | None = None, pause_s: float = 0.0
) -> tuple[Path, list[tuple[int, Screen]]]:
    """Record a session; return the file, and every screen with the session time it was shown.

    With a pause after each screen the file has several chunks, as that of a person's session.
    """
    loaded = loaded or study_loaded()
    first = opened(loaded)
    recorder = start_failover_recorder(folder, loaded, first)
    seen: list[tuple[int, Screen]] = []
    drive(
        loaded,
        recorder,
        Session(),
        first,
        pause_s=pause_s,
        seen=lambda t_ns, screen: seen.append((t_ns, screen)),
    )
    return recorder.path, seen


def write_part(folder: Path, records: list[RawRecord], name: str = "", part: int = 1) -> Path:
    """Record what a part held when its study was killed; return the file."""
    loaded = study_loaded()
    recorder = start_failover_recorder(
        folder,
        loaded,
        opened(loaded),
        name=name,
        part=part,
        first_sequence=records[0].sequence if records else 1,
    )
    for raw in records:
        recorder.write(decode(raw.topic, raw.data), raw.log_time_ns)
    recorder.close()
    return recorder.path


def resume(boundary: Boundary, folder: Path) -> Path:
    """Go on with a session to its end, or to the next break; return the new part."""
    loaded = study_loaded()
    end = find_end(boundary.recording)
    recorder = start_failover_recorder(
        folder,
        loaded,
        boundary.opened,
        name=base_name(boundary.recording.path),
        part=end.part + 1,
        first_sequence=end.sequence + 1,
    )
    first = end.resumed(boundary.after_sequence, end.t_ns + 1, end.log_time_ns + 7_500_000_000)
    drive(loaded, recorder, boundary.session, first, boundary)
    return recorder.path


if __name__ == "__main__":
    whole_session(Path(sys.argv[1]), pause_s=float(sys.argv[2]))
