"""What the stages of a session are planned as, one kind a class; see `study.session.sequence`."""

from __future__ import annotations

import dataclasses

from study.events.codes import Phase
from study.screens import View

PHASE_ONE_POLICY = "policy:phase_one"
UNIFORM_RANDOM = "uniform_random"


@dataclasses.dataclass(frozen=True, slots=True)
class Place:
    """Where in the study a stage stands.

    Attributes:
        phase: one of the paper's four; PRACTICE before them.
        block: number within the phase, from 1; 0 outside a block.
        condition: name, or empty.
    """

    phase: Phase
    block: int = 0
    condition: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class PagesPlan:
    """Pages to read; ``name`` picks the text. See `TrialPlan` for ``repeat`` and ``needs``."""

    name: str
    place: Place
    repeat: int = 0
    needs: str = ""


@dataclasses.dataclass(frozen=True, slots=True)
class TrialPlan:
    """One fleet run.

    Attributes:
        trial, trials: number within the block and length of the block.
        robots: n.
        timesteps: longest length.
        allocation: "correction", "manual", "correction_round", "suggested", "assisted" or "none".
        view: "tiles", "operated_only" or "enlarged".
        dwell: timesteps between automatic switches; 0 if none.
        policy_id: what drives.
        scorer_id: which scorer is computed; empty for none.
        ends_with_robot: whether the run is over when its (only) robot ends.
        starts_key: numbers that key the start states; equal keys give equal starts.
        scored: whether its reward counts.
        goals_needed: goals of the operated robot that end it; 0 for none.
        attempt, attempts: of a practice with a criterion, from 1.
        repeat: attempt of the fit that it comes before; passed over unless a fit gate asked for
            that attempt. 0 if it is always run.
        needs: artefact without which it is passed over; empty for none.
    """

    place: Place
    trial: int
    trials: int
    robots: int
    timesteps: int
    allocation: str
    view: View
    dwell: int
    policy_id: str
    scorer_id: str
    ends_with_robot: bool
    starts_key: tuple[int, ...]
    scored: bool
    goals_needed: int = 0
    attempt: int = 1
    attempts: int = 1
    repeat: int = 0
    needs: str = ""

    name = "trial"


@dataclasses.dataclass(frozen=True, slots=True)
class FitPlan:
    """One fit.

    Attributes:
        artefact_id: name of the result.
        kind: "policy" or "scorer".
        member: which entry of the protocol: "policy" or a name under [scorers].
        sources: (phase, condition) pairs whose timesteps are used.
        attempt: which attempt the scorer's gate judges, from 1; 0 if it does not judge.
        repeat, needs: see `TrialPlan`.
        warm: whether it goes on from what was fitted before, if there is something.
    """

    place: Place
    artefact_id: str
    kind: str
    member: str
    sources: tuple[tuple[Phase, str], ...]
    attempt: int = 0
    repeat: int = 0
    needs: str = ""
    warm: bool = False

    name = "fit"


@dataclasses.dataclass(frozen=True, slots=True)
class PreparationPlan:
    """A fit in the background, from which a later one can go on; nobody waits for it.

    Attributes:
        artefact_id, member, sources: see `FitPlan`.
        repeat, needs: see `TrialPlan`.
    """

    place: Place
    artefact_id: str
    member: str
    sources: tuple[tuple[Phase, str], ...]
    repeat: int = 0
    needs: str = ""

    kind = "scorer"
    name = "preparation"


@dataclasses.dataclass(frozen=True, slots=True)
class SurveyPlan:
    """A questionnaire on one occasion."""

    place: Place
    questionnaire: str
    occasion: str

    name = "survey"


@dataclasses.dataclass(frozen=True, slots=True)
class RevealPlan:
    """The reward of the block just finished."""

    place: Place
    surveys_follow: bool

    name = "reveal"


@dataclasses.dataclass(frozen=True, slots=True)
class BreakPlan:
    """A rest."""

    place: Place

    name = "break"


@dataclasses.dataclass(frozen=True, slots=True)
class CheckPlan:
    """A comprehension check; later attempts are skipped once one was passed."""

    place: Place
    attempt: int

    name = "comprehension"


StagePlan = (
    PagesPlan
    | TrialPlan
    | FitPlan
    | PreparationPlan
    | SurveyPlan
    | RevealPlan
    | BreakPlan
    | CheckPlan
)


def policy_of(condition: str) -> str:
    """Return the artefact id of the policy retrained on a condition's demonstrations."""
    return f"policy:{condition}"


def scorer_of(name: str) -> str:
    """Return the artefact id of a fitted scorer."""
    return f"scorer:{name}"
