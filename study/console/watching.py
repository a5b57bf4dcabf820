"""The screen of one session: what it says, and the four things an experimenter can ask for."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path
from typing import ClassVar

from rich.text import Text
from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Grid, VerticalScroll
from textual.screen import Screen
from textual.timer import Timer
from textual.widgets import Footer, Static

from study.console import words
from study.console.dialogs import AskText
from study.console.wire import (
    LONGEST_STATUS,
    Answer,
    Command,
    CommandName,
    Ended,
    Status,
    parse_said,
)
from study.errors import StudyError

REFRESH_S = 0.2
SAID_S = 6.0
"""How long an answer is shown."""
PANELS = {
    "now": "Now",
    "recording": "Recording",
    "timing": "Timing",
    "fits": "Fits, on held-out choices",
    "deviations": "Deviations",
    "notes": "Notes",
}
_DONE = {
    "pause": "The session is paused.",
    "resume": "The session goes on.",
    "annotate": "The note is recorded.",
    "end": "The session is ended.",
}


class WatchScreen(Screen[None]):
    """Follows one session until it or the console ends.

    Args:
        path: of its socket.

    Attributes:
        status: what it said last.
        farewell: why nothing more comes; empty while it is followed.
        over: whether that is because the session ended, as it should.
    """

    CSS = """
    #headline { height: auto; min-height: 2; padding: 0 1; }
    #panels { grid-size: 2; grid-rows: 8 8 1fr; grid-gutter: 0 1; }
    #said { height: 1; padding: 0 1; color: $text-success; }
    #said.refused { color: $text-warning; }
    .panel { border: round $primary; border-title-color: $text; padding: 0 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("p", "pause", "Pause"),
        Binding("r", "resume", "Resume"),
        Binding("n", "annotate", "Note"),
        Binding("e", "end", "End early"),
        Binding("l", "back", "Other sessions"),
    ]

    def __init__(self, path: Path) -> None:
        super().__init__()
        self._path = path
        self._writer: asyncio.StreamWriter | None = None
        self._heard = time.monotonic()
        self._silencer: Timer | None = None
        self.over = False
        self.status: Status | None = None
        self.farewell = ""

    def compose(self) -> ComposeResult:
        """Lay out the panels."""
        yield Static("Waiting for the session's first word", id="headline", markup=False)
        with Grid(id="panels"):
            for name, title in PANELS.items():
                panel = VerticalScroll(Static("", id=name, markup=False), classes="panel")
                panel.border_title = title
                panel.can_focus = False
                yield panel
        # Not over a panel, as notifications are: what is noted must be seen.
        yield Static("", id="said", markup=False)
        yield Footer(show_command_palette=False)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Offer only what can be done now: nothing of a session that is over."""
        asks = action in ("pause", "resume", "annotate", "end")
        if asks and self.farewell:
            return False
        if self.status is not None:
            if action == "pause":
                return self.status.state != "held"
            if action == "resume":
                # The participant's own pause is theirs to end.
                return self.status.state == "held"
        return super().check_action(action, parameters)

    def on_mount(self) -> None:
        """Begin to follow."""
        self.run_worker(self._follow(), exclusive=True)
        self.set_interval(REFRESH_S, self.show)

    def on_unmount(self) -> None:
        """Hang up: the session does not mind."""
        if self._writer:
            self._writer.close()

    async def _follow(self) -> None:
        try:
            reader, self._writer = await asyncio.open_unix_connection(
                str(self._path), limit=LONGEST_STATUS
            )
            while line := await reader.readline():
                self._take(parse_said(line))
        except (OSError, ValueError):
            pass  # It is gone: said below.
        except StudyError as error:
            self._part(str(error))
        if not self.farewell:
            self._part(
                "The session's program is gone without having ended the session: it was killed, or "
                "met an error. What the recording holds is safe; `study run ... --resume` goes on."
            )
        self.show()

    def _part(self, words: str) -> None:
        """Follow no longer: what asks something of the session is not offered any more."""
        self.farewell = words
        self.refresh_bindings()

    def _take(self, said: Status | Answer | Ended) -> None:
        self._heard = time.monotonic()
        if isinstance(said, Status):
            before, self.status = self.status, said
            if before is None or before.state != said.state:
                self.refresh_bindings()
        elif isinstance(said, Answer):
            if said.refused:
                self._tell(f"Not done: {said.refused}", refused=True)
            else:
                self._tell(_DONE.get(said.command, "Done."))
        else:
            how = "complete" if said.complete else f"ended early: {said.reason}"
            self._part(f"The session is over ({how}). L lists others, Q closes the console.")
            self.over = True
        self.show()

    def show(self) -> None:
        """Bring what is seen up to date."""
        # A last word may come while the screen is being taken away.
        if not all(self.query(f"#{name}") for name in ("headline", *PANELS)):
            return
        status = self.status
        headline = self.query_one("#headline", Static)
        if status is None:
            if self.farewell:
                headline.update(Text(self.farewell))
            return
        silence = 0.0 if self.farewell else time.monotonic() - self._heard
        headline.update(words.headline(status, silence, self.farewell, over=self.over))
        self.query_one("#now", Static).update(words.now(status))
        self.query_one("#recording", Static).update(
            words.recording(status, silence, over=self.over)
        )
        self.query_one("#timing", Static).update(words.timing(status))
        self.query_one("#fits", Static).update(words.fits(status))
        self.query_one("#deviations", Static).update(
            words.remarks(status.deviations, status.deviations_left_out)
        )
        self.query_one("#notes", Static).update(words.remarks(status.notes, status.notes_left_out))

    def _tell(self, words: str, *, refused: bool = False) -> None:
        """Say for a while what came of what was asked for."""
        line = self.query_one("#said", Static)
        line.update(words)
        line.set_class(refused, "refused")
        if self._silencer is not None:
            self._silencer.stop()
        self._silencer = self.set_timer(SAID_S, lambda: line.update(""))

    def _ask_for(self, command: CommandName, text: str = "") -> None:
        if self.farewell or self._writer is None:
            self._tell("There is no session to tell that.", refused=True)
            return
        line = Command(command=command, text=text).model_dump_json().encode()
        self._writer.write(line + b"\n")

    def action_pause(self) -> None:
        """Ask the session to stand still."""
        self._ask_for("pause")

    def action_resume(self) -> None:
        """End the experimenter's pause."""
        self._ask_for("resume")

    def action_annotate(self) -> None:
        """Record a note."""

        def take(text: str | None) -> None:
            if text:
                self._ask_for("annotate", text)

        dialog = AskText(
            "A note, recorded with the time of now",
            "No names, please: the note becomes part of the data.",
            "record it",
        )
        self.app.push_screen(dialog, take)

    def action_end(self) -> None:
        """End the session early, with a reason."""

        def take(text: str | None) -> None:
            if text:
                self._ask_for("end", text)

        who = self.status.facts.participant if self.status else "the participant"
        self.app.push_screen(
            AskText(
                f"End the session of {who} now? Why?",
                "The reason is recorded, and all that was recorded so far is kept.",
                "end the session",
                alarming=True,
            ),
            take,
        )

    def action_back(self) -> None:
        """Go back to the list."""
        self.dismiss()
