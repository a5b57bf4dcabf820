"""The texts of the pages, written from the protocol so that no number can disagree with it."""

from __future__ import annotations

import dataclasses

from study.protocol import Condition
from study.session.context import Context
from study.session.plan import PagesPlan


@dataclasses.dataclass(frozen=True, slots=True)
class Page:
    """One page: see `study.screens.PageScreen` for the fields."""

    header: str
    title: str
    subtitle: str
    paragraphs: tuple[str, ...] = ()
    figure: str = ""
    robots: int = 1
    next_hint: str = ""
    action: str = "to go on"


def pages(plan: PagesPlan, context: Context) -> tuple[Page, ...]:
    """Return the pages of a stage; the stage "thanks" has one."""
    writers = {
        "welcome": _welcome,
        "practice": _practice,
        "phase_one": _phase_one,
        "phase_two": _phase_two,
        "explanation": _explanation,
        "debrief": _debrief,
        "thanks": _thanks,
    }
    if plan.name == "phase_three":
        return _phase_three(context, context.protocol.condition(plan.place.condition), plan)
    return writers[plan.name](context)


def _welcome(context: Context) -> tuple[Page, ...]:
    protocol = context.protocol
    most = max(condition.robots for condition in protocol.conditions)
    return (
        Page(
            header="Welcome",
            title="Welcome",
            subtitle="Today you teach robots to drive, and help a fleet of them.",
            paragraphs=(
                "There are four parts. First you teach one robot. Then you look after "
                f"{protocol.phase_two.robots} robots at once, and then after {most}. "
                "In the last part the robots show what they learned; you only watch.",
                "There are no trick questions and no wrong answers. It is the robots that are "
                "being studied, not you.",
                f'You can pause at any time with "{key_word(protocol.keys.pause)}", '
                "and you can stop whenever you like.",
            ),
        ),
        Page(
            header="How it works",
            title="Bring the robots to their goal",
            subtitle="You drive one robot at a time. The others drive themselves, not always well.",
            figure="map",
        ),
    )


def _practice(context: Context) -> tuple[Page, ...]:
    seconds = context.protocol.practice.timesteps / context.protocol.timing.timesteps_per_second
    return (
        Page(
            header="Practice",
            title="First, a short drive",
            subtitle=f"{counted(round(seconds), 'second')} to try the keys. Nothing counts yet.",
            paragraphs=(
                "Drive through the doors to the flag. Keep out of the hatched hazards; "
                "a green cross gives health back.",
                "Each time you reach the goal, the robot starts again somewhere else.",
            ),
        ),
    )


def _phase_one(context: Context) -> tuple[Page, ...]:
    episodes = context.protocol.phase_one.episodes
    return (
        Page(
            header="Part 1 of 4",
            title="Teach one robot",
            subtitle=f"{episodes} episodes with one robot. It learns from what you do.",
            paragraphs=(
                "The robot drives by itself. At first it has no idea and moves at random.",
                "Whenever it goes wrong, hold an arrow key: then it does what you say. "
                "Let go, and it drives itself again.",
                "After each episode it learns from your corrections. An episode ends at the goal, "
                "when the robot's health is used up, or when its time is up.",
            ),
        ),
    )


def _phase_two(context: Context) -> tuple[Page, ...]:
    settings = context.protocol.phase_two
    return (
        Page(
            header="Part 2 of 4",
            title=f"Look after {settings.robots} robots",
            subtitle="You choose which robot to drive, and change whenever you like.",
            paragraphs=(
                "The robots drive as you taught them. Take over the one that you can help most.",
                "The robot you choose stands still unless you drive it.",
            ),
            figure="choose",
            robots=settings.robots,
        ),
    )


def _phase_three(context: Context, condition: Condition, plan: PagesPlan) -> tuple[Page, ...]:
    trials = context.protocol.phase_three.trials
    header = f"Part 3 of 4, block {plan.place.block} of {len(context.order)}"
    if condition.allocation == "manual":
        page = Page(
            header=header,
            title=f"{condition.robots} robots: you choose",
            subtitle=f"{counted(trials, 'trial')}. You choose which robot to drive, as before.",
            paragraphs=(
                "Take over the robot that you can help most, and change whenever you like.",
                "Your points are shown when the block is finished.",
            ),
            figure="choose",
            robots=condition.robots,
        )
    elif condition.allocation == "suggested":
        page = Page(
            header=header,
            title=f"{condition.robots} robots: you choose, with a suggestion",
            subtitle=f"{counted(trials, 'trial')}. One robot is suggested to you at a time.",
            paragraphs=(
                "A dashed orange frame marks the robot that seems to need you most. "
                f"{key_word(context.protocol.keys.accept)} takes you there.",
                "You need not follow it: choose any robot by its number, as before.",
                "Your points are shown when the block is finished.",
            ),
            figure="choose",
            robots=condition.robots,
        )
    else:
        seconds = condition.dwell / context.protocol.timing.timesteps_per_second
        alone = condition.view == "operated_only"
        page = Page(
            header=header,
            title=f"{condition.robots} robots: you are switched",
            subtitle=f"{counted(trials, 'trial')}. Which robot you drive is chosen for you.",
            paragraphs=(
                f"About every {seconds:.1f} seconds you are switched to the robot that seems to "
                "need you most. "
                "A ring shows how long is left until the next switch.",
                "You see only the robot that you drive; the others drive on unseen."
                if alone
                else "You see all robots; the one you drive has a blue frame.",
                "After a switch, press the arrow key again. "
                "Your points are shown when the block is finished.",
            ),
            figure="assisted",
            robots=condition.robots,
        )
    return (page,)


def _explanation(context: Context) -> tuple[Page, ...]:
    part, wrong = context.protocol.comprehension, context.knowledge.comprehension_wrong
    if part is None or not wrong:
        return ()
    return (
        Page(
            header="Before we start",
            title="Let us look at that again",
            subtitle="Then the same questions once more.",
            paragraphs=tuple(q.explanation for q in part.questions if q.id in wrong),
        ),
    )


def _debrief(context: Context) -> tuple[Page, ...]:
    part = context.protocol.debrief
    if part is None:
        return ()
    return (Page(header="At the end", title=part.title, subtitle="", paragraphs=part.paragraphs),)


def _thanks(context: Context) -> tuple[Page, ...]:  # noqa: ARG001 - writers are called alike
    return (
        Page(
            header="",
            title="Thank you!",
            subtitle="That was all. Please tell the experimenter that you have finished.",
        ),
    )


def key_word(key: str) -> str:
    """Return a key's name as printed on it."""
    words = {
        "escape": "Esc",
        "return": "Enter",
        "tab": "Tab",
        "backspace": "Backspace",
        "space": "Space",
    }
    return words.get(key, key.capitalize())


def counted(number: int, noun: str) -> str:
    """Return a number with its noun: "1 trial", "8 trials"."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
