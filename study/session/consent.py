"""Consent: asked before anything is recorded, so it stands outside the session."""

from __future__ import annotations

import hashlib
from typing import Literal

from study.messages import Messages
from study.protocol import Protocol
from study.screens import ConsentScreen
from study.seat_settings import ConsentPart

Decision = Literal["", "agreed", "declined"]


def consent_sha256(part: ConsentPart) -> str:
    """Return the SHA-256 of the text agreed to, hexadecimal."""
    return hashlib.sha256(part.text().encode()).hexdigest()


class Consent:
    """Reads the participant's decision off keys and pointer; either takes two steps.

    Args:
        protocol: must have a consent text.
        messages: the texts of the participant's language.
    """

    def __init__(self, protocol: Protocol, messages: Messages) -> None:
        self._say = messages.say
        assert protocol.consent is not None  # noqa: S101 - asked for only where there is a text
        self._part = protocol.consent
        self._keys = protocol.keys
        self._asks: Decision = ""

    def key(self, key: str) -> Decision:
        """A key went down; return the decision once it is confirmed."""
        words = {self._keys.confirm: "confirm", "y": "agree", "n": "decline"}
        return self.point(words.get(key, "back" if key == self._keys.back else ""))

    def point(self, target: str) -> Decision:
        """A target was clicked; return the decision once it is confirmed."""
        if target == "agree":
            self._asks = "agreed"
        elif target == "decline":
            self._asks = "declined"
        elif target == "back":
            self._asks = ""
        elif target == "confirm":
            return self._asks
        return ""

    def screen(self) -> ConsentScreen:
        """Return the text and what was chosen so far; nothing is preselected."""
        return ConsentScreen(
            title=self._say(self._part.title),
            paragraphs=tuple(self._say(text) for text in self._part.paragraphs),
            chosen=self._asks,
        )
