"""What makes one simulated operator differ from another, with units and plausibility."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from study.errors import StudyError, UnknownNameError
from study.seeding import generator
from study.validation import validation_problems

Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
Driver = Literal["planner", "trained_user"]
NonNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


class OperatorParameters(BaseModel):
    """Parameters of a simulated operator, recorded with everything made from it.

    The defaults describe the middle of the population that `draw_parameters` draws from.
    They are plausible magnitudes, not estimates from data.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    # Motor knowledge and driving
    driver: Driver = Field(
        "planner",
        description="who drives: a crude person's plan over the map, or the synthetic user trained "
        "on the task; choosing, noticing and rating are the same.",
    )
    forward_step_m: Positive = Field(
        0.5, description="m a timestep; learned in practice by watching one's own robot."
    )
    turn_step_deg: Positive = Field(
        15.0, description="degrees a timestep; learned in practice like the forward step."
    )
    look_ahead_m: Positive = Field(
        0.75, description="m along the way at which one aims; one or two steps, as drivers do."
    )
    heading_tolerance: Positive = Field(
        0.6, description="turn steps of heading error left uncorrected; half a step is the least."
    )
    hazard_cost: NonNegative = Field(
        4.0, description="extra m that a m of hazard is worth avoiding; hazards are salient."
    )
    clearance_m: NonNegative = Field(
        1.0, description="m kept from walls and hazards where there is room; two steps."
    )
    steering_lapse: Fraction = Field(
        0.03, description="chance a timestep that the last key stays down; keys are held too long."
    )
    back_out_deg: Positive = Field(
        110.0,
        description="degrees of turn beyond which one reverses out of a hazard; turning costs.",
    )
    pack_health: NonNegative = Field(
        60.0, description="health points below which a near pack is fetched; the bar looks half."
    )
    pack_distance_m: NonNegative = Field(
        4.0, description="m that one goes for a pack; about the length of a room."
    )

    # Correcting a robot that drives itself
    correction_threshold: Positive = Field(
        1.5,
        description="steps of progress missed before one intervenes; half a step is charged a "
        "timestep, so 1.5 is three timesteps of standing still.",
    )
    correction_hold_s: NonNegative = Field(
        1.5, description="s of driving before one tries to let go; a person finishes a manoeuvre."
    )

    # Attention
    glance_tiles: Annotated[int, Field(ge=1, le=12)] = Field(
        2, description="tiles noticed in a glance besides one's own; of the order of 2 to 3."
    )
    glance_period_s: Positive = Field(
        0.5, description="s from glance to glance; one or two fixations beside driving."
    )
    glance_lapse: Fraction = Field(
        0.1, description="chance that a glance notices nothing; attention stays with driving."
    )
    cue_capture: Fraction = Field(
        0.3, description="chance that a look goes to a tile with a warning; onsets attract."
    )
    memory_span_s: Positive = Field(
        8.0, description="s until confidence in what was seen is 1/e; a few scans of the fleet."
    )

    # Judging need and choosing
    weight_hazard: NonNegative = Field(
        0.5, description="need (1 = urgent) of a robot in a hazard; costs are immediate."
    )
    weight_stuck: NonNegative = Field(
        0.6, description="need of a robot that gets nowhere; nobody else will free it."
    )
    weight_health: NonNegative = Field(
        0.15, description="need of a robot with no health left; its bar is always in the tile."
    )
    weight_far: NonNegative = Field(
        0.1, description="need of a robot as far from the goal as can be; there is more to gain."
    )
    stuck_patience_s: Positive = Field(
        4.0,
        description="s without progress that make a robot wholly stuck; as the cue does in 5 s.",
    )
    unknown_need: NonNegative = Field(
        0.1, description="need assumed of a robot not seen or forgotten; most robots are fine."
    )
    switching_cost: NonNegative = Field(
        0.2, description="need by which another robot must exceed one's own; switching takes 1 s."
    )
    temperature: Positive = Field(
        0.04, description="need; noise of the Luce choice, small beside the differences that count."
    )
    suggestion_trust: NonNegative = Field(
        0.2, description="need added to a suggested robot; about one switching cost."
    )
    help_distance_m: Positive = Field(
        4.0, description="m of progress that see a robot past its trouble; about half a room."
    )
    motor_delay_s: NonNegative = Field(
        0.35, description="s from deciding to pressing a number; finding a key among twelve."
    )
    reorientation_s: NonNegative = Field(
        0.8, description="s before driving after any switch, own or automatic; task-switch cost."
    )

    # Reading and rating
    words_per_second: Positive = Field(
        4.0, description="words/s; 240 words a minute is ordinary silent reading."
    )
    page_minimum_s: NonNegative = Field(1.2, description="s spent on any page; to see it is new.")
    answer_delay_s: NonNegative = Field(
        1.5, description="s from reading a question to its key; short survey answers take 1-3 s."
    )
    ease_level: float = Field(
        6.0, description="scale points; rating of ease when nothing had to be attended to."
    )
    ease_switch_cost: NonNegative = Field(
        0.04, description="scale points lost for each own choice a minute; 25 a minute cost one."
    )
    ease_unmet_cost: NonNegative = Field(
        2.0, description="scale points lost if every look met a robot left in need; a third of it."
    )
    ease_waiting_cost: NonNegative = Field(
        3.0,
        description="scale points lost if all time went into reorienting; a third costs one.",
    )
    success_gain: NonNegative = Field(
        6.0, description="scale points from the worst to the best that can be achieved; the scale."
    )
    aspiration: Fraction = Field(
        0.4, description="fraction of the revealed scale that feels neutral; just under its middle."
    )
    response_shift: float = Field(
        0.0, description="scale points added to every answer; acquiescence is a stable style."
    )
    response_noise: NonNegative = Field(
        0.5,
        description="scale points, standard deviation; single items retest no better.",
    )


def stated_parameters(texts: Sequence[str]) -> dict[str, float]:
    """Read parameters that all simulated participants are to have: each text NAME=VALUE.

    Raises:
        StudyError: no such parameter, no number, or not a possible value.
    """
    known = [name for name in OperatorParameters.model_fields if name != "driver"]
    found: dict[str, float] = {}
    for text in texts:
        name, _, number = (part.strip() for part in text.partition("="))
        if name not in known:
            raise UnknownNameError("parameter", name, known)
        try:
            found[name] = float(number)
            if not math.isfinite(found[name]):
                raise ValueError(number)
            OperatorParameters.model_validate({name: found[name]})
        except ValidationError as error:
            problem = next(validation_problems(error.errors(), OperatorParameters))
            raise StudyError(
                f"--set {problem}", "See docs/explanation/simulated-participants.md."
            ) from error
        except ValueError as error:
            raise StudyError(
                f"--set {text}: {number!r} is no number",
                "Write NAME=VALUE, such as glance_tiles=3.",
            ) from error
    return found


def draw_parameters(
    study_seed: int,
    participant_index: int,
    driver: Driver = "planner",
    stated: Mapping[str, float] | None = None,
) -> OperatorParameters:
    """Draw one participant of the simulated population.

    Times and costs vary log-normally by 15 to 35 %; styles of rating vary normally. What
    is learned about the robot in practice does not vary.

    Args:
        study_seed: seed of the whole simulated study.
        participant_index: number of the participant, from 0.
        driver: who drives; nothing else that is drawn depends on it.
        stated: parameters that are not drawn but the same for all; the others are drawn as ever.

    Returns:
        The parameters; the same for the same arguments.
    """
    random = generator(study_seed, "operator_parameters", participant_index)
    middle = OperatorParameters()
    spreads = {
        "hazard_cost": 0.2,
        "pack_health": 0.15,
        "pack_distance_m": 0.25,
        "correction_threshold": 0.2,
        "correction_hold_s": 0.2,
        "glance_period_s": 0.15,
        "memory_span_s": 0.3,
        "weight_hazard": 0.25,
        "weight_stuck": 0.25,
        "weight_health": 0.35,
        "weight_far": 0.35,
        "stuck_patience_s": 0.25,
        "switching_cost": 0.25,
        "temperature": 0.25,
        "help_distance_m": 0.25,
        "motor_delay_s": 0.2,
        "reorientation_s": 0.2,
        "words_per_second": 0.2,
        "answer_delay_s": 0.3,
    }
    drawn: dict[str, float] = {
        name: round(getattr(middle, name) * math.exp(spread * random.standard_normal()), 4)
        for name, spread in spreads.items()
    }
    drawn["steering_lapse"] = round(float(random.uniform(0.01, 0.05)), 4)
    drawn["glance_lapse"] = round(float(random.uniform(0.05, 0.2)), 4)
    drawn["cue_capture"] = round(float(random.uniform(0.15, 0.45)), 4)
    drawn["aspiration"] = round(min(0.8, max(0.2, 0.4 + 0.08 * random.standard_normal())), 4)
    drawn["ease_level"] = round(6.0 + 0.4 * float(random.standard_normal()), 4)
    drawn["response_shift"] = round(0.4 * float(random.standard_normal()), 4)
    glance_tiles = 1 + int(random.choice(3, p=[0.2, 0.6, 0.2]))
    settled = {**drawn, "glance_tiles": glance_tiles, "driver": driver, **(stated or {})}
    return OperatorParameters.model_validate(settled)
