"""The map as Foxglove's primitives, from the task description that every recording holds."""

from __future__ import annotations

from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from study.events.scene import DiscMark, RectangleMark, Role, Scene

FRAME = "map"
"""The frame of the map: metres, x to the right, y upwards, origin at bottom left."""

WALL_HEIGHT = 0.4
_LOOKS: dict[Role, tuple[tuple[int, int, int], float, float]] = {
    # Role: colour, z of the underside, thickness; flat things lie in layers, so that none flickers.
    "room": ((0xF6, 0xF8, 0xFA), -0.05, 0.01),
    "start": ((0xD3, 0xDA, 0xE0), -0.04, 0.01),
    "hazard": ((0xD5, 0x5E, 0x00), -0.03, 0.01),
    "goal": ((0x00, 0x9E, 0x73), -0.02, 0.01),
    "health_pack": ((0xF0, 0xE4, 0x42), -0.01, 0.01),
    "wall": ((0x33, 0x40, 0x4D), 0.0, WALL_HEIGHT),
}


def map_scene(scene: Scene, log_time_ns: int) -> SceneUpdate:
    """Return the whole map: one entity a mark, called by its role and number.

    Sent again, it replaces what it drew before.

    Args:
        scene: the map, metres.
        log_time_ns: when it is valid from, nanoseconds since 1970, UTC.
    """
    update = SceneUpdate()
    counts: dict[Role, int] = {}
    marks: tuple[RectangleMark | DiscMark, ...] = (*scene.rectangles, *scene.discs)
    for mark in marks:
        counts[mark.role] = counts.get(mark.role, 0) + 1
        entity = update.entities.add(id=f"{mark.role}_{counts[mark.role]}", frame_id=FRAME)
        entity.timestamp.FromNanoseconds(log_time_ns)
        _draw(entity, mark)
    return update


def colour(rgb: tuple[int, int, int], alpha: float = 1.0) -> Color:
    """Return a colour given in 0 to 255 as Foxglove has it, in 0 to 1."""
    return Color(r=rgb[0] / 255, g=rgb[1] / 255, b=rgb[2] / 255, a=alpha)


def _draw(entity: SceneEntity, mark: RectangleMark | DiscMark) -> None:
    rgb, low, thickness = _LOOKS[mark.role]
    if isinstance(mark, RectangleMark):
        cube = entity.cubes.add(color=colour(rgb))
        cube.size.x, cube.size.y, cube.size.z = mark.width, mark.height, thickness
        pose = cube.pose
        pose.position.x, pose.position.y = mark.x + mark.width / 2, mark.y + mark.height / 2
    else:
        disc = entity.cylinders.add(color=colour(rgb), bottom_scale=1.0, top_scale=1.0)
        disc.size.x = disc.size.y = 2 * mark.radius
        disc.size.z = thickness
        pose = disc.pose
        pose.position.x, pose.position.y = mark.x, mark.y
    pose.position.z = low + thickness / 2
    pose.orientation.w = 1.0
