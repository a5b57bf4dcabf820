"""Tells the experimenter at the terminal, at once, what deviates from the protocol."""

from __future__ import annotations

from collections.abc import Sequence

from rich.markup import escape

from study.commands.terminal import errors
from study.events.events import Deviation, Event

_WITHOUT_A_FIT = (
    "What needs it runs without it: a scorer chooses and suggests nothing, a policy acts at random."
)
_CONSEQUENCES = {"fit_failed": _WITHOUT_A_FIT, "fit_timed_out": _WITHOUT_A_FIT}


def tell_deviations(numbered: Sequence[tuple[int, Event]]) -> None:
    """Print the deviations among events; a watcher of `Conductor`.

    An early end is not among them: the command says it when all is closed.
    """
    for _, event in numbered:
        if isinstance(event, Deviation) and event.code != "ended_early":
            minutes, seconds = divmod(event.t_ns // 1_000_000_000, 60)
            errors.print(
                f"[yellow]Deviation[/] at {minutes}:{seconds:02}: {escape(event.code)}, "
                f"{escape(event.text)}. {_CONSEQUENCES.get(event.code, '')}".rstrip()
            )
