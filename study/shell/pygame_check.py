"""Makes sure that `pygame` is pygame-ce: both install under the same name."""

from __future__ import annotations

from study.errors import StudyError

HINT = "Mend it with: pip uninstall --yes pygame pygame-ce && pip install pygame-ce"


def require_pygame_ce() -> None:
    """Check that the pygame that Python finds is pygame-ce.

    Raises:
        StudyError: it is another one, or there is none.
    """
    try:
        import pygame  # noqa: PLC0415
    except ImportError as error:
        raise StudyError(f"pygame-ce cannot be loaded: {error}", HINT) from error
    if not getattr(pygame, "IS_CE", False):
        version = getattr(getattr(pygame, "version", None), "ver", "of unknown version")
        raise StudyError(
            f"the installed pygame is the package pygame {version}, not pygame-ce: one has "
            "overwritten the files of the other",
            HINT,
        )
