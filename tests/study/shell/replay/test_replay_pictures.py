"""Replays of a task that takes pictures: they are taken again, and never a wrong one is shown."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from protocols import SHORT_ICE, variant
from seen_inputs import SeenInputs, Shots, seen_session
from study.events.inputs import FleetObserved, Input, SessionOpened
from study.shell.drawing.pictures import Pictures
from study.shell.replay.camera import Camera, Stage
from study.shell.replay.film import Episode, Film
from study.shell.replay.head import Head

pytest.importorskip("gymnasium")


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> SeenInputs:
    """A session on slippery ice, and what the participant saw in it."""
    folder = tmp_path_factory.mktemp("ice")
    return seen_session(variant(folder, *SHORT_ICE, base="frozen_lake"))


def heads(inputs: Sequence[Input]) -> Iterator[tuple[Head, Input]]:
    """Feed a session, and say after each input where it stands."""
    head = Head()
    for given in inputs:
        head.take_note(None, given, head.session.handle(given))  # type: ignore[arg-type]
        yield head, given


def shown(pictures: Pictures, robots: int) -> list[Shots | None]:
    """Return what tiles would show."""
    return [pictures.of(robot).pixels for robot in range(robots)]


def test_pictures_are_taken_again_as_they_were(seen: SeenInputs) -> None:
    """From seeds and actions alone every robot's every picture comes back, to the byte."""
    pictures, compared = Pictures(), 0
    with closing(Camera()) as camera:
        for head, given in heads(seen.inputs):
            if not isinstance(given, FleetObserved) or given.request_id not in seen.pictures:
                continue
            camera.show(head.film, pictures)
            expected = seen.pictures[given.request_id]
            for pixels, before in zip(shown(pictures, given.robots), expected, strict=True):
                assert pixels is not None
                assert pixels.tobytes() == before.tobytes()
            compared += 1
    assert compared > 60


def test_going_back_shows_what_was_there(seen: SeenInputs) -> None:
    """A fork of an earlier moment is shown after a later one."""
    forks, later = [], None
    for head, given in heads(seen.inputs):
        if isinstance(given, FleetObserved) and given.request_id in seen.pictures:
            forks.append((head.fork(), given))
        later = head
    assert later is not None
    pictures = Pictures()
    with closing(Camera()) as camera:
        for head, given in [*forks[-3:], *forks[10:13], *forks[2:4]]:
            camera.show(head.film, pictures)
            expected = seen.pictures[given.request_id]
            for pixels, before in zip(shown(pictures, given.robots), expected, strict=True):
                assert pixels is not None
                assert pixels.tobytes() == before.tobytes()


def test_nobody_takes_pictures_while_nobody_looks(seen: SeenInputs) -> None:
    """In phase four, whose robots are not shown, none are taken."""
    answered = [given for given in seen.inputs if isinstance(given, FleetObserved)]
    assert 0 < len(seen.pictures) < len(answered)


def test_states_that_differ_have_no_picture(seen: SeenInputs) -> None:
    """Where the task stepped again comes to another state, the picture is missing."""
    stage = Stage("gymnasium:FrozenLake-v1", {})
    states = np.zeros((2, 16), np.float32)
    states[0, 0] = states[1, 7] = 1.0
    first, second = stage.pictures([Episode(1), Episode(2)], states)
    assert first is not None
    assert second is None


@pytest.mark.parametrize(
    "change",
    [
        ("gymnasium:FrozenLake-v1", "gymnasium:NotHere-v1"),
        ("gymnasium:FrozenLake-v1", "gymnasium:odd_environments:Counter-v0"),
        ('"goal_if_rewarded"', '"nonsense"'),
    ],
    ids=["unknown", "imports", "wrong"],
)
def test_what_cannot_be_drawn_is_missing(
    seen: SeenInputs, change: tuple[str, str], tmp_path: Path
) -> None:
    """An unknown task, one that would be imported, or a wrong protocol: no picture."""
    head = next(head for head, given in heads(seen.inputs) if isinstance(given, FleetObserved))
    film = dataclasses.replace(
        head.film.copy(), protocol_toml=head.film.protocol_toml.replace(*change)
    )
    pictures = Pictures()
    with closing(Camera()) as camera:
        camera.show(film, pictures)
    assert shown(pictures, len(film.episodes)) == [None] * len(film.episodes)


def test_no_recording_has_a_module_imported(
    seen: SeenInputs, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recording may come from anybody: one that names a module starts no process at all."""

    def refuse(*_: object) -> None:
        raise AssertionError("a process was started")

    monkeypatch.setattr("study.shell.replay.camera.Worker", refuse)
    head = next(head for head, given in heads(seen.inputs) if isinstance(given, FleetObserved))
    with pytest.raises(AssertionError, match="was started"), closing(Camera()) as camera:
        camera.show(head.film, Pictures())
    toml = head.film.protocol_toml.replace("gymnasium:Frozen", "gymnasium:this:Frozen")
    named = dataclasses.replace(head.film.copy(), protocol_toml=toml)
    with closing(Camera()) as camera:
        camera.show(named, Pictures())


def test_a_film_waits_for_the_answer(seen: SeenInputs) -> None:
    """Between the question and the answer the film stands where the screen stands."""
    film, opened = Film(), 0
    for head, given in heads(seen.inputs):
        opened += isinstance(given, SessionOpened)
        if film.episodes and not isinstance(given, FleetObserved):
            assert head.film.number == film.number
        film = head.film.copy()
    assert opened == 1
    assert film.number == sum(isinstance(given, FleetObserved) for given in seen.inputs)
