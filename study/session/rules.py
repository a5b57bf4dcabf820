"""Versions of the session's rules: a recording replays by those that it was made under.

0: before rules had a version. 1: every change of an answer is an event, instruments are scored,
a pause offers to erase the recording, and a window that is resized or minimised pauses.
"""

from __future__ import annotations

CURRENT = 1
