"""A session that goes on from where another stands, for replays that go back and forth."""

from __future__ import annotations

import copy

from study.session.session import Session


def fork(session: Session) -> Session:
    """Return a session that goes on from here by itself.

    What a session never changes is shared: the protocol, the texts, the plan and all records. So a
    fork takes milliseconds, and most of its memory is shared too.
    """
    return copy.deepcopy(session, {id(part): part for part in session.unchanging})
