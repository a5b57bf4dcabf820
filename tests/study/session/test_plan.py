"""The sequence of stages that the shipped protocols give."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from fake_shell import FakeShell, Moods
from short_study import opened, short_study
from study.events.codes import Phase
from study.events.events import FitRequested, QuestionAnswered, RewardRevealed, TrialStarted
from study.loading import load_protocol
from study.session.effects import StartFleet
from study.session.plan import (
    PHASE_ONE_POLICY,
    UNIFORM_RANDOM,
    FitPlan,
    PagesPlan,
    PreparationPlan,
    RevealPlan,
    StagePlan,
    SurveyPlan,
    TrialPlan,
)
from study.session.sequence import stage_plans

ORDERS = [("manual", "assisted"), ("assisted", "manual")]


def paper(order: tuple[str, ...] = ORDERS[0]) -> tuple[StagePlan, ...]:
    """Return the stages of the paper's study."""
    return stage_plans(load_protocol("scaled_autonomy").protocol, order)


def trials(
    plans: tuple[StagePlan, ...], phase: Phase, condition: str | None = None
) -> list[TrialPlan]:
    """Return the trials of a phase, or of one condition in it."""
    return [
        plan
        for plan in plans
        if isinstance(plan, TrialPlan)
        and plan.place.phase == phase
        and condition in (None, plan.place.condition)
    ]


def test_phase_one_is_ten_corrected_episodes_of_one_robot() -> None:
    """Ten episodes, the first from the uniform-random policy, refitted after each."""
    plans = paper()
    episodes = trials(plans, Phase.ONE)
    assert [plan.trial for plan in episodes] == list(range(1, 11))
    assert {(plan.robots, plan.allocation) for plan in episodes} == {(1, "correction")}
    assert [plan.policy_id for plan in episodes] == [UNIFORM_RANDOM] + [PHASE_ONE_POLICY] * 9
    after = [
        plans[place + 1]
        for place, plan in enumerate(plans)
        if isinstance(plan, TrialPlan) and plan.place.phase == Phase.ONE
    ]
    assert all(isinstance(plan, FitPlan) and plan.kind == "policy" for plan in after)


def test_phase_two_is_free_choice_among_four() -> None:
    """Four robots, manual choice, all tiles; then every scorer is fitted on that phase alone."""
    plans = paper()
    assert {(p.robots, p.allocation, p.view) for p in trials(plans, Phase.TWO)} == {
        (4, "manual", "tiles")
    }
    scorers = [plan for plan in plans if isinstance(plan, FitPlan) and plan.kind == "scorer"]
    assert [plan.member for plan in scorers] == ["luce", "classifier"]
    assert all(plan.sources == ((Phase.TWO, ""),) for plan in scorers)


@pytest.mark.parametrize("order", ORDERS)
def test_phase_three_runs_both_conditions_in_the_order_given(order: tuple[str, ...]) -> None:
    """Eight trials of twelve robots each; manual shows all, assisted one and dwells 15."""
    plans = paper(order)
    ran = [plan.place.condition for plan in trials(plans, Phase.THREE)]
    assert [name for name, _ in itertools.groupby(ran)] == list(order)
    for name, allocation, view, dwell, scorer in (
        ("manual", "manual", "tiles", 0, ""),
        ("assisted", "assisted", "operated_only", 15, "scorer:luce"),
    ):
        block = trials(plans, Phase.THREE, name)
        assert [plan.trial for plan in block] == list(range(1, 9))
        settings = {(p.robots, p.allocation, p.view, p.dwell, p.scorer_id) for p in block}
        assert settings == {(12, allocation, view, dwell, scorer)}
        assert {plan.place.block for plan in block} == {order.index(name) + 1}


def test_questions_are_asked_before_and_after_the_reveal() -> None:
    """After each block: questions, its points, the same questions."""
    plans = paper()
    for name in ("manual", "assisted"):
        last = max(
            place
            for place, plan in enumerate(plans)
            if isinstance(plan, TrialPlan)
            and plan.place.phase == Phase.THREE
            and plan.place.condition == name
        )
        before, reveal, after = plans[last + 1 : last + 4]
        assert isinstance(before, SurveyPlan)
        assert before.occasion == "before_reveal"
        assert isinstance(reveal, RevealPlan)
        assert isinstance(after, SurveyPlan)
        assert after.occasion == "after_reveal"
        assert {p.place.condition for p in (before, reveal, after)} == {name}
        assert before.questionnaire == after.questionnaire == "ease_and_success"


def test_policy_is_frozen_between_phase_one_and_four() -> None:
    """Phases two and three fit no policy and drive with phase one's last."""
    plans = paper()
    frozen = [p for p in plans if p.place.phase in (Phase.TWO, Phase.THREE)]
    assert not [p for p in frozen if isinstance(p, FitPlan) and p.kind == "policy"]
    assert {p.policy_id for p in frozen if isinstance(p, TrialPlan)} == {PHASE_ONE_POLICY}


def test_phase_four_evaluates_each_policy_on_the_same_starts() -> None:
    """One policy per condition on phase one plus its own demonstrations, and phase one's own."""
    plans = paper()
    fits = [p for p in plans if isinstance(p, FitPlan) and p.place.phase == Phase.FOUR]
    assert {plan.artefact_id: plan.sources for plan in fits} == {
        "policy:manual": ((Phase.ONE, ""), (Phase.THREE, "manual")),
        "policy:assisted": ((Phase.ONE, ""), (Phase.THREE, "assisted")),
    }
    evaluated = trials(plans, Phase.FOUR)
    starts = {
        policy: [p.starts_key for p in evaluated if p.policy_id == policy]
        for policy in (PHASE_ONE_POLICY, "policy:manual", "policy:assisted")
    }
    assert len(evaluated) == sum(map(len, starts.values()))
    assert starts[PHASE_ONE_POLICY] == starts["policy:manual"] == starts["policy:assisted"]
    settings = load_protocol("scaled_autonomy").protocol.phase_four
    assert settings is not None
    assert len(set(starts[PHASE_ONE_POLICY])) == settings.trials
    assert {p.allocation for p in evaluated} == {"none"}


def test_phase_four_on_phase_three_alone() -> None:
    """The other setting leaves phase one's demonstrations out."""
    loaded = short_study(('training = "phase_one_and_condition"', 'training = "phase_three_only"'))
    fits = [
        plan
        for plan in stage_plans(loaded.protocol, ORDERS[0])
        if isinstance(plan, FitPlan) and plan.place.phase == Phase.FOUR
    ]
    assert [plan.sources for plan in fits] == [
        ((Phase.THREE, "manual"),),
        ((Phase.THREE, "assisted"),),
    ]


def test_starts_are_distinct_but_for_pairs() -> None:
    """No two trials share starts, except the k-th of each condition, and phase four's policies."""
    plans = paper()
    keys = [p.starts_key for p in plans if isinstance(p, TrialPlan)]
    paired = [p.starts_key for p in trials(plans, Phase.THREE, "manual")]
    assert paired == [p.starts_key for p in trials(plans, Phase.THREE, "assisted")]
    four = {plan.starts_key for plan in trials(plans, Phase.FOUR)}
    assert len(set(keys)) == 1 + 10 + 6 + 8 + len(four)
    unpaired = short_study(("paired_starts = true", "paired_starts = false"))
    three = trials(stage_plans(unpaired.protocol, ORDERS[0]), Phase.THREE)
    assert len({plan.starts_key for plan in three}) == len(three)


@pytest.mark.parametrize("name", ["scaled_autonomy", "pilot", "smoke"])
def test_every_shipped_protocol_passes_every_kind_of_stage(name: str) -> None:
    """All four phases, pages, fits, surveys and reveals occur, and thanks stand last."""
    plans = stage_plans(load_protocol(name).protocol, ORDERS[1])
    kinds = {PagesPlan, TrialPlan, PreparationPlan, FitPlan, SurveyPlan, RevealPlan}
    assert {type(plan) for plan in plans} == kinds
    assert {plan.place.phase for plan in plans if isinstance(plan, TrialPlan)} == set(Phase)
    assert isinstance(plans[-1], PagesPlan)
    assert plans[-1].name == "thanks"


# The same, in what a session does


@pytest.fixture(scope="module")
def whole() -> FakeShell:
    """A whole session with two trials a block."""
    loaded = short_study(("trials = 1\ntrial_timesteps = 8", "trials = 2\ntrial_timesteps = 8"))
    shell = FakeShell(opened(loaded), 3, Moods(end_chance=0.1))
    shell.go_on_until(lambda: shell.finished)
    return shell


def starts(shell: FakeShell, phase: Phase, condition: str) -> list[StartFleet]:
    """Return the starts of the trials of a condition."""
    ids = [
        event.trial_id
        for event in shell.events
        if isinstance(event, TrialStarted) and (event.phase, event.condition) == (phase, condition)
    ]
    return [e for e in shell.effects if isinstance(e, StartFleet) and e.trial_id in ids]


def test_paired_trials_start_from_equal_seeds(whole: FakeShell) -> None:
    """The k-th trials of both conditions share start seeds and the policy's luck."""
    manual, assisted = (starts(whole, Phase.THREE, name) for name in ORDERS[0])
    assert len(manual) == len(assisted) == 2
    for left, right in zip(manual, assisted, strict=True):
        assert np.array_equal(left.seeds, right.seeds)
        assert left.policy_seed == right.policy_seed
        assert len(set(left.seeds.tolist())) == len(left.seeds)
    assert not np.array_equal(manual[0].seeds, manual[1].seeds)


def test_phase_four_starts_equal_seeds_for_all_policies(whole: FakeShell) -> None:
    """What differs between policies is the policy."""
    runs = [starts(whole, Phase.FOUR, name) for name in ("", *ORDERS[0])]
    assert [run[0].policy_id for run in runs] == [
        PHASE_ONE_POLICY,
        "policy:manual",
        "policy:assisted",
    ]
    assert len({run[0].seeds.tobytes() for run in runs}) == 1


def test_sessions_of_other_seeds_start_elsewhere(whole: FakeShell) -> None:
    """Start seeds come from the session's seed."""
    other = FakeShell(opened(short_study(), seed=8))
    other.go_to_trial(2)
    mine = starts(whole, Phase.TWO, "")[0]
    theirs = starts(other, Phase.TWO, "")[0]
    assert not set(mine.seeds.tolist()) & set(theirs.seeds.tolist())


def test_answers_and_reveals_stand_in_order(whole: FakeShell) -> None:
    """Each block: two answers before, its own points as the sum of its trials, two after."""
    told = [e for e in whole.events if isinstance(e, QuestionAnswered | RewardRevealed)]
    words = [
        (e.condition, "reveal" if isinstance(e, RewardRevealed) else f"{e.item} {e.occasion}")
        for e in told
    ]
    block = ["q1 before_reveal", "q2 before_reveal", "reveal", "q1 after_reveal", "q2 after_reveal"]
    assert words == [(name, word) for name in ORDERS[0] for word in block]


def test_fit_requests_count_their_rows(whole: FakeShell) -> None:
    """Every planned fit is requested once, with the number of its training rows."""
    planned = [p for p in stage_plans(short_study().protocol, ORDERS[0]) if isinstance(p, FitPlan)]
    requested = [event for event in whole.events if isinstance(event, FitRequested)]
    assert [r.artefact_id for r in requested] == [p.artefact_id for p in planned]
    assert all(len(r.data_sha256) == 64 for r in requested)
