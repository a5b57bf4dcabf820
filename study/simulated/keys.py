"""An operator's hands: at most one driving key is down at a time."""

from __future__ import annotations

import dataclasses

_NUMBER_KEYS = ("1", "2", "3", "4", "5", "6", "7", "8", "9", "0", "-", "=")


@dataclasses.dataclass(frozen=True, slots=True)
class KeyStroke:
    """A key that goes down or up.

    Attributes:
        key: its name: "up", "1", "tab", "return", ...
        down: true when pressed, false when released.
    """

    key: str
    down: bool


def tap(key: str) -> tuple[KeyStroke, KeyStroke]:
    """Return the strokes that press a key and let it go."""
    return KeyStroke(key, down=True), KeyStroke(key, down=False)


def number_key(robot: int) -> str | None:
    """Return the key that chooses ``robot`` (from 0), or None beyond the twelfth."""
    return _NUMBER_KEYS[robot] if 0 <= robot < len(_NUMBER_KEYS) else None


def number_keys(robot: int, robots: int) -> tuple[str, ...]:
    """Return the keys that choose ``robot`` (from 0) among ``robots``, to be tapped in turn.

    Beyond the keys of the number row, numbers are typed; 0 before a digit chooses at once.
    """
    if robots <= len(_NUMBER_KEYS):
        key = number_key(robot)
        return () if key is None else (key,)
    return tuple(f"{robot + 1:02d}")


class DrivingHand:
    """Holds the driving keys.

    Attributes:
        held: the key that is down, or "".
    """

    __slots__ = ("held",)

    def __init__(self) -> None:
        self.held = ""

    def hold(self, key: str) -> tuple[KeyStroke, ...]:
        """Hold ``key`` and no other from now on; "" lets go.

        Returns:
            The strokes that takes: none if the key is down already.
        """
        if key == self.held:
            return ()
        before, self.held = self.held, key
        strokes = (KeyStroke(before, down=False),) if before else ()
        return (*strokes, KeyStroke(key, down=True)) if key else strokes
