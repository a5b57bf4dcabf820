"""What a task in the rooms says of itself, whatever moves its robots."""

from __future__ import annotations

import math

from study.events.task_description import RewardTerm, StateField, TaskDescription
from study.layouts import named_layout
from study.tasks._navigation_dynamics import (
    ACTIONS,
    BACKWARD,
    FORWARD,
    IDLE,
    TURN_LEFT,
    TURN_RIGHT,
)
from study.tasks._navigation_parameters import FULL_HEALTH, Parameters


def described(name: str, version: int, settings: Parameters) -> TaskDescription:
    """Return the description of the task of that name."""
    layout = named_layout(settings.layout)
    points = settings.rewards
    return TaskDescription(
        name=name,
        version=version,
        state_fields=(
            StateField("x", "m", 0.0, layout.width),
            StateField("y", "m", 0.0, layout.height),
            StateField("heading", "rad", -math.pi, math.pi, circular=True),
            StateField("health", "points", 0.0, FULL_HEALTH),
        ),
        x_field=0,
        y_field=1,
        heading_field=2,
        health_field=3,
        action_names=ACTIONS,
        idle_action=IDLE,
        key_actions={"up": FORWARD, "down": BACKWARD, "left": TURN_LEFT, "right": TURN_RIGHT},
        horizon=settings.horizon,
        rewards=(
            RewardTerm("progress", points.progress, "each metre", "closer to the goal"),
            RewardTerm("goal", points.goal, "robot reaches", "the goal"),
            RewardTerm("health", points.health, "each health point", "gained or lost"),
            RewardTerm("lost", points.lost, "robot lost", "(health 0)"),
            RewardTerm("timestep", points.timestep, "each step", ""),
        ),
        scene=layout.scene(),
        map_grid=layout.map_grid(
            cell=0.5,
            headings=(0.0, math.pi / 2, math.pi, -math.pi / 2),
            healths=(25.0, 50.0, 75.0, 100.0),
        ),
        resimulable="exact",
    )
