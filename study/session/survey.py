"""The survey stage: items answered by digits, arrows, Tab and pointer; Enter confirms."""

from __future__ import annotations

from study.events.events import QuestionAnswered
from study.events.inputs import Input, KeyChanged, PointerPressed
from study.screens import Screen, SurveyItem, SurveyScreen
from study.session.context import Context, Outbox
from study.session.effects import EnsureDurable, Show
from study.session.plan import SurveyPlan
from study.session.stage import QuietStage


class SurveyStage(QuietStage):
    """One questionnaire on one occasion. Nothing is preselected."""

    kind = "survey"

    def __init__(self, plan: SurveyPlan, context: Context) -> None:
        self._plan = plan
        self._context = context
        self._questionnaire = context.questionnaires[plan.questionnaire]
        count = len(self._questionnaire.items)
        self._values: list[int | None] = [None] * count
        self._changes = [0] * count
        self._changed_ns = [0] * count
        self._focus = 0
        self._entered_ns = 0
        self._reminder = ""

    def enter(self, t_ns: int, out: Outbox) -> bool:  # noqa: ARG002 - stages are entered alike
        """Start the latency clock."""
        self._entered_ns = t_ns
        return False

    def handle(self, given: Input, out: Outbox) -> bool:
        """Take in keys and pointer."""
        done = False
        if isinstance(given, KeyChanged) and given.down:
            done = self._key(given.key, given.t_ns, out)
        elif isinstance(given, PointerPressed):
            done = self._pointer(given.target, given.t_ns, out)
        else:
            return False
        if not done:
            out.effects.append(Show(self.screen()))
        return done

    def _key(self, key: str, t_ns: int, out: Outbox) -> bool:
        keys = self._context.protocol.keys
        count = len(self._values)
        if key.isdecimal() and self._questionnaire.accepts(int(key)):
            if self._focus < count:
                self._answer(self._focus, int(key), t_ns)
                self._focus = self._next_open()
        elif key in (keys.left, keys.right) and self._focus < count:
            self._move(1 if key == keys.right else -1, t_ns)
        elif key in (keys.next_robot, keys.down):
            self._focus = (self._focus + 1) % (count + 1)
        elif key == keys.up:
            self._focus = (self._focus - 1) % (count + 1)
        elif key == keys.confirm:
            return self._confirm(t_ns, out)
        return False

    def _pointer(self, target: str, t_ns: int, out: Outbox) -> bool:
        if target == "confirm":
            return self._confirm(t_ns, out)
        kind, _, rest = target.partition(":")
        item, _, value = rest.partition(":")
        ids = [entry.id for entry in self._questionnaire.items]
        if item in ids:
            self._focus = ids.index(item)
            if kind == "answer" and value.isdecimal() and self._questionnaire.accepts(int(value)):
                self._answer(self._focus, int(value), t_ns)
        return False

    def _answer(self, place: int, value: int, t_ns: int) -> None:
        if self._values[place] != value:
            self._values[place] = value
            self._changes[place] += 1
            self._changed_ns[place] = t_ns
        self._reminder = ""

    def _move(self, by: int, t_ns: int) -> None:
        scale = self._questionnaire
        value = self._values[self._focus]
        # The first arrow starts from the middle, so that neither end is nearer.
        middle = (scale.low + scale.high) // 2
        wanted = middle if value is None else min(scale.high, max(scale.low, value + by))
        self._answer(self._focus, wanted, t_ns)

    def _next_open(self) -> int:
        count = len(self._values)
        later = [place for place in range(count) if self._values[place] is None]
        return later[0] if later else count

    def _confirm(self, t_ns: int, out: Outbox) -> bool:
        if any(value is None for value in self._values):
            self._focus = self._next_open()
            self._reminder = "Please answer this question first."
            return False
        place = self._plan.place
        for index, item in enumerate(self._questionnaire.items):
            value = self._values[index]
            if value is not None:
                out.events.append(
                    QuestionAnswered(
                        t_ns=t_ns,
                        questionnaire=self._questionnaire.name,
                        item=item.id,
                        value=value,
                        phase=place.phase,
                        block=place.block,
                        condition=place.condition,
                        occasion=self._plan.occasion,
                        latency_ns=self._changed_ns[index] - self._entered_ns,
                        changes=self._changes[index] - 1,
                    )
                )
        out.effects.append(EnsureDurable())
        return True

    def screen(self) -> Screen:
        """Return the questions as they are answered so far."""
        scale = self._questionnaire
        count = len(scale.items)
        again = self._plan.occasion == "after_reveal"
        blocks = len(self._context.order)
        return SurveyScreen(
            header_left=f"Part 3 of 4, block {self._plan.place.block} of {blocks}: finished",
            header_right=f"Questions 1 to {count}" if count > 1 else "One question",
            title=scale.title,
            prompt=f"Now that you know your points: {_lower_first(scale.prompt)}"
            if again
            else scale.prompt,
            items=tuple(
                SurveyItem(
                    item=item.id,
                    text=item.text,
                    low=scale.low,
                    high=scale.high,
                    labels=scale.value_labels(),
                    value=value,
                )
                for item, value in zip(scale.items, self._values, strict=True)
            ),
            focus=self._focus,
            complete=all(value is not None for value in self._values),
            reminder=self._reminder,
        )


def _lower_first(text: str) -> str:
    return text[:1].lower() + text[1:]
