"""The answers of a survey in progress: values, texts, and when each was changed last."""

from __future__ import annotations

from study.questionnaire import LONGEST_TEXT, TENS_FROM, Questionnaire

SECOND_DIGIT_NS = 2_000_000_000
"""How long a digit on a scale to more than 9 waits for the next one."""


class TypedDigits:
    """Digits typed one after another to answer on a scale to more than 9."""

    def __init__(self) -> None:
        self._place = -1
        self._digits = ""
        self._last_ns = 0

    def add(self, place: int, digit: int, high: int, t_ns: int) -> int:
        """Take in one more; return the number that those typed make.

        Args:
            place: of the question.
            digit: 0 to 9.
            high: the scale's highest value: a digit that would go beyond it begins anew.
            t_ns: session time.
        """
        more = f"{self._digits}{digit}"
        waited = place == self._place and t_ns - self._last_ns <= SECOND_DIGIT_NS
        self._digits = more if waited and int(more) <= high else str(digit)
        self._place, self._last_ns = place, t_ns
        alone = len(self._digits) == 1 and high >= TENS_FROM
        return int(self._digits) * (10 if alone else 1)

    def forget(self) -> None:
        """Let the next digit be a first one."""
        self._place = -1


class Answers:
    """One answer an item, none to begin with.

    Attributes:
        changes: how often each answer was set.
        changed_ns: session time of the last change.
    """

    def __init__(self, questionnaire: Questionnaire) -> None:
        self._questionnaire = questionnaire
        self._items = questionnaire.items
        count = len(self._items)
        self._values: list[int | None] = [None] * count
        self._typed = [""] * count
        self.changes = [0] * count
        self.changed_ns = [0] * count

    def value(self, place: int) -> int | None:
        """Return an answer; None while it is open. A text's is its length."""
        return self._values[place]

    def typed(self, place: int) -> str:
        """Return the characters typed."""
        return self._typed[place]

    def is_open(self, place: int) -> bool:
        """Whether an answer is still needed."""
        item = self._items[place]
        if item.kind == "text":
            return not (item.optional or self._typed[place].strip())
        return self._values[place] is None

    def set(self, place: int, value: int, t_ns: int) -> bool:
        """Give an answer; return whether that changed it."""
        return self._put(place, value, t_ns)

    def digit(self, place: int, digit: int, t_ns: int) -> bool:
        """Take a digit in: a value, an option, tens of a long scale, or a number's next digit."""
        item, scale = self._items[place], self._questionnaire
        if item.kind == "number":
            return self._type_number(place, f"{self._typed[place]}{digit}", t_ns)
        if item.kind == "scale" and scale.high > 9:
            # In recordings by older rules a digit goes for tens, and the arrows do the rest.
            return self.near(place, digit * 10, t_ns)
        return scale.takes(item, digit) and self._put(place, digit, t_ns)

    def near(self, place: int, number: int, t_ns: int) -> bool:
        """Answer on a scale with what is nearest to a number; return whether that changed it."""
        scale = self._questionnaire
        value = scale.low + round((number - scale.low) / scale.step) * scale.step
        return scale.takes(self._items[place], value) and self._put(place, value, t_ns)

    def move(self, place: int, by: int, t_ns: int) -> bool:
        """Go to the next answer up (1) or down (-1)."""
        item, scale = self._items[place], self._questionnaire
        if item.kind == "choice":
            low, high, step = 1, len(item.options), 1
        elif item.kind == "scale":
            low, high, step = scale.low, scale.high, scale.step
        else:
            return False
        value = self._values[place]
        # The first arrow starts from the middle, so that neither end is nearer.
        middle = low + (high - low) // (2 * step) * step
        wanted = middle if value is None else min(high, max(low, value + by * step))
        return self._put(place, wanted, t_ns)

    def type(self, place: int, text: str, t_ns: int) -> bool:
        """Add characters to a free text."""
        if self._items[place].kind != "text":
            return False
        kept = "".join(letter for letter in text if letter.isprintable())
        return self._type_text(place, (self._typed[place] + kept)[:LONGEST_TEXT], t_ns)

    def delete(self, place: int, t_ns: int) -> bool:
        """Take the last character away."""
        kind, shorter = self._items[place].kind, self._typed[place][:-1]
        if kind == "text":
            return self._type_text(place, shorter, t_ns)
        return kind == "number" and self._type_number(place, shorter, t_ns)

    def _type_text(self, place: int, text: str, t_ns: int) -> bool:
        if text == self._typed[place]:
            return False
        self._typed[place] = text
        self._values[place] = len(text)
        self.changes[place] += 1
        self.changed_ns[place] = t_ns
        return True

    def _type_number(self, place: int, text: str, t_ns: int) -> bool:
        value = int(text) if text else -1
        if text == self._typed[place] or value > self._items[place].most:
            # A digit too many is not taken in: no number would come of any that follow.
            return False
        self._typed[place] = text
        return self._put(place, value if self._takes(place, value) else None, t_ns)

    def _takes(self, place: int, value: int) -> bool:
        return self._questionnaire.takes(self._items[place], value)

    def _put(self, place: int, value: int | None, t_ns: int) -> bool:
        if self._values[place] == value:
            return False
        self._values[place] = value
        self.changes[place] += 1
        self.changed_ns[place] = t_ns
        return True
