"""Tells the experimenter at the terminal, at once, what deviates from the protocol."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from rich.markup import escape

from study.commands.terminal import errors
from study.events.events import Deviation, Event
from study.events.fit_events import FitGateJudged

_WITHOUT_A_FIT = (
    "What needs it runs without it: a scorer chooses and suggests nothing, a policy acts at random."
)
MOST_TOLD = 5
"""Kinds of failed fits that a simulation tells of."""
_CONSEQUENCES = {
    "fit_failed": _WITHOUT_A_FIT,
    "fit_timed_out": _WITHOUT_A_FIT,
    "correction_round_skipped": "Its trials are passed over; nothing else changes.",
}
_DECISIONS = {
    "repeat": "Phase two goes on for some trials, and the scorer is fitted again.",
    "go_on": "The scorer is used as it is.",
    "end": "The session ends here, as the protocol says.",
}
"""What follows where a gate was not passed."""


def tell_deviations(numbered: Sequence[tuple[int, Event]]) -> None:
    """Print the deviations among events; a watcher of `Conductor`.

    An early end is not among them: the command says it when all is closed.
    """
    # A gate says itself what follows.
    judged = any(isinstance(event, FitGateJudged) for _, event in numbered)
    for _, event in numbered:
        if isinstance(event, Deviation) and event.code != "ended_early":
            consequence = "" if judged else _CONSEQUENCES.get(event.code, "")
            minutes, seconds = divmod(event.t_ns // 1_000_000_000, 60)
            errors.print(
                f"[yellow]Deviation[/] at {minutes}:{seconds:02}: {escape(event.code)}, "
                f"{escape(event.text)}. {consequence}".rstrip()
            )


class FailedFits:
    """Keeps in words which fits failed; a watcher of `Conductor`.

    Attributes:
        found: each of them once.
    """

    def __init__(self) -> None:
        self.found: set[str] = set()

    def __call__(self, numbered: Sequence[tuple[int, Event]]) -> None:
        """Take in what happened."""
        self.found |= {
            f"{event.code}: {event.text}"
            for _, event in numbered
            if isinstance(event, Deviation) and event.code in ("fit_failed", "fit_timed_out")
        }


def tell_failed_fits(by_session: Sequence[Iterable[str]]) -> None:
    """Print which fits failed in simulated sessions, and in how many."""
    failed = Counter(text for found in by_session for text in found)
    for text, sessions in sorted(failed.items())[:MOST_TOLD]:
        where = f"in {sessions} of {len(by_session)} sessions"
        errors.print(f"[yellow]Deviation[/] {where}: {escape(text)}. {_WITHOUT_A_FIT}")
    if len(failed) > MOST_TOLD:
        errors.print(
            f"And {len(failed) - MOST_TOLD} more kinds; the table deviations has them all."
        )


def tell_gates(numbered: Sequence[tuple[int, Event]]) -> None:
    """Say what scorers' gates found and decided; a watcher of `Conductor`.

    The reason why a gate was not passed is told as a deviation.
    """
    for _, event in numbered:
        if not isinstance(event, FitGateJudged):
            continue
        name = escape(event.artefact_id)
        if event.passed:
            errors.print(
                f"[green]Gate passed[/]: {name}: held-out log-likelihood "
                f"{event.likelihood_gain:.3f} nats a choice and top-1 {event.top1_gain:.3f} above "
                f"chance, calibration error {event.calibration_error:.3f}."
            )
        elif event.decision == "fallback":
            instead = (
                "the participant chooses"
                if event.fallback == "manual"
                else f"{escape(event.fallback)} chooses"
            )
            errors.print(f"In place of {name} {instead}.")
        else:
            errors.print(_DECISIONS.get(event.decision, ""))
