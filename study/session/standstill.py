"""A session that stands still: why, what its screen asks, and who may let it go on."""

from __future__ import annotations

from typing import Literal

from study.messages import noted
from study.screens import PauseScreen
from study.session.context import Context

Asked = Literal["", "continue", "stop", "erase"]

_PAUSED = noted("Paused")
HELD = noted("The experimenter has paused the session")
_INTERRUPTED = noted("Saving was interrupted. One moment, please")
_RESTORED = noted("Saving was interrupted for a moment; it works again")


class Standstill:
    """The pause of a session, if there is one.

    Attributes:
        held: whether the experimenter keeps the session standing still.
        part: of the recording, as far as is known.
    """

    def __init__(self) -> None:
        self._since_ns = -1
        self._asks: Literal["", "stop", "erase"] = ""
        self._reason = _PAUSED
        self._interruption = ""
        self._interrupted_ns = 0
        self._held_alone = False
        self.held = False
        self.part = 1

    @property
    def on(self) -> bool:
        """Whether the session stands still."""
        return self._since_ns >= 0

    def begin(self, t_ns: int) -> None:
        """Stand still from a session time on."""
        self._since_ns = t_ns
        self._asks = ""
        self._reason = _PAUSED

    def end(self, t_ns: int) -> int:
        """Go on, whatever was the reason; return how long it stood still, ns."""
        stood, self._since_ns = t_ns - self._since_ns, -1
        self._interruption = ""
        self.held = self._held_alone = False
        return stood

    def hold(self, *, alone: bool = False) -> None:
        """Keep it until `release`: the participant cannot end the pause.

        Args:
            alone: whether there would be no pause without it.
        """
        self.held, self._held_alone = True, alone
        self._asks = ""

    def release(self) -> bool:
        """Give it back; return whether the session goes on, as nothing else keeps it."""
        self.held = False
        return self._held_alone and not self._interruption

    def interrupt(self, t_ns: int, reason: str) -> None:
        """Keep it until `restore`: the recording is interrupted."""
        self._interruption = reason or "no reason given"
        self._interrupted_ns = t_ns

    def restore(self, t_ns: int, part: int, *, tells_stalls: bool) -> str:
        """Say what had interrupted the recording and how it goes on; empty if nothing had.

        Args:
            t_ns: session time.
            part: that is being written now; all that waited is on disk.
            tells_stalls: whether a part that goes on is told from one that begins.
        """
        interruption, self._interruption = self._interruption, ""
        goes_on, self.part = tells_stalls and part == self.part, part
        if not interruption:
            return ""
        self._reason = _RESTORED
        # What was seen of the interruption asks for the participant's own going on.
        self._held_alone = False
        if goes_on:
            waited = (t_ns - self._interrupted_ns) / 1e9
            return (
                f"{interruption}; {waited:.1f} s later all records were on disk: nothing was lost"
            )
        return f"{interruption}; recorded in part {part} from here"

    def take(self, word: str, *, can_erase: bool) -> Asked:
        """Take what the participant says; return what follows once it was said for certain.

        Args:
            word: "continue", "stop", "erase", "yes", or anything else.
            can_erase: whether erasing is offered.
        """
        asks = self._asks
        if word == "continue":
            if self.held:
                self._asks = ""
                return ""
            return "" if self._interruption else "continue"
        if word in ("yes", asks) and asks:
            return asks
        if word == "stop" and not asks:
            self._asks = "stop"
        elif word == "erase" and not asks and can_erase:
            self._asks = "erase"
        return ""

    def screen(self, context: Context) -> PauseScreen:
        """Return what the participant sees of it."""
        reason = self._reason
        if self._interruption:
            reason = _INTERRUPTED
        elif self.held:
            reason = HELD
        return PauseScreen(
            context.say(reason),
            confirm_stop=self._asks == "stop",
            can_erase=context.rules >= 1,
            confirm_erase=self._asks == "erase",
            can_go_on=not self.held,
        )
