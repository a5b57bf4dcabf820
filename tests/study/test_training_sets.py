"""Training sets hold what the operator chose and did, and nothing else."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fake_shell import FakeShell, Moods
from short_study import opened, short_study
from study.events.codes import ActionSource, ChoiceFlag, ChoiceSource, Phase
from study.events.events import FitRequested, Timestep, TrialStarted
from study.session.effects import RequestFit
from study.training_sets import arrays_sha256, choice_sets, demonstrations, is_usable_choice

STATE_SIZE = 2


@st.composite
def timesteps(draw: st.DrawFn) -> Timestep:
    """Draw a row of any combination of codes, sensible or not."""
    robots = draw(st.integers(1, 4))

    def ints(*values: int) -> Any:
        drawn = draw(st.lists(st.sampled_from(values), min_size=robots, max_size=robots))
        return np.array(drawn, np.int32)

    numbers = draw(st.lists(st.floats(width=32), min_size=2 * robots, max_size=2 * robots))
    return Timestep(
        t_ns=0,
        due_ns=0,
        trial_id=draw(st.integers(0, 3)),
        timestep=0,
        robots=robots,
        operated=draw(st.integers(-1, robots - 1)),
        choice_source=draw(st.sampled_from(list(ChoiceSource))),
        choice_flag=draw(st.sampled_from(list(ChoiceFlag))),
        states=np.array(numbers, np.float32).reshape(robots, STATE_SIZE),
        actions=ints(*range(5)),
        action_sources=ints(*ActionSource),
        rewards=np.zeros(robots, np.float32),
        outcomes=np.zeros(robots, np.int32),
        available=ints(0, 1),
        scores=np.empty(0),
    )


@given(st.lists(timesteps(), max_size=12), st.integers(1, 4))
def test_choice_sets_hold_operator_choices_only(rows: list[Timestep], robots: int) -> None:
    """Each row is the operator's, usable, of a robot that could be chosen, in a fleet of n."""
    kept = [
        row
        for row in rows
        if row.robots == robots
        and row.choice_source == ChoiceSource.OPERATOR
        and row.choice_flag == ChoiceFlag.USABLE
        and row.operated != -1
        and row.available[row.operated] == 1
    ]
    sets = choice_sets(rows, robots, STATE_SIZE)
    assert sets.chosen.tolist() == [row.operated for row in kept]
    assert sets.trials.tolist() == [row.trial_id for row in kept]
    assert sets.states.shape == (len(kept), robots, STATE_SIZE)
    assert sets.available.shape == (len(kept), robots)
    for place, row in enumerate(kept):
        assert sets.states[place].tobytes() == row.states.tobytes()
        assert (sets.available[place] == (row.available == 1)).all()


@given(st.lists(timesteps(), max_size=12))
def test_demonstrations_are_executed_operator_actions(rows: list[Timestep]) -> None:
    """A demonstration is the operated robot's state and action, where the operator decided it."""
    kept = [
        (row.states[row.operated].tobytes(), int(row.actions[row.operated]))
        for row in rows
        if row.operated != -1 and row.action_sources[row.operated] == ActionSource.OPERATOR
    ]
    found = demonstrations(rows, STATE_SIZE)
    assert found.states.shape == (len(kept), STATE_SIZE)
    assert [(s.tobytes(), int(a)) for s, a in zip(found.states, found.actions, strict=True)] == kept


def operate(shell: FakeShell, presses: list[str]) -> None:
    """Go through a session, pressing the keys given in turn while robots move."""
    keys = iter(presses * 100)
    while not shell.finished:
        if shell.pace > 0 and shell.fleet is None and not shell.waiting():
            shell.key(next(keys), down=next(keys) != "release")
        shell.help()


@settings(max_examples=25)
@given(
    seed=st.integers(0, 1000),
    presses=st.lists(
        st.sampled_from(["1", "2", "5", "tab", "up", "left", "down", "right", "release"]),
        min_size=5,
        max_size=31,
    ),
)
def test_whole_sessions_train_on_the_operator_alone(seed: int, presses: list[str]) -> None:
    """Whatever is pressed, what a session asks to be fitted is what the operator decided."""
    loaded = short_study()
    idle = loaded.description.idle_action
    shell = FakeShell(opened(loaded, seed=seed), seed, Moods(end_chance=0.15))
    operate(shell, presses)
    phases = {e.trial_id: e for e in shell.events if isinstance(e, TrialStarted)}
    rows = [e for e in shell.events if isinstance(e, Timestep)]
    asked = {e.artefact_id: e for e in shell.effects if isinstance(e, RequestFit)}
    told = {e.artefact_id: e for e in shell.events if isinstance(e, FitRequested)}

    def of(phase: Phase, condition: str = "") -> list[Timestep]:
        places = {i for i, t in phases.items() if (t.phase, t.condition) == (phase, condition)}
        return [row for row in rows if row.trial_id in places]

    choices = [row for row in of(Phase.TWO) if is_usable_choice(row)]
    luce = asked["scorer:luce"].arrays
    assert luce["chosen"].tolist() == [row.operated for row in choices]
    assert luce["trials"].tolist() == [row.trial_id for row in choices]
    assert luce["available"][np.arange(len(choices)), luce["chosen"]].all()
    for condition in ("manual", "assisted"):
        arrays = asked[f"policy:{condition}"].arrays
        used = of(Phase.ONE) + of(Phase.THREE, condition)
        mine = [row for row in used if (row.action_sources == ActionSource.OPERATOR).any()]
        assert arrays["actions"].tolist() == [int(row.actions[row.operated]) for row in mine]
        assert idle not in arrays["actions"]
    for artefact, request in asked.items():
        assert told[artefact].rows == len(request.arrays["states"])
        assert told[artefact].data_sha256 == arrays_sha256(dict(request.arrays))


@pytest.mark.parametrize(
    "other",
    [
        {"a": np.array([[1, 2]], np.int32)},
        {"b": np.array([1, 2], np.int32)},
        {"a": np.array([1, 2], np.int64)},
        {"a": np.array([1, 3], np.int32)},
    ],
    ids=["shape", "name", "type", "value"],
)
def test_hash_tells_data_apart(other: dict[str, Any]) -> None:
    """The hash of training data depends on names, types, shapes and values."""
    data: dict[str, Any] = {"a": np.array([1, 2], np.int32)}
    assert arrays_sha256(other) != arrays_sha256(data)
    assert arrays_sha256({"a": data["a"].copy()}) == arrays_sha256(data)
