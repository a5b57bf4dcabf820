"""The state of the keys: which action the operator asks for at a timestep."""

from __future__ import annotations


class Controls:
    """Remembers keys held and tapped, newest last.

    The action of a timestep is the newest key held, or tapped since the last timestep. A
    key held across a switch does not act on the new robot until it is pressed again.
    """

    def __init__(self) -> None:
        self._presses = 0
        self._held: dict[str, int] = {}
        self._tapped: dict[str, int] = {}

    def press(self, key: str) -> None:
        """A key went down."""
        self._presses += 1
        self._held[key] = self._presses
        self._tapped[key] = self._presses

    def release(self, key: str) -> None:
        """A key came up."""
        self._held.pop(key, None)

    def release_all(self) -> None:
        """The keyboard is out of reach: nothing is held any more."""
        self._held.clear()
        self._tapped.clear()

    def robot_switched(self) -> None:
        """Make keys now held inactive until they are pressed again."""
        self.release_all()

    def newest(self) -> str | None:
        """Return the key that acts now, or None."""
        candidates = {**self._tapped, **self._held}
        if not candidates:
            return None
        return max(candidates, key=lambda key: candidates[key])

    def timestep_done(self) -> None:
        """Forget taps: they have acted."""
        self._tapped.clear()
