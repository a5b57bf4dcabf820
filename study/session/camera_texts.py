"""The pages' sentences where the task says itself what is to be done, or shows pictures.

The task says it in one sentence. Nothing here speaks of maps, goals,
health or arrows.
"""

from __future__ import annotations

from study.seat_settings import DIRECTIONS
from study.session.actions import drives_all_ways
from study.session.condition_texts import key_word
from study.session.context import Context


def are_told(context: Context) -> bool:
    """Whether pages say what is to be done in words alone.

    The map with its legend and the four arrow keys is for tasks that have a goal and such keys.
    """
    scene, instruction = context.description.scene, context.description.instruction
    aimed = any(disc.role == "goal" for disc in scene.discs)
    all_ways = drives_all_ways(context.description)
    return scene.pictures_only or not all_ways or (bool(instruction) and not aimed)


def keys_text(context: Context) -> str:
    """Return which key does what."""
    keys, description = context.protocol.keys, context.description
    given = description.key_actions
    ordered = [name for name in DIRECTIONS if name in given]
    ordered += [name for name in given if name not in DIRECTIONS]
    parts = [
        context.say(
            "{key}: {action}",
            key=key_word(context, getattr(keys, name) if name in DIRECTIONS else name),
            action=description.action_names[given[name]],
        )
        for name in ordered
    ]
    return context.say("Hold a key to drive. {keys}.", keys="; ".join(parts))


def how_it_works(context: Context) -> tuple[str, ...]:
    """Return the paragraphs of the page that explains the task."""
    say = context.say
    instruction = context.description.instruction
    return (
        *([say(instruction)] if instruction else []),
        keys_text(context),
        say("Every robot earns points as it goes. The points of all robots are added up."),
    )


def practice(context: Context) -> tuple[str, ...]:
    """Return the paragraphs of the practice's page."""
    say = context.say
    return (
        say("Try what each key does."),
        keys_text(context),
        say("Whenever the robot's run is over, it starts again."),
    )


def phase_one(context: Context) -> tuple[str, ...]:
    """Return the paragraphs of phase one's page."""
    say = context.say
    return (
        say("The robot drives by itself. At first it has no idea and acts at random."),
        say(
            "Whenever it goes wrong, hold one of your keys: then it does what you say. "
            "Let go, and it drives itself again."
        ),
        say(
            "After each episode it learns from your corrections. An episode ends when the robot's "
            "run is over, or when its time is up."
        ),
    )
