"""The console's one question: a line of text, for a note or for the reason of an early end."""

from __future__ import annotations

from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.screen import ModalScreen
from textual.widgets import Input, Static

from study.console.wire import LONGEST_TEXT


class AskText(ModalScreen[str]):
    """Asks for a line; dismissed with it, or with an empty one if it was called off.

    Args:
        title: what is asked for.
        hint: what follows from it.
        action: what Enter does.
        alarming: whether it looks so.
    """

    CSS = """
    AskText { align: center middle; }
    #box { width: 76; max-width: 94%; height: auto; padding: 1 2; background: $surface;
           border: round $primary; }
    #box.alarming { border: heavy $error; }
    #hint { color: $text-muted; margin-bottom: 1; }
    #keys { color: $text-muted; margin-top: 1; }
    #box.empty #keys { color: $text-warning; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("escape", "call_off", "Call off")]

    def __init__(self, title: str, hint: str, action: str, *, alarming: bool = False) -> None:
        super().__init__()
        self._title = title
        self._hint = hint
        self._alarming = alarming
        self._keys = f"Enter: {action}   Escape: call it off"

    def compose(self) -> ComposeResult:
        """Lay it out."""
        with Vertical(id="box", classes="alarming" if self._alarming else ""):
            yield Static(self._title, markup=False)
            yield Static(self._hint, id="hint", markup=False)
            yield Input(max_length=LONGEST_TEXT, id="text")
            yield Static(self._keys, id="keys", markup=False)

    def on_mount(self) -> None:
        """Begin to type at once."""
        self.query_one(Input).focus()

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Take the line; an empty one is asked for again."""
        if event.value.strip():
            self.dismiss(event.value)
            return
        self.query_one("#box").add_class("empty")
        self.query_one("#keys", Static).update(f"Write some words first.   {self._keys}")

    def action_call_off(self) -> None:
        """Leave all as it is."""
        self.dismiss("")
