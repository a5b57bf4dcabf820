"""What a protocol can set of the task jetbot."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import Field

from study.rules import Part

ACTIONS = ("forward", "backward", "turn left", "turn right", "idle")
FORWARD, BACKWARD, TURN_LEFT, TURN_RIGHT, IDLE = range(5)


class Parameters(Part):
    """Time in seconds, speeds in metres and radians a second."""

    timesteps_per_second: float = Field(
        8.0, ge=1, le=50, description="must be that of `timing.timesteps_per_second`"
    )
    episode_seconds: float = Field(60.0, gt=0, le=3600, description="length of an episode, s")
    forward: float = Field(0.25, gt=0, le=0.5, description="speed of `forward`, m/s")
    back: float = Field(0.15, gt=0, le=0.5, description="speed of `backward`, m/s")
    turn: float = Field(1.5, gt=0, le=4, description="turn rate of the turns, rad/s")
    motor_lag: float = Field(
        0.06, ge=0.005, le=0.5, description="time constant of the simulated motors, s"
    )
    noise: float = Field(
        0.05, ge=0, le=0.5, description="noise of each wheel at each timestep, part of its speed"
    )
    wheel_bias: float = Field(
        0.03, ge=0, le=0.3, description="how unlike an episode's wheels are, part of their speed"
    )
    cameras: bool = Field(
        default=False, description="whether tiles show the front cameras; else the arena from above"
    )
    link: str = Field(
        "",
        max_length=500,
        description="file that lists the robots, simulated or real, to be driven over the robot "
        "link; empty: simulated within the study",
    )
    lap: float = Field(1.0, ge=-1000, le=1000, description="points of a lap")

    def _lasts(self) -> Iterator[str]:
        if self.horizon < 1:
            yield "an episode must last one timestep at least"

    def _driven_on(self) -> Iterator[str]:
        if self.link and self.timesteps_per_second < 6:
            # A robot is driven on between two actions for 0.2 s only.
            yield "over the robot link there must be 6 timesteps a second at least"

    rules = (_lasts, _driven_on)

    @property
    def horizon(self) -> int:
        """Longest episode, timesteps."""
        return round(self.episode_seconds * self.timesteps_per_second)

    def velocity(self, action: int) -> tuple[float, float]:
        """Return forward speed (m/s) and turn rate (rad/s, counterclockwise) of an action."""
        return (
            (self.forward, 0.0),
            (-self.back, 0.0),
            (0.0, self.turn),
            (0.0, -self.turn),
            (0.0, 0.0),
        )[action]
