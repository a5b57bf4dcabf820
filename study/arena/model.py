"""The arena and its robots as MJCF, MuJoCo's model format: the same text for the same arguments."""

from __future__ import annotations

import math

from study.arena.course import Course

WHEEL_RADIUS = 0.0325
"""Metres."""

TRACK = 0.11
"""Between the wheels' middles, metres."""

FRAME_WIDTH, FRAME_HEIGHT = 160, 120
"""Size of camera frames, pixels."""

_WALL_HEIGHT, _WALL_THICKNESS = 0.3, 0.05
_BUCKET_HEIGHT = 0.28
_CAMERA_TILT = math.radians(15.0)
_COLOURS = (
    "0.16 0.47 0.71",
    "0.85 0.37 0.10",
    "0.20 0.60 0.33",
    "0.58 0.40 0.74",
    "0.55 0.34 0.29",
    "0.89 0.47 0.76",
)


def arena_mjcf(course: Course, robots: int, *, motor_lag_s: float, step_s: float) -> str:
    """Return the model of an arena with ``robots`` JetBots standing in a row.

    Robot k has the joint ``robot{k}`` (free), the actuators ``robot{k}_left`` and
    ``robot{k}_right`` (wheel speeds, rad/s, reached with a lag of first order) and the camera
    ``robot{k}_front``.

    Args:
        course: the arena.
        robots: number of robots, n.
        motor_lag_s: time constant of the motors, seconds, positive.
        step_s: physics step, seconds.
    """
    parts = [
        '<mujoco model="jetbot_arena">',
        f'<option timestep="{step_s!r}" integrator="implicitfast"/>',
        f'<visual><global offwidth="{FRAME_WIDTH}" offheight="{FRAME_HEIGHT}"/>'
        # Shadows and multisampling take most of the time of a frame drawn in software.
        '<quality shadowsize="0" offsamples="0"/><map znear="0.0008"/>'
        '<headlight ambient="0.45 0.45 0.45" diffuse="0.2 0.2 0.2" specular="0 0 0"/></visual>',
        _DEFAULTS,
        _LOOKS,
        '<worldbody><light pos="0 0 4" dir="0.3 0.2 -1" directional="true"'
        ' diffuse="0.45 0.45 0.45" specular="0 0 0"/>',
        *_surroundings(course),
        *(_robot(course, robot) for robot in range(robots)),
        "</worldbody>",
        "<actuator>",
        *(_motors(robot, motor_lag_s) for robot in range(robots)),
        "</actuator>",
        "</mujoco>",
    ]
    return "\n".join(parts)


_DEFAULTS = f"""<default>
<default class="wheel">
<geom type="cylinder" size="{WHEEL_RADIUS} 0.005" euler="90 0 0" mass="0.05"
 friction="1 0.005 0.0001" rgba="0.1 0.1 0.1 1"/>
<joint type="hinge" axis="0 1 0" damping="0.0001"/>
</default>
<default class="caster">
<geom type="sphere" size="0.012" mass="0.01" condim="1" priority="1" rgba="0.6 0.6 0.6 1"/>
</default>
<default class="motor">
<general dyntype="filterexact" gainprm="0.03" biastype="affine" biasprm="0 0 -0.03"
 forcelimited="true" forcerange="-0.08 0.08"/>
</default>
</default>"""

_LOOKS = """<asset>
<texture type="skybox" builtin="gradient" rgb1="0.93 0.95 0.97" rgb2="0.72 0.79 0.87"
 width="64" height="384"/>
<texture name="tiles" type="2d" builtin="checker" rgb1="0.74 0.74 0.71" rgb2="0.62 0.62 0.60"
 width="128" height="128"/>
<material name="floor" texture="tiles" texrepeat="4 4" texuniform="true"/>
</asset>"""
"""A floor of tiles a quarter of a metre wide, so that motion is seen, and a sky."""

_WALL_COLOURS = ("0.36 0.47 0.58", "0.52 0.44 0.38", "0.40 0.50 0.42", "0.47 0.42 0.54")
"""One a side, so that a picture tells where a robot faces."""


def _surroundings(course: Course) -> list[str]:
    width, height, half = course.width, course.height, _WALL_THICKNESS / 2
    tall = _WALL_HEIGHT / 2
    walls = [
        (width / 2, -half, width / 2 + 2 * half, half),
        (width / 2, height + half, width / 2 + 2 * half, half),
        (-half, height / 2, half, height / 2),
        (width + half, height / 2, half, height / 2),
    ]
    lines = [
        f'<geom name="floor" type="plane" pos="{width / 2} {height / 2} 0"'
        f' size="{width} {height} 0.1" material="floor"/>'
    ]
    lines += [
        f'<geom name="wall{number}" type="box" pos="{x} {y} {tall}"'
        f' size="{half_x} {half_y} {tall}" rgba="{_WALL_COLOURS[number]} 1"/>'
        for number, (x, y, half_x, half_y) in enumerate(walls)
    ]
    lines += [
        f'<geom name="bucket{number}" type="cylinder"'
        f' pos="{bucket.x} {bucket.y} {_BUCKET_HEIGHT / 2}"'
        f' size="{bucket.radius} {_BUCKET_HEIGHT / 2}" rgba="0.95 0.75 0.15 1"/>'
        for number, bucket in enumerate(course.buckets)
    ]
    finish = course.gates[-1]
    across, along = finish.outer_x - finish.inner_x, finish.outer_y - finish.inner_y
    lines.append(
        '<geom name="finish" type="box" contype="0" conaffinity="0" rgba="0.80 0.12 0.12 1"'
        f' pos="{finish.inner_x + across / 2} {finish.inner_y + along / 2} 0.001"'
        f' size="{math.hypot(across, along) / 2} 0.04 0.001"'
        f' euler="0 0 {math.degrees(math.atan2(along, across))}"/>'
    )
    return lines


def _robot(course: Course, robot: int) -> str:
    x = course.width * (robot + 0.5) / 12
    colour = _COLOURS[robot % len(_COLOURS)]
    up_x, up_z = math.sin(_CAMERA_TILT), math.cos(_CAMERA_TILT)
    wheels = "".join(
        f'<body name="robot{robot}_{side}" pos="0 {y} 0" childclass="wheel">'
        f'<joint name="robot{robot}_{side}"/><geom/></body>'
        for side, y in (("left", TRACK / 2), ("right", -TRACK / 2))
    )
    return (
        f'<body name="robot{robot}" pos="{x} 0.2 {WHEEL_RADIUS}">'
        f'<freejoint name="robot{robot}"/>'
        f'<geom type="box" pos="0 0 0.03" size="0.06 0.04 0.025" mass="0.8" rgba="{colour} 1"/>'
        f'<geom class="caster" pos="0.045 0 -0.0200"/><geom class="caster" pos="-0.045 0 -0.0200"/>'
        f'<camera name="robot{robot}_front" pos="0.045 0 0.08" fovy="90"'
        f' xyaxes="0 -1 0 {up_x!r} 0 {up_z!r}"/>'
        f"{wheels}</body>"
    )


def _motors(robot: int, motor_lag_s: float) -> str:
    return "".join(
        f'<general class="motor" name="robot{robot}_{side}" joint="robot{robot}_{side}"'
        f' dynprm="{motor_lag_s!r}"/>'
        for side in ("left", "right")
    )
