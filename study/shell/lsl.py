"""An outlet of Lab Streaming Layer; needs the extra ``lsl`` (pylsl, which brings liblsl)."""

from __future__ import annotations

import importlib
import time
from types import ModuleType
from typing import Any

from study.errors import StudyError
from study.events.inputs import SessionOpened

STREAM_NAME = "scaled_autonomy"
STREAM_TYPE = "Markers"
_LAST_WORDS_S = 0.3


class LslOutlet:
    """A stream of markers: irregular, one channel of text.

    Its source id is the session's, so that whoever receives comes back to a resumed session.

    Args:
        opened: the session that it belongs to.

    Raises:
        StudyError: pylsl or liblsl is missing, or no stream can be opened.
    """

    def __init__(self, opened: SessionOpened) -> None:
        pylsl = load_pylsl()
        try:
            info = pylsl.StreamInfo(
                name=STREAM_NAME,
                type=STREAM_TYPE,
                channel_count=1,
                nominal_srate=pylsl.IRREGULAR_RATE,
                channel_format=pylsl.cf_string,
                source_id=opened.session_id,
            )
            about = info.desc()
            about.append_child_value("session_id", opened.session_id)
            about.append_child_value("participant", opened.participant)
            about.append_child_value("format", "JSON, one event of the recording a marker")
            self._outlet: Any = pylsl.StreamOutlet(info)
        except Exception as error:
            raise StudyError(
                f"the stream of markers cannot be opened: {error}",
                "Check the network, or leave out --lsl.",
            ) from error
        self._clock = pylsl.local_clock

    def clock(self) -> float:
        """Return LSL's clock, s."""
        return float(self._clock())

    def push(self, marker: str, at_seconds: float) -> None:
        """Hand a marker to LSL's own thread."""
        self._outlet.push_sample([marker], at_seconds)

    def has_consumers(self) -> bool:
        """Return whether anyone receives the stream now."""
        return self._outlet is not None and bool(self._outlet.have_consumers())

    def close(self) -> None:
        """Destroy the stream, after a moment in which those who receive get the last markers."""
        if self.has_consumers():
            time.sleep(_LAST_WORDS_S)
        self._outlet = None


def load_pylsl() -> ModuleType:
    """Return pylsl with its library loaded.

    Raises:
        StudyError: one of the two is missing; says what to install.
    """
    try:
        return importlib.import_module("pylsl")
    except ImportError as error:
        raise StudyError(
            "--lsl needs the package pylsl, which is not installed",
            "Install it: `pip install 'scaled-autonomy[lsl]'`.",
        ) from error
    except (RuntimeError, OSError) as error:
        # pylsl is there, but the library that it wraps is not, or does not suit this system.
        raise StudyError(
            "--lsl needs the library liblsl, which pylsl does not find on this system",
            "The wheels of pylsl for Linux (glibc 2.35 or newer), macOS and Windows bring it: "
            "`pip install --force-reinstall 'scaled-autonomy[lsl]'`. Elsewhere install liblsl "
            "and name its file in the variable PYLSL_LIB.",
        ) from error
