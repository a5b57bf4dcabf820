"""How large a design of 1280x960 is drawn in a window."""

from __future__ import annotations

SMALLEST_SCALE = 0.85
"""Below this, body text of 19 px would fall under 16 px."""


def ui_scale(size: tuple[int, int], factor: float = 1.0) -> float:
    """Return how many pixels one design pixel (of 1280x960) takes in a window.

    Args:
        size: of the window, pixels.
        factor: the user's wish, 1 for none.
    """
    return max(SMALLEST_SCALE, min(size[0] / 1280, size[1] / 960)) * factor
