"""The survey stage: items answered by digits, arrows, Tab, typing and pointer; Enter confirms."""

from __future__ import annotations

from study.events.codes import Phase
from study.events.events import QuestionAnswered
from study.events.inputs import Input, KeyChanged, PointerPressed, TextTyped
from study.events.participant_events import AnswerChanged, InstrumentScored, TextAnswered
from study.questionnaire import LONGEST_TEXT, Questionnaire
from study.screens import Screen, SurveyItem, SurveyScreen
from study.session.answers import Answers, TypedDigits
from study.session.context import Context, Outbox
from study.session.effects import EnsureDurable, Show
from study.session.page_texts import block_finished
from study.session.plan import Place, SurveyPlan
from study.session.rules import CORRECTING_DIGITS, DEAD_TIME, NUMBERS_ON_SCALES
from study.session.stage import QuietStage

_DEAD_TIME_NS = 500_000_000
"""In which keys answer nothing: nobody has read the first question yet, and whoever still drives
presses the arrows, digits and Tab that would answer it."""


class Form(QuietStage):
    """One questionnaire on one occasion, page by page. Nothing is preselected.

    A page is confirmed as a whole and not gone back to.
    """

    kind = "survey"

    def __init__(
        self, questionnaire: Questionnaire, place: Place, occasion: str, context: Context
    ) -> None:
        self._context = context
        self._questionnaire = questionnaire
        self._place = place
        self._occasion = occasion
        self._answers = Answers(questionnaire)
        self._page = range(min(len(questionnaire.items), questionnaire.items_per_page))
        self._focus = 0
        self._chosen_last: int | None = None
        self._digits = TypedDigits()
        self._entered_ns = 0
        self._deaf_until_ns = 0
        self._reminder = ""

    def enter(self, t_ns: int, out: Outbox) -> bool:  # noqa: ARG002 - stages are entered alike
        """Start the latency clock."""
        self._entered_ns = t_ns
        if self._context.rules >= DEAD_TIME:
            self._deaf_until_ns = t_ns + _DEAD_TIME_NS
        return False

    def handle(self, given: Input, out: Outbox) -> bool:
        """Take in keys, characters and pointer."""
        if isinstance(given, KeyChanged | TextTyped) and given.t_ns < self._deaf_until_ns:
            return False
        if isinstance(given, KeyChanged) and given.down:
            done = self._key(given.key, given.t_ns, out)
        elif isinstance(given, PointerPressed):
            done = self._pointer(given.target, given.t_ns, out)
        elif isinstance(given, TextTyped):
            done = False
            if self._focus < len(self._page):
                changed = self._answers.type(self._focused, given.text, given.t_ns)
                self._note(self._focused, given.t_ns, out, changed=changed)
        else:
            return False
        if not done:
            out.effects.append(Show(self.screen()))
        return done

    @property
    def _focused(self) -> int:
        return self._page[self._focus]

    def _key(self, key: str, t_ns: int, out: Outbox) -> bool:
        keys = self._context.protocol.keys
        count = len(self._page)
        on_item = self._focus < count
        kind = self._questionnaire.items[self._focused].kind if on_item else ""
        if key == keys.confirm:
            return self._confirm(t_ns, out)
        digit = len(key) == 1 and key.isascii() and key.isdecimal()
        if not digit:
            self._digits.forget()
        if digit and not on_item and self._chosen_last is not None and self._next_open() == count:
            # Who has answered all, and presses another digit, has changed their mind.
            self._focus = self._chosen_last
            on_item, kind = True, self._questionnaire.items[self._focused].kind
        if kind != "text" and digit:
            if on_item and self._set_digit(int(key), t_ns, out) and kind != "number":
                self._focus = self._next_open(stays=self._questionnaire.high > 9)
        elif key in (keys.left, keys.right) and on_item:
            by = 1 if key == keys.right else -1
            self._note(
                self._focused, t_ns, out, changed=self._answers.move(self._focused, by, t_ns)
            )
        elif key == "backspace" and kind in ("number", "text"):
            self._note(self._focused, t_ns, out, changed=self._answers.delete(self._focused, t_ns))
        elif key in (keys.next_robot, keys.down):
            self._focus = (self._focus + 1) % (count + 1)
        elif key == keys.up:
            self._focus = (self._focus - 1) % (count + 1)
        return False

    def _set_digit(self, digit: int, t_ns: int, out: Outbox) -> bool:
        place, form = self._focused, self._questionnaire
        item = form.items[place]
        if item.kind == "scale" and form.high > 9 and self._context.rules >= NUMBERS_ON_SCALES:
            number = self._digits.add(place, digit, form.high, t_ns)
            changed = self._answers.near(place, number, t_ns)
        else:
            changed = self._answers.digit(place, digit, t_ns)
        self._note(place, t_ns, out, changed=changed)
        return changed or self._answers.value(self._focused) == digit or item.kind == "number"

    def _pointer(self, target: str, t_ns: int, out: Outbox) -> bool:
        if target == "confirm":
            return self._confirm(t_ns, out)
        kind, _, rest = target.partition(":")
        name, _, value = rest.partition(":")
        for focus, place in enumerate(self._page):
            item = self._questionnaire.items[place]
            if item.id != name:
                continue
            self._focus = focus
            if item.kind == "number" and kind in ("digit", "delete"):
                self._number_key(kind, value, t_ns, out)
            answers = kind == "answer" and item.kind != "number"
            if not (answers and value.isascii() and value.isdecimal() and len(value) < 7):
                continue
            if self._questionnaire.takes(item, int(value)):
                changed = self._answers.set(place, int(value), t_ns)
                self._note(place, t_ns, out, changed=changed)
        return False

    def _number_key(self, kind: str, digit: str, t_ns: int, out: Outbox) -> None:
        """Take in a click on a digit drawn beside a number, or on the key that deletes the last."""
        place = self._focused
        if kind == "delete":
            self._note(place, t_ns, out, changed=self._answers.delete(place, t_ns))
        elif len(digit) == 1 and digit.isascii() and digit.isdecimal():
            self._note(place, t_ns, out, changed=self._answers.digit(place, int(digit), t_ns))

    def _note(self, place: int, t_ns: int, out: Outbox, *, changed: bool) -> None:
        """Record a change of an answer."""
        self._reminder = ""
        if not changed or self._context.rules < 1:
            return
        if self._context.rules >= CORRECTING_DIGITS:
            chosen = self._questionnaire.items[place].kind in ("scale", "choice")
            self._chosen_last = place - self._page.start if chosen else None
        value = self._answers.value(place)
        out.events.append(
            AnswerChanged(
                t_ns=t_ns,
                questionnaire=self._questionnaire.name,
                item=self._questionnaire.items[place].id,
                value=-1 if value is None else value,
                occasion=self._occasion,
                latency_ns=t_ns - self._entered_ns,
            )
        )

    def _next_open(self, *, stays: bool = False) -> int:
        """Return the next question without an answer; a long scale keeps the focus."""
        if stays and self._focus < len(self._page):
            item = self._questionnaire.items[self._focused]
            if item.kind == "scale":
                return self._focus
        found = [focus for focus, place in enumerate(self._page) if self._answers.is_open(place)]
        return found[0] if found else len(self._page)

    def _confirm(self, t_ns: int, out: Outbox) -> bool:
        if any(self._answers.is_open(place) for place in self._page):
            self._focus = self._next_open()
            self._reminder = self._reminder_of(self._focused)
            return False
        for place in self._page:
            self._answered(place, t_ns, out)
        following = range(
            self._page.stop,
            min(
                self._page.stop + self._questionnaire.items_per_page,
                len(self._questionnaire.items),
            ),
        )
        out.effects.append(EnsureDurable())
        if following:
            self._page, self._focus, self._entered_ns = following, 0, t_ns
            self._chosen_last = None
            return False
        self._score(t_ns, out)
        return True

    def _reminder_of(self, place: int) -> str:
        """Return what is still to be done with a question."""
        item = self._questionnaire.items[place]
        if item.kind == "number" and self._answers.typed(place):
            return self._context.say(
                "Type a number from {low} to {high}.", low=item.least, high=item.most
            )
        return self._context.say("Please answer this question first.")

    def _answered(self, index: int, t_ns: int, out: Outbox) -> None:
        place, item = self._place, self._questionnaire.items[index]
        latency_ns = max(0, self._answers.changed_ns[index] - self._entered_ns)
        value = self._answers.value(index)
        if item.kind == "text":
            out.events.append(
                TextAnswered(
                    t_ns=t_ns,
                    questionnaire=self._questionnaire.name,
                    item=item.id,
                    text=self._answers.typed(index),
                    phase=place.phase,
                    block=place.block,
                    condition=place.condition,
                    occasion=self._occasion,
                    latency_ns=latency_ns,
                )
            )
        elif value is not None:
            out.events.append(
                QuestionAnswered(
                    t_ns=t_ns,
                    questionnaire=self._questionnaire.name,
                    item=item.id,
                    value=value,
                    phase=place.phase,
                    block=place.block,
                    condition=place.condition,
                    occasion=self._occasion,
                    latency_ns=latency_ns,
                    changes=self._answers.changes[index] - 1,
                )
            )

    def values(self) -> dict[str, int]:
        """Return the answers that have a value, by item."""
        found = {}
        for index, item in enumerate(self._questionnaire.items):
            value = self._answers.value(index)
            if value is not None and item.kind != "text":
                found[item.id] = value
        return found

    def _score(self, t_ns: int, out: Outbox) -> None:
        if self._context.rules < 1:
            return
        for scale, score in self._questionnaire.scores(self.values()).items():
            out.events.append(
                InstrumentScored(
                    t_ns=t_ns,
                    questionnaire=self._questionnaire.name,
                    version=self._questionnaire.version,
                    scale=scale,
                    score=score,
                    phase=self._place.phase,
                    block=self._place.block,
                    condition=self._place.condition,
                    occasion=self._occasion,
                )
            )

    def header(self) -> str:
        """Return the words at the top left."""
        if self._place.phase == Phase.THREE:
            return block_finished(self._context, self._place.block)
        if self._place.phase == Phase.PRACTICE:
            return self._context.say("Before we start")
        return self._context.say("At the end")

    def screen(self) -> Screen:
        """Return the questions of the page as they are answered so far."""
        form = self._questionnaire
        first, last, count = self._page.start + 1, self._page.stop, len(form.items)
        again = self._occasion == "after_reveal"
        say, prompt = self._context.say, self._context.say(form.prompt)
        return SurveyScreen(
            header_left=self.header(),
            header_right=self._numbers(first, last, count),
            title=say(form.title),
            prompt=say("Now that you know your points: {prompt}", prompt=_lower_first(prompt))
            if again
            else prompt,
            items=tuple(self._item(place) for place in self._page),
            focus=self._focus,
            complete=not any(self._answers.is_open(place) for place in self._page),
            reminder=self._reminder,
            first=first,
        )

    def _numbers(self, first: int, last: int, count: int) -> str:
        """Return which of the questions are on the page."""
        say = self._context.say
        if count == 1:
            return say("One question")
        if last == first:
            return say("Question {first} of {count}", first=first, count=count)
        if last - first + 1 == count:
            return say("Questions {first} to {last}", first=first, last=last)
        return say("Questions {first} to {last} of {count}", first=first, last=last, count=count)

    def _item(self, place: int) -> SurveyItem:
        form, item = self._questionnaire, self._questionnaire.items[place]
        low, high = {
            "scale": (form.low, form.high),
            "choice": (1, len(item.options)),
            "number": (item.least, item.most),
            "text": (0, LONGEST_TEXT),
        }[item.kind]
        return SurveyItem(
            item=item.id,
            text=self._context.say(item.text),
            low=low,
            high=high,
            labels=tuple(
                (value, self._context.say(words)) for value, words in form.value_labels(item)
            )
            if item.kind == "scale"
            else (),
            value=self._answers.value(place),
            kind=item.kind,
            step=form.step if item.kind == "scale" else 1,
            options=tuple(self._context.say(words) for words in item.options),
            typed=self._answers.typed(place),
        )


class SurveyStage(Form):
    """A questionnaire of the protocol's."""

    def __init__(self, plan: SurveyPlan, context: Context) -> None:
        questionnaire = context.questionnaires[plan.questionnaire]
        super().__init__(questionnaire, plan.place, plan.occasion, context)


def _lower_first(text: str) -> str:
    return text[:1].lower() + text[1:]
