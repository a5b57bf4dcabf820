"""The loop of simulated participants: virtual time, every answer waited for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from short_study import opened, short_study
from study.errors import StudyError
from study.events.events import SessionEnded, TimestepSkipped
from study.events.fields import Record
from study.events.inputs import TimestepDue
from study.screens import Screen
from study.session.session import Session
from study.shell import virtual_loop
from study.shell.conductor import Conductor
from study.shell.fitting import InlineFitter
from study.shell.fleet import open_fleet
from study.shell.virtual_loop import VirtualClock, run_virtual
from study.simulated.keys import KeyStroke
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import draw_parameters


class Memory:
    """A recorder that keeps records in memory."""

    def __init__(self) -> None:
        self.records: list[Record] = []

    def write(self, record: Record, log_time_ns: int) -> int:
        """Keep a record; its log time is the session's time after the epoch."""
        assert log_time_ns == 1000 + record.t_ns
        self.records.append(record)
        return len(self.records)

    def write_together(self, records: Sequence[tuple[Record, int]]) -> int:
        """Keep records in order."""
        for record, log_time_ns in records:
            self.write(record, log_time_ns)
        return len(self.records)

    def ensure_durable(self, timeout_s: float) -> bool:
        """Nothing is ever lost."""
        return True


class Idler:
    """An operator who never presses a key."""

    def act(self, screen: Screen, now_ns: int) -> tuple[KeyStroke, ...]:
        """Look on."""
        return ()


def run(operator: Any) -> list[Record]:
    """Run a session to its end; return its records."""
    loaded = short_study()
    recorder = Memory()
    fleet = open_fleet("navigation", loaded.protocol.task.parameters)
    fitter = InlineFitter(loaded.description)
    conductor = Conductor(Session(), recorder, fleet, fitter, epoch_ns=1000, waits_for_disk=False)
    conductor.feed(opened(loaded))
    run_virtual(conductor, operator, VirtualClock())
    fleet.close()
    fitter.close()
    assert conductor.finished
    assert not conductor.fleet_pending
    return recorder.records


def test_simulated_participant_passes_every_stage_in_even_steps() -> None:
    """The session is complete, time never goes back, and no timestep is skipped."""
    records = run(SimulatedOperator(draw_parameters(1, 0), 5))
    last = records[-1]
    assert isinstance(last, SessionEnded)
    assert last.complete
    times = [record.t_ns for record in records]
    assert times == sorted(times)
    assert not [record for record in records if isinstance(record, TimestepSkipped)]
    assert all(record.late_ns == 0 for record in records if isinstance(record, TimestepDue))


def test_operator_at_a_loss_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    """A screen that nobody answers ends the run instead of waiting for ever."""
    monkeypatch.setattr(virtual_loop, "STALLED_TICKS", 50)
    with pytest.raises(StudyError, match="no way on from PageScreen"):
        run(Idler())
