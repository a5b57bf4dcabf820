"""A fork of a session goes on by itself, and as the session would have."""

from __future__ import annotations

import numpy as np
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from fake_shell import FakeShell, Moods
from short_study import opened, short_study
from study.recording.wire import encode
from study.session.forking import fork
from study.session.kept import KeptTimesteps


@settings(max_examples=20, phases=[Phase.explicit, Phase.generate])
@given(seed=st.integers(0, 2**32 - 1), share=st.floats(0, 1), suggested=st.booleans())
def test_a_fork_anywhere_goes_on_as_the_session_did(
    seed: int, share: float, suggested: bool
) -> None:
    """Fed with the same inputs it gives the same events and screens, and leaves the other alone."""
    changes = (('allocation = "manual"', 'allocation = "suggested"\nscorer = "luce"'),)
    loaded = short_study(*(changes if suggested else ()))
    shell = FakeShell(opened(loaded, seed=seed), seed, Moods(end_chance=0.2))
    shell.go_on_until(lambda: shell.finished)
    inputs = shell.inputs
    place = round(share * (len(inputs) - 1))

    again = FakeShell(opened(loaded, seed=seed), seed)
    for record in inputs[1:place]:
        again.feed(record)
    before = len(again.log)
    twin = fork(again.session)
    shown = twin.screen
    forked = [
        (event.topic, encode(event))
        for record in inputs[max(1, place) :]
        for event in twin.handle(record).events
    ]
    assert forked == shell.log[before:]
    assert twin.screen == shell.session.screen
    # Nothing of this reached the session that was forked.
    assert again.session.screen == shown
    for record in inputs[max(1, place) :]:
        again.feed(record)
    assert again.log == shell.log


def test_a_fork_shares_what_never_changes() -> None:
    """Protocol, texts and recorded rows are the same objects: that is why forks are cheap."""
    shell = FakeShell(opened(short_study()))
    shell.go_to_trial(2)
    for key in ("1", "up"):
        shell.key(key)
    for _ in range(15):
        shell.help()
    twin = fork(shell.session)
    kept = [part for part in twin.shared.values() if not isinstance(part, KeptTimesteps)]
    others = [part for part in shell.session.shared.values() if not isinstance(part, KeptTimesteps)]
    assert all(mine is other for mine, other in zip(kept, others, strict=True))
    assert len(kept) == 5
    rows = [part for part in twin.shared.values() if isinstance(part, KeptTimesteps)]
    theirs = [part for part in shell.session.shared.values() if isinstance(part, KeptTimesteps)]
    assert sum(len(part.choices) for part in rows) > 3
    assert sum(len(part.demonstrations.collected(4).actions) for part in rows) > 3
    for mine, other in zip(rows, theirs, strict=True):
        assert mine.choices is not other.choices
        assert all(row is copied for row, copied in zip(mine.choices, other.choices, strict=True))
        together = mine.demonstrations.collected(4), other.demonstrations.collected(4)
        assert np.array_equal(together[0].states, together[1].states)
