"""A session on the real clock, in a window at which a simulated participant sits."""

from __future__ import annotations

import time
from contextlib import closing
from typing import Any

from study.commands.recorded_scorers import recorded_weights
from study.events.inputs import SessionOpened
from study.loading import LoadedProtocol
from study.session.session import Session
from study.shell.conductor import Conductor
from study.shell.fitting import InlineFitter
from study.shell.fleet import open_fleet
from study.shell.live_loop import LiveClock, LiveLoop
from study.shell.picture_records import PictureRecords
from study.shell.raw_inputs import RawInput, RawKey
from study.shell.window import Window
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import draw_parameters


class OperatedWindow(Window):
    """A window whose keys a simulated participant presses.

    Args:
        size: width and height, pixels.
        seed: of the participant.
        page_minimum_s: for so long each page is read.
    """

    def __init__(self, size: tuple[int, int], seed: int, page_minimum_s: float = 0.05) -> None:
        super().__init__(size)
        quick = {
            "words_per_second": 1000.0, "page_minimum_s": page_minimum_s, "answer_delay_s": 0.05,
        }  # fmt: skip
        parameters = draw_parameters(seed, 0).model_copy(update=quick)
        self._operator = SimulatedOperator(parameters, seed)
        self.clock = LiveClock()

    def poll(self) -> list[RawInput]:
        """Return what the participant presses at what is shown."""
        super().poll()
        screen = self.screen
        if screen is None:
            return []
        now = time.perf_counter_ns()
        strokes = self._operator.act(screen, self.clock.now())
        return [RawKey(stroke.key, stroke.down, now, 0) for stroke in strokes]


def go_through(
    window: OperatedWindow,
    loaded: LoadedProtocol,
    opened: SessionOpened,
    recorder: Any,
    picture_records: PictureRecords | None = None,
) -> Session:
    """Go through a session to its end, or until the window raises what it likes.

    Args:
        window: where the participant sits.
        loaded: the protocol.
        opened: how the session opens.
        recorder: what takes its records.
        picture_records: makes records of pictures; None where none are recorded.
    """
    task = loaded.protocol.task
    fleet = open_fleet(task.name, task.parameters)
    fitter = InlineFitter(loaded.description, recorded_weights(loaded))
    with closing(fleet), closing(fitter):
        conductor = Conductor(
            Session(), recorder, fleet, fitter,
            epoch_ns=0, waits_for_disk=False, on_pictures=window.pictures.take,
            picture_records=picture_records,
        )  # fmt: skip
        conductor.feed(opened)
        LiveLoop(conductor, window, recorder, window.clock).run()
    return conductor.session
