"""The texts of a condition's page: how robots are chosen in it."""

from __future__ import annotations

from study.messages import noted
from study.protocol import Condition
from study.session.actions import drives_all_ways
from study.session.context import Context


def key_word(context: Context, key: str) -> str:
    """Return a key's name as printed on it."""
    words = {
        "escape": noted("Esc"),
        "return": noted("Enter"),
        "tab": noted("Tab"),
        "backspace": noted("Backspace"),
        "space": noted("Space"),
    }
    return context.say(words[key]) if key in words else key.capitalize()


def manual(context: Context, condition: Condition) -> tuple[str, str, tuple[str, ...]]:
    """Return title, subtitle and paragraphs of a condition with manual allocation."""
    say = context.say
    return (
        say("{robots} robots: you choose", robots=condition.robots),
        context.count(
            "{n} trial. You choose which robot to drive, as before.",
            "{n} trials. You choose which robot to drive, as before.",
            context.protocol.phase_three.trials,
        ),
        (
            say("Take over the robot that you can help most, and change whenever you like."),
            say("Your points are shown when the block is finished."),
        ),
    )


def suggested(context: Context, condition: Condition) -> tuple[str, str, tuple[str, ...]]:
    """Return title, subtitle and paragraphs of a condition with suggested allocation."""
    say = context.say
    return (
        say("{robots} robots: you choose, with a suggestion", robots=condition.robots),
        context.count(
            "{n} trial. One robot is suggested to you at a time.",
            "{n} trials. One robot is suggested to you at a time.",
            context.protocol.phase_three.trials,
        ),
        (
            say(
                "A dashed orange frame marks the robot that is suggested. {key} takes you there.",
                key=key_word(context, context.protocol.keys.accept),
            ),
            say("You need not follow it: choose any robot by its number, as before."),
            say("Your points are shown when the block is finished."),
        ),
    )


def assisted(context: Context, condition: Condition) -> tuple[str, str, tuple[str, ...]]:
    """Return title, subtitle and paragraphs of a condition with assisted allocation."""
    say = context.say
    seconds = condition.dwell / context.protocol.timing.timesteps_per_second
    return (
        say("{robots} robots: you are switched", robots=condition.robots),
        context.count(
            "{n} trial. Which robot you drive is chosen for you.",
            "{n} trials. Which robot you drive is chosen for you.",
            context.protocol.phase_three.trials,
        ),
        (
            say(
                "About every {seconds} seconds it is chosen anew which robot you drive. "
                "A ring shows how long is left until then.",
                seconds=f"{seconds:.1f}",
            ),
            say("You see only the robot that you drive; the others drive on unseen.")
            if condition.view == "operated_only"
            else say("You see all robots; the one you drive has a blue frame."),
            say(
                "After a switch, press your key again. "
                "Your points are shown when the block is finished."
            )
            if not drives_all_ways(context.description)
            else say(
                "After a switch, press the arrow key again. "
                "Your points are shown when the block is finished."
            ),
        ),
    )
