"""Versions of the session's rules: a recording replays by those that it was made under.

0: before rules had a version. 1: every change of an answer is an event, instruments are scored,
a pause offers to erase the recording, and a window that is resized or minimised pauses. 2: scorers
are fitted in the background before the last trial of phase two, and the fit goes on from there.
3: a questionnaire takes no key in its first half second, when keys may still be meant for robots.
4: where all questions are answered, a digit corrects the last answer, two digits make a number on a
scale to more than 9, and an early end says in which trial it was. 5: a recording that was
interrupted and goes on in the same part is told from one that goes on in another.
"""

from __future__ import annotations

WARM_STARTS = 2
"""From which version on scorers are fitted in the background."""
DEAD_TIME = 3
"""From which version on a questionnaire takes no key at first."""
CORRECTING_DIGITS = 4
"""From which version on a digit corrects the answer given last."""
NUMBERS_ON_SCALES = 4
"""From which version on two digits make a number on a scale."""
TRIAL_OF_END = 4
"""From which version on an early end says in which trial it was."""
STALLS_TOLD = 5
"""From which version on a part of the recording that goes on is told from one that begins."""
CURRENT = 5
