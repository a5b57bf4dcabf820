"""A scorer's gate, its warm start and the correction round, as the session lives them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import Phase as Steps
from hypothesis import given, settings
from hypothesis import strategies as st

from event_books import check_books
from fake_shell import FakeShell, Moods, replayed
from short_study import opened, short_study
from study.errors import ProtocolError
from study.events.codes import ActionSource, ChoiceSource, Phase
from study.events.events import (
    Deviation,
    FitApplied,
    FitRequested,
    SessionEnded,
    StageEntered,
    Timestep,
    TrialStarted,
)
from study.events.fit_events import FitGateJudged, PreparationRequested, WarmStarted
from study.loading import LoadedProtocol
from study.screens import FleetScreen, PageScreen
from study.session.effects import RequestFit
from study.training_sets import choice_sets

LUCE = "[scorers.luce.parameters]"
TWO = "robots = 3\ntrials = 2\ntrial_timesteps = 6"
ROUND = """
[correction_round]
scorer = "luce"
robots = 5
offered = 2
trials = 2
trial_timesteps = 8
dwell = 2
offer_timesteps = 3
"""
GOOD = {
    "held_out_log_likelihood_per_choice": -0.8,
    "held_out_chance_log_likelihood": -1.1,
    "held_out_top1": 0.6,
    "held_out_chance_top1": 0.333,
    "held_out_calibration_error": 0.05,
}
BAD = {**GOOD, "held_out_log_likelihood_per_choice": -1.3}


def study(gate: str = "", *, round_: bool = False, more: tuple[tuple[str, str], ...] = ()) -> Any:
    """Load the short study with three trials of phase two, a gate and a correction round."""
    changes = [(TWO, TWO.replace("trials = 2", "trials = 3")), *more]
    if gate:
        changes.append((LUCE, f"[scorers.luce.gate]\n{gate}\n\n{LUCE}"))
    if round_:
        changes.append(("[phase_three]", f"{ROUND}\n[phase_three]"))
    return short_study(*changes)


def session(loaded: LoadedProtocol, moods: Moods | None = None, seed: int = 3) -> FakeShell:
    """Run a whole session in which the participant chooses a robot wherever there is a choice."""
    shell = FakeShell(opened(loaded), seed, moods or Moods(measures=GOOD))
    choose_until(shell, lambda: shell.finished)
    return shell


def choose_until(shell: FakeShell, reached: Callable[[], bool]) -> None:
    """Go on until something holds, choosing a robot wherever there is a choice."""
    for _ in range(4_000):
        if reached():
            return
        screen = shell.screen
        if isinstance(screen, FleetScreen) and screen.robot_keys and screen.operated < 0:
            shell.tap(screen.robot_keys[screen.tiles[0].robot])
        shell.help()
    raise AssertionError("not reached")


def all_of(shell: FakeShell, kind: type[Any]) -> list[Any]:
    """Return the events of a kind."""
    return [event for event in shell.events if isinstance(event, kind)]


def codes(shell: FakeShell) -> list[str]:
    """Return the codes of the deviations."""
    return [event.code for event in all_of(shell, Deviation)]


# Warm start


def test_a_fit_goes_on_from_what_was_prepared_before_the_last_trial() -> None:
    """The background's request comes before the last trial; the fit gets its answer, exactly."""
    shell = session(study())
    (prepared, _) = all_of(shell, PreparationRequested)
    last = [e for e in all_of(shell, TrialStarted) if e.phase == Phase.TWO][-1]
    assert shell.events.index(prepared) < shell.events.index(last)
    fits = [e for e in shell.effects if isinstance(e, RequestFit) and e.kind == "scorer"]
    background = next(e for e in fits if e.request_id == prepared.request_id)
    final = next(e for e in fits if not e.background)
    assert background.background
    assert background.start == b""
    assert (final.start != b"", final.seed) == (True, background.seed)
    assert set(background.arrays["trials"]) < set(final.arrays["trials"])
    warm = next(e for e in all_of(shell, WarmStarted) if e.request_id == final.request_id)
    assert warm.from_request_id == prepared.request_id
    # What was made in the background is in force nowhere.
    applied = {e.request_id for e in all_of(shell, FitApplied)}
    assert not applied & {e.request_id for e in all_of(shell, PreparationRequested)}
    assert replayed(shell.inputs) == shell.log


@pytest.mark.parametrize("fits", [("failed",), ("timed out",)])
def test_a_preparation_that_fails_is_no_loss(fits: tuple[str, ...]) -> None:
    """The fit after it starts from nothing, and only that fit's own failure is a deviation."""
    loaded = study()
    shell = FakeShell(opened(loaded), 3, Moods(measures=GOOD))
    choose_until(shell, lambda: bool(all_of(shell, PreparationRequested)))
    while shell.fit and shell.fit.background:
        shell.answer_fit(fits[0])
    choose_until(shell, lambda: shell.finished)
    assert codes(shell) == []
    assert all_of(shell, WarmStarted) == []


def test_a_scorer_need_not_be_warm() -> None:
    """Where the protocol says no, nothing is fitted in the background."""
    cold = (('[scorers.luce]\nname = "luce"', '[scorers.luce]\nname = "luce"\nwarm_start = false'),)
    shell = session(study(more=cold))
    assert [e.artefact_id for e in all_of(shell, PreparationRequested)] == ["scorer:classifier"]


def test_rules_before_knew_no_preparation() -> None:
    """A session opened under version 1 has the stages and fits that it had."""
    first = dataclasses.replace(opened(study()), rules=1)
    shell = FakeShell(first, 3)
    shell.go_on_until(lambda: shell.finished)
    assert all_of(shell, PreparationRequested) == []
    assert "preparation" not in {e.kind for e in all_of(shell, StageEntered)}
    assert replayed(shell.inputs) == shell.log


# Gate


def phase_three(shell: FakeShell, condition: str = "assisted") -> TrialStarted:
    """Return a trial of a condition of phase three as it was run."""
    started = all_of(shell, TrialStarted)
    found: TrialStarted = next(
        e for e in started if (e.phase, e.condition) == (Phase.THREE, condition)
    )
    return found


def test_a_good_fit_passes() -> None:
    """What was measured and asked for is recorded; nothing deviates."""
    shell = session(study("min_likelihood_gain = 0.1\nmin_top1_gain = 0.2\nattempts = 2"))
    (judged,) = all_of(shell, FitGateJudged)
    assert (judged.passed, judged.decision, judged.reason) == (True, "use", "")
    assert judged.likelihood_gain == pytest.approx(0.3)
    assert judged.top1_gain == pytest.approx(0.267)
    assert codes(shell) == []
    assert phase_three(shell).allocation == "assisted"
    assert len([e for e in all_of(shell, TrialStarted) if e.phase == Phase.TWO]) == 3


@pytest.mark.parametrize(
    ("threshold", "word"),
    [
        ("min_likelihood_gain = 0.31", "log-likelihood"),
        ("min_top1_gain = 0.3", "top-1"),
        ("max_calibration_error = 0.04", "calibration"),
    ],
)
def test_each_threshold_counts(threshold: str, word: str) -> None:
    """A fit that misses one of them does not pass, and the reason names it alone."""
    shell = session(study(threshold))
    (judged,) = all_of(shell, FitGateJudged)
    assert not judged.passed
    assert word in judged.reason
    assert ";" not in judged.reason
    assert codes(shell) == ["fit_gate_failed"]
    # "go_on": it is used as it is.
    assert phase_three(shell).scorer_id == "scorer:luce"


def test_without_a_held_out_trial_the_gate_is_not_passed() -> None:
    """What was not measured reaches no threshold, even the lowest."""
    shell = session(study("min_likelihood_gain = -1000.0"), Moods())
    (judged,) = all_of(shell, FitGateJudged)
    assert not judged.passed
    assert math.isnan(judged.likelihood_gain)
    assert "nothing was held out" in judged.reason


def test_falling_back_to_the_participant() -> None:
    """The block is run and explained as one in which the participant chooses, and says so."""
    loaded = study('on_failure = "fallback"')
    shell = session(loaded, Moods(measures=BAD))
    started = phase_three(shell)
    assert (started.allocation, started.view, started.dwell) == ("manual", "tiles", 0)
    assert started.scorer_id == ""
    (told,) = all_of(shell, Deviation)
    assert told.text.endswith("fallback to manual")
    pages = [e.screen for e in shell.effects if hasattr(e, "screen")]
    titles = {page.title for page in pages if isinstance(page, PageScreen)}
    assert not any("switched" in title for title in titles)


def test_falling_back_to_another_scorer() -> None:
    """The other scorer switches; where it could not be fitted, the participant chooses."""
    gate = 'on_failure = "fallback"\nfallback = "classifier"'
    shell = session(study(gate), Moods(measures=BAD))
    assert phase_three(shell).scorer_id == "scorer:classifier"
    shell = FakeShell(opened(study(gate)), 3, Moods(measures=BAD))

    def at_classifier() -> bool:
        waits = shell.fit
        return bool(waits and waits.algorithm == "classifier" and not waits.background)

    shell.go_on_until(at_classifier)
    shell.answer_fit("failed")
    shell.go_on_until(lambda: shell.finished)
    assert phase_three(shell).allocation == "manual"


@pytest.mark.parametrize("end", ["failed", "timed out"])
def test_a_failed_fit_fails_the_gate(end: str) -> None:
    """A fit without weights is treated as the protocol says, and its own reason stays recorded."""
    loaded = study('on_failure = "fallback"')
    shell = session(loaded, Moods(fits=(end,)))
    assert phase_three(shell).allocation == "manual"
    (judged,) = all_of(shell, FitGateJudged)
    assert "fit" in judged.reason
    assert set(codes(shell)) > {"fit_gate_failed"}


def test_repeating_until_it_passes() -> None:
    """Further trials of phase two and further fits come only while the gate asks for them."""
    loaded = study("attempts = 3\nrepeat_trials = 2")
    shell = FakeShell(opened(loaded), 3, Moods(measures=BAD))
    shell.go_on_until(lambda: len(all_of(shell, FitGateJudged)) == 1)
    shell.moods = Moods(measures=GOOD)
    shell.go_on_until(lambda: shell.finished)
    assert [e.decision for e in all_of(shell, FitGateJudged)] == ["repeat", "use"]
    two = [e for e in all_of(shell, TrialStarted) if e.phase == Phase.TWO]
    assert [e.trial for e in two] == [1, 2, 3, 4, 5]
    assert len({e.states.tobytes() for e in two}) == 5
    fits = [e.artefact_id for e in all_of(shell, FitRequested) if e.kind == "scorer"]
    assert fits == ["scorer:luce", "scorer:classifier"] * 2
    assert codes(shell) == ["fit_gate_failed"]
    assert replayed(shell.inputs) == shell.log


def test_ending_where_it_never_passes() -> None:
    """After the last attempt the session ends, and says why."""
    shell = session(study('attempts = 2\nrepeat_trials = 1\non_failure = "end"'), Moods())
    last = shell.events[-1]
    assert isinstance(last, SessionEnded)
    assert not last.complete
    assert "gate" in last.reason
    assert [e.decision for e in all_of(shell, FitGateJudged)] == ["repeat", "end"]


@pytest.mark.parametrize(
    ("gate", "word"),
    [
        ('fallback = "luce"', "another scorer"),
        ('fallback = "clasifier"', "classifier"),
        ("attempts = 0", "attempts"),
        ("max_calibration_error = 2.0", "max_calibration_error"),
    ],
)
def test_a_gate_that_cannot_be_is_refused(gate: str, word: str) -> None:
    """The message names the key and what is allowed."""
    with pytest.raises(ProtocolError) as caught:
        study(gate)
    assert "gate" in str(caught.value)
    assert word in str(caught.value)


# Correction round


def test_the_scorer_leads_and_the_participant_chooses_among_those_offered() -> None:
    """Stretches take turns; choices are of robots offered, and both trials' enter the last fit."""
    shell = session(study(round_=True))
    ids = {e.trial_id for e in all_of(shell, TrialStarted) if e.allocation == "correction_round"}
    assert len(ids) == 2
    rows = [e for e in all_of(shell, Timestep) if e.trial_id in ids]
    sources = [row.choice_source for row in rows if row.trial_id == min(ids)]
    mine, its = int(ChoiceSource.OPERATOR), int(ChoiceSource.SCORER)
    assert sources[:7] == [its, its, mine, mine, mine, its, its]
    offers = [row for row in rows if row.choice_source == mine]
    assert {int(row.available.sum()) for row in offers} <= {1, 2}
    driven = [row for row in offers if row.operated >= 0]
    assert driven
    assert all((row.action_sources != ActionSource.INACTIVE).sum() > 2 for row in offers[:2])
    fits = [e for e in shell.effects if isinstance(e, RequestFit) and e.algorithm == "luce"]
    first, last = (e for e in fits if not e.background)
    assert first.arrays["states"].shape[1:] == last.arrays["states"].shape[1:] == (3, 4)
    assert set(last.arrays["trials"]) - set(first.arrays["trials"]) == ids
    of_round = np.isin(last.arrays["trials"], list(ids))
    assert (last.arrays["available"][of_round].sum(axis=1) <= 2).all()
    assert replayed(shell.inputs) == shell.log


def test_offers_differ_and_are_drawn_from_the_seed() -> None:
    """Each offer is drawn anew; another session's are others."""

    def offered(seed: int) -> list[tuple[int, ...]]:
        loaded = study(round_=True)
        shell = FakeShell(opened(loaded, seed=seed), 3, Moods(measures=GOOD, end_chance=0.0))
        found: list[tuple[int, ...]] = []
        while not shell.finished:
            screen = shell.screen
            if isinstance(screen, FleetScreen) and len(screen.tiles) == 2:
                robots = tuple(tile.robot for tile in screen.tiles)
                if not found or found[-1] != robots:
                    found.append(robots)
            shell.help()
        return found

    assert offered(1) == offered(1)
    assert len(set(offered(1))) > 1
    assert offered(1) != offered(2)


def test_without_its_scorer_there_is_no_round() -> None:
    """It is passed over, which is a deviation, and the session goes on."""
    shell = FakeShell(opened(study(round_=True)), 3, Moods(measures=GOOD))

    def waits() -> bool:
        return bool(shell.fit and shell.fit.kind == "scorer" and not shell.fit.background)

    choose_until(shell, waits)
    shell.answer_fit("failed")
    shell.go_on_until(lambda: shell.finished)
    assert codes(shell) == ["fit_failed", "correction_round_skipped"]
    assert not [e for e in all_of(shell, TrialStarted) if e.allocation == "correction_round"]
    assert phase_three(shell).scorer_id == "scorer:luce"


def test_offered_robots_take_the_places_of_a_small_fleet() -> None:
    """Of a larger fleet only what could be chosen is kept, with the chosen robot's own state."""
    shell = session(study(round_=True))
    rows = all_of(shell, Timestep)
    sets = choice_sets(rows, 3, 4, of_larger=True)
    usable = {(row.trial_id, row.timestep): row for row in rows if row.choice_source == 1}
    chosen = sets.states[np.arange(len(sets.chosen)), sets.chosen]
    known = {row.states[row.operated].tobytes() for row in usable.values() if row.operated >= 0}
    assert {state.tobytes() for state in chosen} <= known
    assert sets.available[np.arange(len(sets.chosen)), sets.chosen].all()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@settings(max_examples=25, phases=[Steps.explicit, Steps.generate], deadline=None)
@given(
    seed=st.integers(0, 2**31),
    fits=st.lists(st.sampled_from(["completed", "failed", "timed out"]), min_size=1, max_size=5),
    measures=st.sampled_from([GOOD, BAD, {}]),
    failure=st.sampled_from(["go_on", "fallback", "end"]),
    fallback=st.sampled_from(["manual", "classifier"]),
    attempts=st.integers(1, 3),
    taps=st.lists(st.tuples(st.integers(0, 12), st.sampled_from("12345 ")), max_size=40),
)
def test_gates_and_rounds_replay_byte_for_byte(
    seed: int,
    fits: list[str],
    measures: dict[str, float],
    failure: str,
    fallback: str,
    attempts: int,
    taps: list[tuple[int, str]],
) -> None:
    """Whatever fits bring and keys are pressed, the books agree and the inputs give the events."""
    gate = f'attempts = {attempts}\non_failure = "{failure}"\nfallback = "{fallback}"'
    loaded = study(gate, round_=True)
    shell = FakeShell(opened(loaded, seed=seed), seed, Moods(fits=tuple(fits), measures=measures))
    for helped, key in taps:
        for _ in range(helped):
            shell.help()
        if key == " ":
            shell.tap("tab")
        else:
            shell.tap(key)
    shell.go_on_until(lambda: shell.finished)
    check_books(shell.events, loaded.description.idle_action)
    assert replayed(shell.inputs) == shell.log
