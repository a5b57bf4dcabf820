"""The texts of the pages, written from the protocol so that no number can disagree with it."""

from __future__ import annotations

import dataclasses

from study.protocol import Condition
from study.session import camera_texts
from study.session.condition_texts import assisted, key_word, manual, suggested
from study.session.context import Context
from study.session.fit_gate import condition_as_run
from study.session.plan import PagesPlan


def parts_of(context: Context) -> int:
    """Return how many parts a session has, as participants count: the phases of the protocol."""
    return 3 if context.protocol.phase_four is None else 4


@dataclasses.dataclass(frozen=True, slots=True)
class Page:
    """One page: see `study.screens.PageScreen` for the fields."""

    header: str
    title: str
    subtitle: str
    action: str
    paragraphs: tuple[str, ...] = ()
    figure: str = ""
    robots: int = 1
    next_hint: str = ""


def pages(plan: PagesPlan, context: Context) -> tuple[Page, ...]:
    """Return the pages of a stage; the stage "thanks" has one."""
    writers = {
        "welcome": _welcome,
        "practice": _practice,
        "phase_one": _phase_one,
        "phase_two": _phase_two,
        "repeat": _repeat,
        "correction_round": _correction_round,
        "explanation": _explanation,
        "debrief": _debrief,
        "thanks": _thanks,
    }
    if plan.name == "phase_three":
        condition = condition_as_run(context.protocol.condition(plan.place.condition), context)
        return _phase_three(context, condition, plan)
    return writers[plan.name](context)


def _welcome(context: Context) -> tuple[Page, ...]:
    protocol, say = context.protocol, context.say
    most = max(condition.robots for condition in protocol.conditions)
    return (
        Page(
            header=say("Welcome"),
            title=say("Welcome"),
            subtitle=say("Today you teach robots to drive, and help a fleet of them."),
            paragraphs=(
                say(
                    "There are four parts. First you teach one robot. Then you look after "
                    "{few} robots at once, and then after {many}. "
                    "In the last part the robots show what they learned; "
                    "there you have nothing to do.",
                    few=protocol.phase_two.robots,
                    many=most,
                )
                if protocol.phase_four
                else say(
                    "There are three parts. First you teach one robot. Then you look after "
                    "{few} robots at once, and then after {many}.",
                    few=protocol.phase_two.robots,
                    many=most,
                ),
                say(
                    "There are no trick questions and no wrong answers. It is the robots that are "
                    "being studied, not you."
                )
                if protocol.comprehension is None
                else say(
                    "There are no trick questions, and where you are asked for your view no answer "
                    "is wrong. It is the robots that are being studied, not you."
                ),
                say(
                    'You can pause with "{key}", and you can stop whenever you like.',
                    key=key_word(context, protocol.keys.pause),
                ),
            ),
            action=say("to go on"),
        ),
        _how_it_works(context),
    )


def _how_it_works(context: Context) -> Page:
    say = context.say
    told = camera_texts.are_told(context)
    instruction = context.description.instruction
    own = (say(instruction),) if instruction else ()
    return Page(
        header=say("How it works"),
        title=say("What is to be done") if told else say("Bring the robots to their goal"),
        subtitle=say(
            "You drive one robot at a time. The others drive themselves, not always well."
        ),
        paragraphs=camera_texts.how_it_works(context) if told else own,
        figure="" if told else "map",
        action=say("to go on"),
    )


def _practice(context: Context) -> tuple[Page, ...]:
    say = context.say
    seconds = context.protocol.practice.timesteps / context.protocol.timing.timesteps_per_second
    return (
        Page(
            header=say("Practice"),
            title=say("First, a short drive"),
            subtitle=context.count(
                "{n} second to try the keys. Nothing counts yet.",
                "{n} seconds to try the keys. Nothing counts yet.",
                round(seconds),
            )
            if seconds >= 1
            else say("Less than a second to try the keys. Nothing counts yet."),
            paragraphs=camera_texts.practice(context)
            if camera_texts.are_told(context)
            else (
                say(context.description.instruction)
                if context.description.instruction
                else say(
                    "Drive through the doors to the flag. Keep out of the hatched hazards; "
                    "a green cross gives health back."
                ),
                say("Each time you reach the goal, the robot starts again somewhere else."),
            ),
            action=say("to go on"),
        ),
    )


def _phase_one(context: Context) -> tuple[Page, ...]:
    say = context.say
    return (
        Page(
            header=say("Part {part} of {parts}", part=1, parts=parts_of(context)),
            title=say("Teach one robot"),
            subtitle=context.count(
                "{n} episode with one robot. It learns from what you do.",
                "{n} episodes with one robot. It learns from what you do.",
                context.protocol.phase_one.episodes,
            ),
            paragraphs=camera_texts.phase_one(context)
            if camera_texts.are_told(context)
            else (
                say("The robot drives by itself. At first it has no idea and moves at random."),
                say(
                    "Whenever it goes wrong, hold an arrow key: then it does what you say. "
                    "Let go, and it drives itself again."
                ),
                say(
                    "After each episode it learns from your corrections. An episode ends at the "
                    "goal, when the robot's health is used up, or when its time is up."
                ),
            ),
            action=say("to go on"),
        ),
    )


def _phase_two(context: Context) -> tuple[Page, ...]:
    say, robots = context.say, context.protocol.phase_two.robots
    return (
        Page(
            header=say("Part {part} of {parts}", part=2, parts=parts_of(context)),
            title=say("Look after {robots} robots", robots=robots),
            subtitle=say("You choose which robot to drive, and change whenever you like."),
            paragraphs=(
                say(
                    "The robots drive as you taught them. Take over the one that you can help most."
                ),
                say("The robot you choose does nothing of its own: you drive it.")
                if camera_texts.are_told(context)
                else say("The robot you choose stands still unless you drive it."),
            ),
            figure="choose",
            robots=robots,
            action=say("to go on"),
        ),
    )


def _repeat(context: Context) -> tuple[Page, ...]:
    say, robots = context.say, context.protocol.phase_two.robots
    return (
        Page(
            header=say("Part {part} of {parts}", part=2, parts=parts_of(context)),
            title=say("A few more trials"),
            subtitle=say("As before: you choose which of {robots} robots to drive.", robots=robots),
            paragraphs=(
                say("The robots learn from what you choose, and can use a little more of it."),
            ),
            figure="choose",
            robots=robots,
            action=say("to go on"),
        ),
    )


def _correction_round(context: Context) -> tuple[Page, ...]:
    part, say = context.protocol.correction_round, context.say
    if part is None:
        return ()
    rate = context.protocol.timing.timesteps_per_second
    return (
        Page(
            header=say("Part {part} of {parts}", part=2, parts=parts_of(context)),
            title=say("{robots} robots: sometimes you choose", robots=part.robots),
            subtitle=context.count(
                "{n} trial. Two things take turns.",
                "{n} trials. Two things take turns.",
                part.trials,
            ),
            paragraphs=(
                say(
                    "For {seconds} seconds you drive a robot that was chosen for you. "
                    "You see only that one, and a ring shows how long is left.",
                    seconds=f"{part.dwell / rate:.1f}",
                ),
                say(
                    "Then you see {offered} robots, other ones each time. For {seconds} seconds "
                    "you choose which of them to drive, by the number on it.",
                    offered=part.offered,
                    seconds=f"{part.offer_timesteps / rate:.1f}",
                ),
                say("Take over the robot that you can help most. The robots learn from it."),
            ),
            figure="choose",
            robots=part.robots,
            action=say("to go on"),
        ),
    )


def block_heading(context: Context, block: int) -> str:
    """Return which block of phase three this is, in words."""
    return context.say(
        "Part {part} of {parts}, block {block} of {blocks}",
        part=3, parts=parts_of(context), block=block, blocks=len(context.order),
    )  # fmt: skip


def block_finished(context: Context, block: int) -> str:
    """Return which block of phase three is over, in words."""
    return context.say(
        "Part {part} of {parts}, block {block} of {blocks}: finished",
        part=3, parts=parts_of(context), block=block, blocks=len(context.order),
    )  # fmt: skip


def _phase_three(context: Context, condition: Condition, plan: PagesPlan) -> tuple[Page, ...]:
    writer = {"manual": manual, "suggested": suggested, "assisted": assisted}
    title, subtitle, paragraphs = writer[condition.allocation](context, condition)
    return (
        Page(
            header=block_heading(context, plan.place.block),
            title=title,
            subtitle=subtitle,
            paragraphs=paragraphs,
            figure=_figure(condition),
            robots=condition.robots,
            action=context.say("to go on"),
        ),
    )


def _figure(condition: Condition) -> str:
    """Return the illustration that shows what is seen in a condition."""
    if condition.allocation != "assisted":
        return "choose"
    return "assisted" if condition.view == "operated_only" else "assisted_all"


def _explanation(context: Context) -> tuple[Page, ...]:
    part, wrong = context.protocol.comprehension, context.knowledge.comprehension_wrong
    say = context.say
    if part is None or not wrong:
        return ()
    return (
        Page(
            header=say("Before we start"),
            title=say("Let us look at that again"),
            subtitle=context.count(
                "Then the same question once more.",
                "Then the same questions once more.",
                len(part.questions),
            ),
            paragraphs=tuple(say(q.explanation) for q in part.questions if q.id in wrong),
            action=say("to go on"),
        ),
    )


def _debrief(context: Context) -> tuple[Page, ...]:
    part, say = context.protocol.debrief, context.say
    if part is None:
        return ()
    return (
        Page(
            header=say("At the end"),
            title=say(part.title),
            subtitle="",
            paragraphs=tuple(say(text) for text in part.paragraphs),
            action=say("to go on"),
        ),
    )


def _thanks(context: Context) -> tuple[Page, ...]:
    say = context.say
    return (
        Page(
            header="",
            title=say("Thank you!"),
            subtitle=say("That was all. Please tell the experimenter that you have finished."),
            action="",
        ),
    )
