"""Robots that what watches over them has stopped: told to the operator, and recorded."""

from __future__ import annotations

from study.events.events import Deviation
from study.events.inputs import RobotReported
from study.session.context import Context, Outbox

ENGINE_LOST = "engine_lost"
"""The reason of a robot whose simulation is being replaced."""


def take_report(given: RobotReported, context: Context, trial_id: int, out: Outbox) -> None:
    """Remember which robots stand and why; each stop is a deviation.

    Args:
        given: a robot was stopped, or one reason for it is gone.
        context: of the session.
        trial_id: the fleet run; -1 if none.
        out: takes the event.
    """
    held = context.knowledge.held_robots
    if given.stopped:
        held.setdefault(given.robot, []).append(given.reason)
        out.events.append(Deviation(given.t_ns, "robot_stopped", given.text, trial_id))
    elif given.reason in held.get(given.robot, []):
        held[given.robot].remove(given.reason)
        if not held[given.robot]:
            del held[given.robot]


def held_message(context: Context, robots: int) -> str:
    """Say which of a fleet's robots stand and why; empty if all may drive.

    Args:
        context: of the session.
        robots: number of robots, n.
    """
    reasons = {
        "link_lost": context.say("does not answer"),
        "link_slow": context.say("answers too slowly"),
        "pose_lost": context.say("is not seen by motion capture"),
        "camera_stale": context.say("has a camera that shows nothing new"),
        "battery_flat": context.say("has a flat battery"),
        "emergency": context.say("is under an emergency stop"),
    }
    held = {
        robot: why[0]
        for robot, why in sorted(context.knowledge.held_robots.items())
        if robot < robots
    }
    texts = [
        context.say("Robot {n} {what} and stands still", n=robot + 1, what=reasons.get(why, why))
        for robot, why in held.items()
        if why != ENGINE_LOST
    ]
    waiting = [str(robot + 1) for robot, why in held.items() if why == ENGINE_LOST]
    if waiting:
        # Engines fail by the half dozen, and all robots wait for them.
        texts.append(
            context.count(
                "One moment: robot {numbers} is being brought back, and all wait for it",
                "One moment: robots {numbers} are being brought back, and all wait for them",
                len(waiting),
                numbers=", ".join(waiting),
            )
        )
    return "; ".join(texts)
