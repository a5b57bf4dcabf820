"""A stand-in for a participant who uses the keyboard alone, or the mouse wherever it is of use."""

from __future__ import annotations

import random
import subprocess
import time

from onlooker import Aim, Onlooker
from study.loading import LoadedProtocol
from study.messages import messages_for
from study.screens import (
    BreakScreen,
    EndScreen,
    FleetScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    Screen,
    SurveyItem,
    SurveyScreen,
)
from study.session.consent import Consent
from x11_driver import Hands

SIZE = (1280, 960)
AGE, WORDS = "27", "fine"
READING_S = 0.7
"""Longer than a questionnaire is deaf to keys."""
CHECK = "Is everything clear?"
"""Title of the comprehension check, whose first attempt is to fail."""


class SeatedParticipant:
    """Acts on what the screen shows, once all that was done before has been recorded.

    Args:
        hands: what presses.
        onlooker: what sees.
        study: the running program.
        mouse: whether all is clicked but driving; else all is typed.
        seed: of the choices made.
    """

    def __init__(
        self,
        hands: Hands,
        onlooker: Onlooker,
        study: subprocess.Popen[bytes],
        *,
        mouse: bool,
        seed: int = 1,
    ) -> None:
        self._hands = hands
        self._onlooker = onlooker
        self._study = study
        self._mouse = mouse
        self._random = random.Random(seed)
        self._aim = Aim(SIZE)
        self._choices: dict[str, int] = {}
        self._gone_back = False
        self._misunderstood = False

    def agree(self, loaded: LoadedProtocol) -> None:
        """Agree to the consent; what is pressed until then is in no recording."""
        consent = Consent(loaded.protocol, messages_for(loaded.protocol.study.language))
        self._hands.wait_for_window()
        # The first screen is drawn and keys are looked at soon after the window is there.
        time.sleep(1.0)
        if self._mouse:
            for target in ("agree", "confirm"):
                self._hands.click(*self._aim.at(consent.screen(), target))
                consent.point(target)
                time.sleep(0.3)
            self._hands.clicked.clear()
        else:
            self._hands.tap("y")
            self._hands.key("return", down=True)
            self._hands.sent.clear()
        while self._onlooker.look() is None:
            assert self._study.poll() is None
            time.sleep(0.05)
        if not self._mouse:
            # Lifted once all is recorded, so that this half of the tap is for certain.
            self._hands.key("return", down=False)

    def go_through(self, timeout_s: float) -> None:
        """Go on to the end of the session."""
        deadline = time.monotonic() + timeout_s
        while self._study.poll() is None:
            assert time.monotonic() < deadline, "the session did not end in time"
            screen = self._onlooker.look()
            if screen is None or not self._all_recorded():
                time.sleep(0.02)
            elif isinstance(screen, EndScreen):
                self._close(screen)
                self._study.wait(max(1.0, deadline - time.monotonic()))
            else:
                self._act(screen)

    def _all_recorded(self) -> bool:
        hands, seen = self._hands, self._onlooker
        return len(seen.keys) >= len(hands.sent) and len(seen.presses) >= len(hands.clicked)

    def _act(self, screen: Screen) -> None:
        if isinstance(screen, FleetScreen) and screen.allocation != "none":
            self._operate(screen)
        elif isinstance(screen, SurveyScreen):
            self._answer(screen)
        elif isinstance(screen, PageScreen) and screen.can_go_back and not self._gone_back:
            self._gone_back = True
            self._press(screen, "backspace", "back")
        elif isinstance(screen, PageScreen | RevealScreen | BreakScreen | PauseScreen):
            # A busy disk pauses; nobody asked for it.
            target = "continue" if isinstance(screen, PauseScreen) else "confirm"
            self._press(screen, "return", target)
        else:
            # Nothing is asked for: a countdown, a fit, robots that drive on their own.
            time.sleep(0.02)

    def _press(self, screen: Screen, key: str, target: str) -> None:
        if self._mouse:
            self._hands.click(*self._aim.at(screen, target))
        else:
            self._hands.tap(key)

    def _close(self, screen: EndScreen) -> None:
        """Close the last screen: it goes at the press, so that a release would find no window."""
        if self._mouse:
            self._hands.click(*self._aim.at(screen, "confirm"))
        else:
            self._hands.key("return", down=True)

    def _operate(self, screen: FleetScreen) -> None:
        if screen.allocation in ("manual", "suggested") and screen.robots > 1:
            self._choose(screen)
        # After the first practice comes the check: a key too late must not answer it.
        turns = ["left", "right"] if screen.trials else []
        self._hands.tap(
            self._random.choice(["up", "up", "up", "down", *turns]),
            hold_s=self._random.choice([0.02, 0.15, 0.3]),
        )

    def _choose(self, screen: FleetScreen) -> None:
        """Choose a robot; the ways there are take turns, so that each is used for certain."""
        if self._mouse:
            robot = screen.suggested
            if robot < 0:
                robot = self._random.randrange(screen.robots)
            self._hands.click(*self._aim.at(screen, f"robot:{robot}"))
            return
        other = screen.accept_key if screen.suggested >= 0 else "tab"
        number = screen.robot_keys[(screen.operated + 2) % screen.robots]
        way = self._choices.get(screen.allocation, 0)
        self._choices[screen.allocation] = way + 1
        self._hands.tap((other, number)[way % 2])

    def _answer(self, screen: SurveyScreen) -> None:
        """Answer what is open on the page, from the focus on, or confirm it."""
        if screen.complete and self._written(screen):
            self._press(screen, "return", "confirm")
        elif self._mouse:
            for item in screen.items:
                if item.value is None:
                    self._click_answer(screen, item)
        else:
            self._type_answers(screen)

    def _type_answers(self, screen: SurveyScreen) -> None:
        """Answer one question; or all, if none is answered and the first has the focus."""
        focused = screen.items[screen.focus : screen.focus + 1]
        if not focused or self._answered(focused[0]):
            # The last key that drove may have come too late, and moved the focus or answered.
            self._hands.tap("tab")
            return
        untouched = screen.focus == 0 and not any(map(self._answered, screen.items))
        if untouched:
            # A questionnaire is deaf to keys at first.
            time.sleep(READING_S)
        for item in screen.items if untouched else focused:
            # A short answer moves the focus on by itself, to the next open question.
            self._type_answer(screen, item)

    def _written(self, screen: SurveyScreen) -> bool:
        """Whether free texts, which may stay empty, are as they are to be."""
        return self._mouse or all(item.typed == WORDS for item in screen.items
                                  if item.kind == "text")  # fmt: skip

    def _answered(self, item: SurveyItem) -> bool:
        return item.typed == WORDS if item.kind == "text" else item.value is not None

    def _wanted(self, screen: SurveyScreen, item: SurveyItem) -> int:
        """Return an answer to choose."""
        if screen.title == CHECK:
            self._misunderstood, before = True, self._misunderstood
            return 1 if before else 2
        return self._random.randrange(item.low, item.high + 1, item.step)

    def _type_answer(self, screen: SurveyScreen, item: SurveyItem) -> None:
        if item.kind in ("text", "number"):
            for sign in WORDS if item.kind == "text" else AGE:
                self._hands.tap(sign)
            self._hands.tap("tab")
        elif item.high > 9 or (screen.title != CHECK and self._random.random() < 0.3):
            # Arrows alone: the first answers in the middle.
            for _ in range(self._random.randint(1, 3)):
                self._hands.tap(self._random.choice(["left", "right"]))
            self._hands.tap("tab")
        else:
            self._hands.tap(str(self._wanted(screen, item)))

    def _click_answer(self, screen: SurveyScreen, item: SurveyItem) -> None:
        if item.kind == "number":
            for digit in AGE:
                self._hands.click(*self._aim.at(screen, f"digit:{item.item}:{digit}"))
        elif item.kind != "text":
            target = f"answer:{item.item}:{self._wanted(screen, item)}"
            self._hands.click(*self._aim.at(screen, target))
