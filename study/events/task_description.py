"""What a task says of itself, as plain values: recorded with every session."""

from __future__ import annotations

import dataclasses
import json
from typing import Any

from study.errors import RecordingError
from study.events.scene import DiscMark, GateMark, RectangleMark, Scene


@dataclasses.dataclass(frozen=True, slots=True)
class StateField:
    """One number of the observation.

    Attributes:
        name: its name, for example "heading".
        unit: "m", "rad", "points", ...
        low: smallest value.
        high: largest value.
        circular: whether high follows low again (an angle).
        bounded: whether the range holds; else it is what usual play reaches.
    """

    name: str
    unit: str
    low: float
    high: float
    circular: bool = False
    bounded: bool = True


@dataclasses.dataclass(frozen=True, slots=True)
class RewardTerm:
    """One line of the points rules, rendered in the instructions.

    Attributes:
        name: "progress", "health", "goal", "lost" or "timestep" (picks the picture).
        value: points.
        per: "each metre", "robot reaches", ...
        text: the second line: "closer to the goal", ...
    """

    name: str
    value: float
    per: str
    text: str


@dataclasses.dataclass(frozen=True, slots=True)
class MapGrid:
    """Where a scorer is evaluated for its heat map.

    Attributes:
        xs: centres of the columns, metres.
        ys: centres of the rows, metres, upwards.
        headings: headings evaluated, radians.
        healths: health levels evaluated, points; a single one where the task has no health.
        free: for each row a string of "1" (a robot can be there) and "0".
    """

    xs: tuple[float, ...]
    ys: tuple[float, ...]
    headings: tuple[float, ...]
    healths: tuple[float, ...]
    free: tuple[str, ...]


@dataclasses.dataclass(frozen=True, slots=True)
class TaskDescription:
    """Everything about a task that screens, fits and figures need.

    Attributes:
        name: the task's name in protocols.
        version: raised whenever dynamics or rewards change.
        state_fields: the observation's numbers, in order; d of them.
        x_field, y_field, heading_field, health_field: places of these in the state; -1 if none.
        action_names: names by action number.
        idle_action: the action that does nothing.
        key_actions: direction ("up", "down", "left", "right"), or the name of another key, to
            action number.
        horizon: longest episode, timesteps.
        rewards: the points rules.
        scene: the map.
        map_grid: heat-map grid, or None.
        resimulable: "exact" (same platform and lock), "tolerance" or "no".
        instruction: one sentence for participants on what is to be done; empty where the pages
            explain the map.
    """

    name: str
    version: int
    state_fields: tuple[StateField, ...]
    x_field: int
    y_field: int
    heading_field: int
    health_field: int
    action_names: tuple[str, ...]
    idle_action: int
    key_actions: dict[str, int]
    horizon: int
    rewards: tuple[RewardTerm, ...]
    scene: Scene
    map_grid: MapGrid | None
    resimulable: str
    instruction: str = ""

    def to_json(self) -> str:
        """Encode as JSON with sorted keys.

        What was added to the format later is left out where it says nothing, so that descriptions
        of earlier recordings stay the same to the byte.
        """
        raw = dataclasses.asdict(self)
        for part, name, usual in [
            (raw, "instruction", ""),
            (raw["scene"], "camera", False),
            (raw["scene"], "inset", False),
            (raw["scene"], "gates", ()),
            *((field, "bounded", True) for field in raw["state_fields"]),
        ]:
            if part[name] == usual:
                del part[name]
        return json.dumps(raw, sort_keys=True, allow_nan=False)

    @classmethod
    def from_json(cls, text: str) -> TaskDescription:
        """Decode what `to_json` wrote.

        Raises:
            RecordingError: the text is no task description.
        """
        try:
            raw: dict[str, Any] = json.loads(text)
            scene = raw["scene"]
            grid = raw["map_grid"]
            plate = scene["plate"]
            return cls(
                **{
                    **raw,
                    "state_fields": tuple(StateField(**item) for item in raw["state_fields"]),
                    "action_names": tuple(raw["action_names"]),
                    "rewards": tuple(RewardTerm(**item) for item in raw["rewards"]),
                    "scene": Scene(
                        width=scene["width"],
                        height=scene["height"],
                        rectangles=tuple(RectangleMark(**item) for item in scene["rectangles"]),
                        discs=tuple(DiscMark(**item) for item in scene["discs"]),
                        plate=None if plate is None else (plate[0], plate[1], plate[2], plate[3]),
                        robot_radius=scene["robot_radius"],
                        camera=bool(scene.get("camera", False)),
                        inset=bool(scene.get("inset", False)),
                        gates=tuple(GateMark(**item) for item in scene.get("gates", ())),
                    ),
                    "map_grid": None
                    if grid is None
                    else MapGrid(**{key: tuple(value) for key, value in grid.items()}),
                }
            )
        except (KeyError, TypeError, ValueError, IndexError, RecursionError) as error:
            raise RecordingError(f"no task description: {error}") from error
