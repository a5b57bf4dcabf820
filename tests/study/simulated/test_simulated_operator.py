"""The operator as a whole: what it sees, when it acts, and that it gets through."""

from __future__ import annotations

import dataclasses
import itertools
import time
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from simulated_world import NUMBER_KEYS, Row, World, idle_policy, random_policy
from study.screens import (
    Cue,
    EndScreen,
    FleetScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    Screen,
    SurveyItem,
    SurveyScreen,
    Tile,
    View,
    WaitScreen,
)
from study.simulated.keys import KeyStroke, number_key
from study.simulated.operator import SimulatedOperator
from study.simulated.parameters import OperatorParameters, draw_parameters

PARAMETERS = OperatorParameters()
DRIVING = {"up", "down", "left", "right"}


def run(
    allocation: str,
    parameters: OperatorParameters = PARAMETERS,
    *,
    timesteps: int = 240,
    seed: int = 0,
    robots: int = 12,
    view: View = "tiles",
) -> list[Row]:
    """Run a fleet of randomly acting robots under one operator."""
    world = World(robots, allocation, random_policy(seed), seed=seed, view=view)
    operator = SimulatedOperator(parameters, seed)
    return [world.step(operator) for _ in range(timesteps)]


def switches(rows: list[Row]) -> Iterator[tuple[int, Row]]:
    """Yield place and row of each timestep that first shows another operated robot."""
    for place, (before, after) in enumerate(itertools.pairwise(rows), start=1):
        if after.screen.operated != before.screen.operated:
            yield place, after


def held_after(rows: list[Row]) -> list[set[str]]:
    """Return the driving keys down after each timestep's strokes."""
    down: set[str] = set()
    history = []
    for row in rows:
        for stroke in row.strokes:
            (down.add if stroke.down else down.discard)(stroke.key)
        history.append(down & DRIVING)
    return history


@pytest.mark.parametrize("allocation", ["manual", "assisted"])
def test_the_same_seed_presses_the_same_keys(allocation: str) -> None:
    """Runs repeat to the key with the same seed, and differ with another."""
    first, second = run(allocation, seed=4), run(allocation, seed=4)
    assert [row.strokes for row in first] == [row.strokes for row in second]
    if allocation == "manual":
        other = run(allocation, seed=5)
        assert [row.strokes for row in first] != [row.strokes for row in other]


@given(seed=st.integers(0, 10_000), tiles=st.integers(1, 4))
@settings(max_examples=12)
def test_what_is_not_noticed_has_no_effect(seed: int, tiles: int) -> None:
    """Scrambling all tiles but those noticed changes no key: nothing unseen is acted upon."""
    parameters = PARAMETERS.model_copy(update={"glance_tiles": tiles})
    random = np.random.default_rng(seed)
    operator = SimulatedOperator(parameters, seed % 3)
    for row in run("manual", parameters, timesteps=120, seed=seed % 3):
        scrambled = tuple(
            tile if tile.robot in row.noticed else _scrambled(tile, random)
            for tile in row.screen.tiles
        )
        screen = dataclasses.replace(row.screen, tiles=scrambled)
        assert operator.act(screen, row.t_ns) == row.strokes
        assert operator.noticed == row.noticed


def _scrambled(tile: Tile, random: np.random.Generator) -> Tile:
    """Change everything of a tile but whether it shows a cue, which may draw a look."""
    return Tile(
        tile.robot,
        float(random.uniform(0, 20)),
        float(random.uniform(0, 15)),
        float(random.uniform(-3, 3)),
        float(random.uniform(0, 100)),
        tile.cue,
        int(random.integers(1, 9)),
    )


@given(st.integers(1, 5), st.integers(0, 20))
@settings(max_examples=10)
def test_glances_are_few_and_spaced(tiles: int, seed: int) -> None:
    """A timestep shows at most glance_tiles tiles beside one's own, at the glance period."""
    parameters = PARAMETERS.model_copy(update={"glance_tiles": tiles})
    rows = run("manual", parameters, timesteps=120, seed=seed)
    others = [len(set(row.noticed) - {row.screen.operated}) for row in rows]
    assert max(others) == tiles
    seconds = (rows[-1].t_ns - rows[0].t_ns) * 1e-9
    assert sum(count > 0 for count in others) <= seconds / (0.7 * parameters.glance_period_s) + 1


def test_hidden_robots_have_no_effect() -> None:
    """In the operated-only view the other robots' states change no key."""
    first = run("assisted", view="operated_only", timesteps=100)
    assert all(row.noticed == (row.screen.operated,) for row in first)
    assert all(len(row.screen.tiles) == 1 for row in first)
    operator = SimulatedOperator(PARAMETERS, 0)
    assert [operator.act(row.screen, row.t_ns) for row in first] == [row.strokes for row in first]


def test_a_warning_draws_a_look() -> None:
    """With full capture a robot that shows a warning is looked at in the next glance."""
    parameters = PARAMETERS.model_copy(
        update={"cue_capture": 1.0, "glance_lapse": 0.0, "glance_tiles": 1}
    )
    world = World(12, "manual", idle_policy)
    operator = SimulatedOperator(parameters, 0)
    glances = []
    for _ in range(60):
        world.cues[7] = Cue("low", 20.0, 0)
        glances.append(world.step(operator).noticed)
    looked = [others for noticed in glances if (others := set(noticed) - {world.operated})]
    assert looked
    assert all(7 in others for others in looked if world.operated != 7)


@pytest.mark.parametrize("allocation", ["manual", "assisted"])
def test_reorientation_follows_every_switch(allocation: str) -> None:
    """No driving key goes down for the reorientation delay after a switch, own or automatic."""
    rows = run(allocation, timesteps=400)
    held = held_after(rows)
    found = list(switches(rows))
    assert len(found) >= 5
    for place, row in found:
        until_ns = row.t_ns + PARAMETERS.reorientation_s * 1e9
        for later, keys in zip(rows[place:], held[place:], strict=True):
            assert later.t_ns >= until_ns or not keys


def test_reorientation_is_the_same_for_both() -> None:
    """The shortest wait from a switch to driving is equal for own and automatic switches."""
    waits = {}
    for allocation in ("manual", "assisted"):
        rows = run(allocation, timesteps=400)
        held = held_after(rows)
        waits[allocation] = min(
            next((k - place for k in range(place, len(rows)) if held[k]), len(rows))
            for place, _ in switches(rows)
        )
    assert waits["manual"] == waits["assisted"] == 7


def test_keys_are_let_go_at_an_automatic_switch() -> None:
    """A key held across an automatic switch is released as soon as the switch is seen."""
    rows = run("assisted", timesteps=400)
    held = held_after(rows)
    crossed = [place for place, _ in switches(rows) if held[place - 1]]
    assert crossed
    assert all(not held[place] for place in crossed)


def test_keys_are_let_go_before_an_own_switch() -> None:
    """A number is pressed with no driving key down, and none goes down in the same timestep."""
    rows = run("manual", timesteps=400)
    held = held_after(rows)
    for row, down in zip(rows, held, strict=True):
        if any(stroke.key in NUMBER_KEYS for stroke in row.strokes):
            assert not down
            assert row.strokes[-1].key in NUMBER_KEYS


def test_chooses_a_robot_at_once_and_goes_to_those_in_need() -> None:
    """A robot is chosen in the first two seconds; then stuck ones before those near the goal."""
    world = World(4, "manual", idle_policy)
    operator = SimulatedOperator(PARAMETERS, 1)
    rows = [world.step(operator) for _ in range(120)]
    assert rows[16].screen.operated >= 0
    assert len({row.screen.operated for row in rows}) >= 3


def test_correction_and_assistance_choose_nothing() -> None:
    """Number keys are pressed only where the choice is the operator's."""
    for allocation, robots in (("assisted", 12), ("correction", 1)):
        rows = run(allocation, timesteps=100, robots=robots)
        keys = {stroke.key for row in rows for stroke in row.strokes}
        assert keys <= DRIVING
        assert keys


def test_nobody_is_driven_where_nobody_operates() -> None:
    """With allocation none no key is pressed."""
    assert not any(row.strokes for row in run("none", timesteps=30))


def test_many_robots_are_reached_by_typed_numbers() -> None:
    """Beyond twelve robots the operator types two digits, reaches them all, and still drives."""
    rows = run("manual", robots=14, timesteps=400, seed=2)
    assert number_key(12) is None
    strokes = [stroke.key for row in rows for stroke in row.strokes if stroke.down]
    assert "tab" not in strokes
    assert any(row.screen.operated >= 12 for row in rows)
    assert sum(row.action >= 0 for row in rows) > 100


def test_a_choice_that_does_nothing_is_given_up() -> None:
    """If no number works the operator tries others and does not hang."""
    world = World(4, "manual", idle_policy)
    operator = SimulatedOperator(PARAMETERS, 1)
    pressed = set()
    for k in range(200):
        world.operated = -1
        row = world.step(operator)
        pressed |= {stroke.key for stroke in row.strokes}
        assert k == row.screen.timestep
    assert pressed == {"1", "2", "3", "4"}


def test_a_suggestion_is_accepted_by_space() -> None:
    """Where a robot is suggested the operator can take it with the space bar."""
    world = World(4, "suggested", idle_policy)
    operator = SimulatedOperator(PARAMETERS.model_copy(update={"suggestion_trust": 5.0}), 1)
    keys = [
        stroke.key
        for _ in range(60)
        for stroke in world.step(operator, _suggesting_third).strokes
        if stroke.down and stroke.key not in DRIVING
    ]
    assert keys[0] == "space"


def _suggesting_third(screen: FleetScreen) -> FleetScreen:
    return dataclasses.replace(screen, suggested=2)


def survey(
    values: tuple[int | None, int | None], focus: int, low: int = 1, high: int = 7
) -> SurveyScreen:
    """Make a survey of two questions."""
    texts = (
        "It was easy to guide the robots to their goals",
        "I was successful at guiding the robots",
    )
    return SurveyScreen(
        header_left="Block 1 of 2: finished",
        header_right="",
        title="Two questions",
        prompt="How much do you agree?",
        items=tuple(
            SurveyItem(f"q{k + 1}", text, low, high, (), value)
            for k, (text, value) in enumerate(zip(texts, values, strict=True))
        ),
        focus=focus,
        complete=None not in values,
        reminder="",
    )


def until_keys(operator: SimulatedOperator, screen: Screen, now_ns: int) -> tuple[str, int]:
    """Show one screen every 100 ms until a key is pressed; return the key and the time."""
    for k in range(3000):
        strokes = operator.act(screen, now_ns + k * 100_000_000)
        if strokes:
            assert [stroke.down for stroke in strokes] == [True, False]
            return strokes[0].key, now_ns + (k + 1) * 100_000_000
    raise AssertionError(f"no key at {screen}")


def page(title: str, words: int = 20) -> PageScreen:
    """Make a page of so many words."""
    return PageScreen(
        "", title, title, "", ("word " * words,), "", None, (), 8.0, 12, True, "", "to go on"
    )


def reveal(total: float) -> RevealScreen:
    """Make a reveal of eight trials."""
    return RevealScreen("Block 1 of 2", "", 1, total, (total / 8,) * 8, 12, 0.0, 300.0, "")


@given(seed=st.integers(0, 1000), low=st.integers(0, 2), span=st.integers(2, 7))
@settings(max_examples=40)
def test_surveys_are_answered_within_their_scale(seed: int, low: int, span: int) -> None:
    """Both questions get a digit of the scale, then the survey is confirmed."""
    operator = SimulatedOperator(draw_parameters(0, seed), seed)
    now_ns = 0
    answers: list[int | None] = [None, None]
    for item in range(2):
        key, now_ns = until_keys(
            operator, survey((answers[0], answers[1]), item, low, low + span), now_ns
        )
        assert low <= int(key) <= low + span
        answers[item] = int(key)
    key, now_ns = until_keys(operator, survey((answers[0], answers[1]), 2, low, low + span), now_ns)
    assert key == "return"


@pytest.mark.parametrize(("high", "digits"), [(100, 2), (50, 2), (10, 1)])
def test_on_a_long_scale_the_number_is_typed(high: int, digits: int) -> None:
    """All digits of it at once, then on to the next question."""
    operator = SimulatedOperator(PARAMETERS.model_copy(update={"response_noise": 0.0}), 0)
    screen, now_ns = survey((None, None), 1, 0, high), 0
    strokes: tuple[KeyStroke, ...] = ()
    while not strokes:
        now_ns += 100_000_000
        strokes = operator.act(screen, now_ns)
    pressed = [stroke.key for stroke in strokes if stroke.down]
    assert pressed[-1] == "tab"
    assert len(pressed[:-1]) == digits
    # Without experience the answer is the middle.
    assert int("".join(pressed[:-1])) == high // 2


def test_an_open_question_is_gone_to() -> None:
    """With the focus past an open question the operator moves it by Tab."""
    operator = SimulatedOperator(PARAMETERS, 0)
    assert until_keys(operator, survey((None, 3), 2), 0)[0] == "tab"
    assert until_keys(operator, survey((None, 3), 1), 10**10)[0] == "tab"


def answers_after(screens: list[Screen], seed: int) -> int:
    """Return the answer to the question on success after these screens."""
    parameters = PARAMETERS.model_copy(update={"response_noise": 0.0})
    operator = SimulatedOperator(parameters, seed)
    now_ns = 0
    for screen in screens:
        _, now_ns = until_keys(operator, screen, now_ns)
    return int(until_keys(operator, survey((4, None), 1), now_ns)[0])


def test_success_follows_the_points_shown() -> None:
    """More points revealed, a higher answer; without any experience the middle."""
    ratings = [answers_after([reveal(total)], 0) for total in (0.0, 800.0, 1600.0, 2400.0)]
    assert ratings == sorted(ratings)
    assert ratings[0] < 3
    assert ratings[-1] > 5
    assert answers_after([], 0) == 4


def test_screens_to_read_are_left_by_enter() -> None:
    """Pages, the reveal, a pause and the end each lead on; a page takes its reading time."""
    operator = SimulatedOperator(PARAMETERS, 0)
    now_ns = 0
    screens: list[Screen] = [
        page("One"),
        page("Two", 200),
        reveal(100.0),
        PauseScreen("operator", confirm_stop=False),
        PauseScreen("operator", confirm_stop=True),
        EndScreen("Thanks", ""),
    ]
    took = []
    for screen in screens:
        before = now_ns
        key, now_ns = until_keys(operator, screen, now_ns)
        took.append((now_ns - before) * 1e-9)
        assert key == "return"
    assert took[1] == pytest.approx(201 / PARAMETERS.words_per_second, abs=0.5)
    assert min(took) >= PARAMETERS.page_minimum_s


def test_a_key_that_did_nothing_is_pressed_again() -> None:
    """A screen that stays is answered again after a while."""
    operator = SimulatedOperator(PARAMETERS, 0)
    _, now_ns = until_keys(operator, page("One"), 0)
    _, later_ns = until_keys(operator, page("One"), now_ns)
    assert 0.5 < (later_ns - now_ns) * 1e-9 < 3.0


def test_waiting_needs_no_key_and_lets_go() -> None:
    """Driving keys are released when the fleet is gone; a wait is waited out."""
    rows = run("assisted", timesteps=12)
    operator = SimulatedOperator(PARAMETERS, 0)
    for row in rows:
        operator.act(row.screen, row.t_ns)
    down = held_after(rows)[-1]
    assert down
    released = operator.act(WaitScreen("Fitting", "", 0.5), rows[-1].t_ns + 1)
    assert released == tuple(KeyStroke(key, down=False) for key in down)
    assert not any(
        operator.act(WaitScreen("Fitting", "", 0.5), rows[-1].t_ns + k * 10**8)
        for k in range(1, 100)
    )


def test_a_screen_shown_twice_is_acted_on_once() -> None:
    """The same timestep shown again changes nothing."""
    rows = run("manual", timesteps=60)
    operator = SimulatedOperator(PARAMETERS, 0)
    for row in rows:
        assert operator.act(row.screen, row.t_ns) == row.strokes
        assert operator.act(row.screen, row.t_ns + 1) == ()


def test_acting_is_quick() -> None:
    """A timestep with twelve tiles costs well under 0.3 ms (about 0.05 ms on a quiet core)."""
    screens: list[tuple[FleetScreen, int]] = [(row.screen, row.t_ns) for row in run("manual")]
    costs = []
    for _ in range(3):
        operator = SimulatedOperator(PARAMETERS, 0)
        operator.act(*screens[0])
        started = time.process_time()
        for screen, t_ns in screens[1:]:
            operator.act(screen, t_ns)
        costs.append((time.process_time() - started) / (len(screens) - 1))
    assert min(costs) < 300e-6
