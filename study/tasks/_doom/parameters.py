"""What a protocol can set of the DOOM task: what navigation has, and what is the engine's."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from study.tasks import _navigation_parameters as navigation

FRAME_SIZES = ("160x120", "320x240", "640x480")


class Parameters(navigation.Parameters):
    """What a protocol can set of the task."""

    noise: float = Field(0.0, ge=0, le=0, description="the engine moves without noise: 0")
    motion: Literal["exact", "stock"] = Field(
        "exact",
        description='"exact": a robot goes its way and stops; "stock": with the engine\'s own '
        "friction it speeds up and coasts, and forward and back are its ways at full speed",
    )
    frame: Literal["160x120", "320x240", "640x480"] = Field(
        "160x120", description="size of a robot's picture, pixels"
    )
    frames: Literal["every_tic", "last"] = Field(
        "every_tic", description="pictures drawn: after each of the four tics, or the last only"
    )
    map: Literal["small", "none"] = Field(
        "small", description='in a corner of each picture: "small", the map from above; or "none"'
    )
    workers: int = Field(
        2, ge=1, le=64, description="processes that share the engines; as many as there are cores"
    )
    patience: float = Field(
        2.0,
        gt=0,
        le=60,
        description="seconds after which an engine that has not answered is replaced",
    )

    @property
    def frame_shape(self) -> tuple[int, int]:
        """Height and width of a picture, pixels."""
        width, height = map(int, self.frame.split("x"))
        return height, width
