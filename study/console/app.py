"""The console: lists the sessions that run, and follows one of them."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from textual import work
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.widgets import Footer, OptionList, Static
from textual.widgets.option_list import Option

from study.console import words
from study.console.finding import Found, find_sessions
from study.console.watching import WatchScreen

LOOK_EVERY_S = 1.0
NONE = (
    "No session runs on this computer under your account.\n\n"
    "Start one in another terminal with `study run`: it appears here by itself.\n"
    "A session appears once its participant has agreed to take part."
)


class ConsoleApp(App[None]):
    """A list of sessions; the only one is opened at once.

    Args:
        participant: whose session to open as soon as it runs; empty for any.
    """

    TITLE = "study console"
    ENABLE_COMMAND_PALETTE = False
    CSS = """
    #title { padding: 1 2; }
    #none { padding: 0 2; color: $text-muted; }
    OptionList { margin: 0 1; height: 1fr; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("q", "quit", "Close the console")]

    def __init__(self, participant: str = "") -> None:
        super().__init__()
        self._participant = participant
        self._chose = False
        self._listed: tuple[Path, ...] = ()

    def compose(self) -> ComposeResult:
        """Lay out the list."""
        yield Static("Sessions on this computer", id="title", markup=False)
        yield Static("Looking", id="none", markup=False)
        yield OptionList(id="sessions", markup=False)
        yield Footer(show_command_palette=False)

    def on_mount(self) -> None:
        """Look now and then."""
        self.query_one(OptionList).display = False
        self.look()
        self.set_interval(LOOK_EVERY_S, self.look)

    def look(self) -> None:
        """Look for sessions, unless one is being followed."""
        if len(self.screen_stack) == 1:
            self._find()

    @work(thread=True, exclusive=True)
    def _find(self) -> None:
        found = find_sessions()
        self.call_from_thread(self._take, found)

    def _take(self, found: list[Found]) -> None:
        if len(self.screen_stack) > 1:
            return
        wanted = [
            each
            for each in found
            if not self._participant
            or (each.status and each.status.facts.participant == self._participant)
        ]
        if not self._chose and len(wanted) == 1:
            self.follow(wanted[0].path)
            return
        self.query_one("#none", Static).update("Enter opens one." if found else NONE)
        options = self.query_one(OptionList)
        options.display = bool(found)
        paths = tuple(each.path for each in found)
        if paths != self._listed:
            self._listed = paths
            options.clear_options()
            options.add_options([Option(_line(each), id=str(each.path)) for each in found])
            options.highlighted = 0 if found else None
            self.call_after_refresh(options.focus)
        else:
            for each in found:
                options.replace_option_prompt(str(each.path), _line(each))

    def follow(self, path: Path) -> None:
        """Open the session of a socket."""
        self._chose = True
        self.push_screen(WatchScreen(path), lambda _: self.look())

    def on_option_list_option_selected(self, event: OptionList.OptionSelected) -> None:
        """Follow the chosen session."""
        if event.option.id:
            self.follow(Path(event.option.id))


def _line(found: Found) -> str:
    status = found.status
    if status is None:
        return found.name
    place = status.place
    where = f"stage {place.number} of {place.stages}, {place.name.replace('_', ' ')}"
    return f"{found.name}: {where}; {status.state}, {words.clock(status.t_s)}"
