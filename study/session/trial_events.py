"""The events of a trial that only restate what is known."""

from __future__ import annotations

from study.events.events import EpisodeEnded, TrialStarted
from study.events.inputs import FleetObserved
from study.session.fleet_run import EndedEpisode
from study.session.plan import TrialPlan


def trial_started(
    first: FleetObserved, plan: TrialPlan, trial_id: int, policy_id: str, scorer_id: str
) -> TrialStarted:
    """Return the event that opens a trial.

    Args:
        first: the answer to StartFleet.
        plan: what was planned.
        trial_id: number of the fleet run.
        policy_id: what drives; not the planned one if its fit failed.
        scorer_id: what scores; empty if its fit failed.
    """
    return TrialStarted(
        t_ns=first.t_ns,
        trial_id=trial_id,
        phase=plan.place.phase,
        block=plan.place.block,
        condition=plan.place.condition,
        trial=plan.trial,
        robots=plan.robots,
        timesteps=plan.timesteps,
        allocation=plan.allocation,
        view=plan.view,
        dwell=plan.dwell,
        policy_id=policy_id,
        scorer_id=scorer_id,
        scored=plan.scored,
        states=first.states,
    )


def episode_ended(episode: EndedEpisode, t_ns: int, trial_id: int, timestep: int) -> EpisodeEnded:
    """Return the event of one episode's end."""
    return EpisodeEnded(
        t_ns=t_ns,
        trial_id=trial_id,
        robot=episode.robot,
        episode=episode.episode,
        timestep=timestep,
        length=episode.length,
        outcome=episode.outcome,
        episode_reward=episode.reward,
    )
