"""The protocol that shows every screen, driven from consent to the end."""

from __future__ import annotations

import dataclasses
import re

import pytest

from fake_shell import FakeShell, Moods, replayed
from short_study import opened
from study.enrolment.importing import ERASED
from study.errors import RecordingError
from study.events.codes import ChoiceSource, Phase
from study.events.events import (
    Deviation,
    Paused,
    QuestionAnswered,
    SessionEnded,
    Suggestion,
    SwitchAnnounced,
    Switched,
    Timestep,
)
from study.events.inputs import SessionOpened, TextTyped, WindowChanged
from study.events.participant_events import (
    AnswerChanged,
    ComprehensionChecked,
    ConsentGiven,
    InstrumentScored,
    PracticeChecked,
    TextAnswered,
)
from study.loading import LoadedProtocol, load_protocol
from study.questionnaire import LONGEST_TEXT
from study.recording.wire import decode, encode
from study.screens import (
    BreakScreen,
    CountdownScreen,
    EndScreen,
    FleetScreen,
    PageScreen,
    PauseScreen,
    RevealScreen,
    SurveyScreen,
    WaitScreen,
)
from study.session.effects import EraseRecording
from study.training_sets import choice_sets

ORDER = ("manual", "assisted", "suggested", "switched_at_random")
NEVER_ENDING = Moods(end_chance=0.0, longest_episode=10_000)


@pytest.fixture(scope="module")
def every_screen() -> LoadedProtocol:
    """The shipped protocol."""
    return load_protocol("every_screen")


def first_input(loaded: LoadedProtocol, **changes: object) -> SessionOpened:
    """Return the first input, with fields replaced."""
    given = opened(loaded, order=ORDER)
    for name, value in changes.items():
        object.__setattr__(given, name, value)
    return given


def at(shell: FakeShell, kind: type, title: str = "") -> None:
    """Go on until a screen of a kind, and with a title if one is given, is shown."""
    shell.go_on_until(
        lambda: (
            isinstance(shell.screen, kind)
            and (not title or getattr(shell.screen, "title", "") == title)
        )
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("moods", [Moods(), Moods(fits=("failed", "completed"))])
def test_every_screen_is_passed_and_replays(
    every_screen: LoadedProtocol, seed: int, moods: Moods
) -> None:
    """The session comes to its end, shows every kind of screen, and repeats to the byte."""
    shell = FakeShell(opened(every_screen, order=ORDER), seed, moods)
    shown: set[type] = set()
    for _ in range(3_000):
        shown.add(type(shell.screen))
        if shell.finished:
            break
        shell.help()
    assert shell.session.complete
    assert shown >= {
        BreakScreen, CountdownScreen, EndScreen, FleetScreen, PageScreen, RevealScreen,
        SurveyScreen, WaitScreen,
    }  # fmt: skip
    assert replayed(shell.inputs) == shell.log
    kinds = {type(event) for event in shell.events}
    assert kinds >= {
        AnswerChanged, ComprehensionChecked, ConsentGiven, InstrumentScored, PracticeChecked,
        QuestionAnswered, Suggestion, SwitchAnnounced,
    }  # fmt: skip


def test_consent_is_the_second_event(every_screen: LoadedProtocol) -> None:
    """Its text's hash and time stand before any stage; another text is refused."""
    given = opened(every_screen, order=ORDER)
    consent = FakeShell(given).events[1]
    assert isinstance(consent, ConsentGiven)
    assert (consent.text_sha256, consent.given_utc) == (
        given.consent_sha256, given.consented_utc
    )  # fmt: skip
    with pytest.raises(RecordingError, match="consent"):
        FakeShell(first_input(every_screen, consent_sha256="0" * 64))


def test_a_simulated_participant_is_not_asked(every_screen: LoadedProtocol) -> None:
    """No consent is recorded for it, and none is missed."""
    shell = FakeShell(first_input(every_screen, operator_kind="simulated", consent_sha256=""))
    assert not [event for event in shell.events if isinstance(event, ConsentGiven)]


@pytest.mark.parametrize(("wrong", "attempts"), [(0, 1), (1, 2), (2, 3), (3, 3)])
def test_what_was_not_understood_is_explained_twice_at_most(
    every_screen: LoadedProtocol, wrong: int, attempts: int
) -> None:
    """A right attempt ends the check; after the third the failure is recorded."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    for attempt in range(attempts):
        at(shell, SurveyScreen, "Is everything clear?")
        shell.key("2" if attempt < wrong else "1")
        shell.key("return")
        if attempt < wrong and attempt < 2:
            page = shell.screen
            assert isinstance(page, PageScreen)
            assert page.paragraphs == (
                "The robot in the blue frame is yours: the arrow keys drive it.",
            )
    at(shell, PageScreen, "Teach one robot")
    checks = [event for event in shell.events if isinstance(event, ComprehensionChecked)]
    assert [check.passed for check in checks] == [n >= wrong for n in range(attempts)]
    failed = [e for e in shell.events if isinstance(e, Deviation)]
    assert ("comprehension_failed" in [e.code for e in failed]) == (wrong == 3)


def test_practice_repeats_until_its_goals_are_reached(every_screen: LoadedProtocol) -> None:
    """Without a goal there is a second attempt with other starts, then a deviation."""
    shell = FakeShell(opened(every_screen, order=ORDER), moods=NEVER_ENDING)
    at(shell, SurveyScreen, "Is everything clear?")
    checks = [event for event in shell.events if isinstance(event, PracticeChecked)]
    assert [(check.attempt, check.passed) for check in checks] == [(1, False), (2, False)]
    assert [e.code for e in shell.events if isinstance(e, Deviation)] == ["practice_failed"]


def test_each_block_opens_with_unscored_practice_of_its_interface(
    every_screen: LoadedProtocol,
) -> None:
    """It has the block's allocation, is not fitted and is not among the block's trials."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    shell.go_to_trial(Phase.PRACTICE, "suggested")
    screen = shell.screen
    assert isinstance(screen, CountdownScreen)
    assert (screen.fleet.allocation, screen.fleet.trials) == ("suggested", 0)
    assert screen.fleet.heading == "Practice for block 3 of 4"


def test_the_countdown_runs_before_the_robots(every_screen: LoadedProtocol) -> None:
    """No timestep is asked for in it, and a key tapped in it does not act."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    shell.go_to_trial(2)
    assert isinstance(shell.screen, CountdownScreen)
    assert shell.pace == 1.0
    shell.tap("up")
    shell.due()
    assert isinstance(shell.screen, FleetScreen)
    assert shell.fleet is None
    assert shell.pace == 10.0


def test_a_suggestion_is_marked_accepted_by_one_key_and_trains_nothing(
    every_screen: LoadedProtocol,
) -> None:
    """What is suggested is recorded at every timestep; accepting is a source of its own."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    shell.go_to_trial(3, "suggested")
    shell.moods = NEVER_ENDING
    shell.go_on_until(lambda: isinstance(shell.screen, FleetScreen))
    before = shell.fleet_screen()
    assert before.suggested >= 0
    (switched,) = [event for event in shell.tap("space") if isinstance(event, Switched)]
    assert (switched.to_robot, switched.source) == (
        before.suggested, ChoiceSource.ACCEPTED_SUGGESTION
    )  # fmt: skip
    events = shell.step()
    rows = [event for event in events if isinstance(event, Timestep)]
    assert [event.suggested for event in events if isinstance(event, Suggestion)] == [
        before.suggested
    ]
    assert len(choice_sets(rows, 12, 4).chosen) == 0


def test_a_break_has_a_timer_and_ends_by_a_key(every_screen: LoadedProtocol) -> None:
    """The timer goes down by seconds; going on is possible at once without a shortest rest."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, BreakScreen)
    assert shell.pace == 1.0
    shell.due()
    rest = shell.screen
    assert isinstance(rest, BreakScreen)
    assert (rest.seconds_left, rest.wait_seconds) == (0, 0)
    shell.key("return")
    assert not isinstance(shell.screen, BreakScreen)


def test_a_number_is_typed_within_its_range(every_screen: LoadedProtocol) -> None:
    """A digit that would exceed the largest is not taken in; too small a number stays open."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, SurveyScreen, "About you")

    def shown() -> tuple[str, int | None]:
        assert isinstance(shell.screen, SurveyScreen)
        return shell.screen.items[0].typed, shell.screen.items[0].value

    for key, expected in (
        ("1", ("1", None)), ("1", ("11", None)), ("6", ("11", None)), ("backspace", ("1", None)),
        ("9", ("19", 19)), ("9", ("19", 19)),
    ):  # fmt: skip
        shell.key(key)
        assert shown() == expected
    answers = [e.value for e in shell.events if isinstance(e, AnswerChanged)]
    assert answers[-1] == 19


def test_a_number_is_entered_by_mouse_alone(every_screen: LoadedProtocol) -> None:
    """The digits beside it are clicked, and the last is deleted; what is no digit does nothing."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, SurveyScreen, "About you")
    for target, expected in (
        ("digit:age:3", ("3", None)), ("digit:age:1", ("31", 31)), ("delete:age", ("3", None)),
        ("digit:age:12", ("3", None)), ("digit:age:", ("3", None)), ("digit:age:x", ("3", None)),
        ("digit:games:1", ("3", None)), ("answer:age:40", ("3", None)), ("digit:age:4", ("34", 34)),
    ):  # fmt: skip
        shell.point(target)
        assert isinstance(shell.screen, SurveyScreen)
        assert (shell.screen.items[0].typed, shell.screen.items[0].value) == expected
        assert shell.screen.items[1].value is None
    assert [e.value for e in shell.events if isinstance(e, AnswerChanged)] == [31, -1, 34]
    assert replayed(shell.inputs) == shell.log


def test_words_are_typed_changed_and_recorded(every_screen: LoadedProtocol) -> None:
    """Letters that are keys elsewhere are only letters here."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, SurveyScreen, "In your own words")
    for letter in "quiy":
        shell.key(letter)
        shell.feed(TextTyped(shell.later(1_000_000), letter))
    shell.key("backspace")
    shell.feed(TextTyped(shell.later(1_000_000), "et Ä"))
    shell.key("return")
    (answer,) = [event for event in shell.events if isinstance(event, TextAnswered)]
    assert answer.text == "quiet Ä"


@pytest.mark.parametrize(
    ("typed", "recorded"),
    [
        ("fine \U0001f642\U0001f469\u200d\U0001f680", "fine \U0001f642\U0001f469\U0001f680"),
        (
            "\u05e9\u05dc\u05d5\u05dd \u0645\u0631\u062d\u0628\u0627",
            "\u05e9\u05dc\u05d5\u05dd \u0645\u0631\u062d\u0628\u0627",
        ),
        ("<b>=1+1</b>", "<b>=1+1</b>"),
        ("x" * 10_000, "x" * LONGEST_TEXT),
    ],
    ids=["emoji", "right to left", "markup and formula", "10,000 characters"],
)
def test_whatever_is_typed_is_recorded(
    every_screen: LoadedProtocol, typed: str, recorded: str
) -> None:
    """As it was typed but for unprintable signs, up to the length that there is room for."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, SurveyScreen, "In your own words")
    shell.feed(TextTyped(shell.later(1_000_000), typed))
    shell.key("return")
    (answer,) = [event for event in shell.events if isinstance(event, TextAnswered)]
    assert answer.text == recorded
    assert encode(decode(TextAnswered.topic, encode(answer))) == encode(answer)


def test_failing_the_practice_can_end_the_session(every_screen: LoadedProtocol) -> None:
    """Where the protocol says so, the session ends after the last attempt, with the reason."""
    parts = every_screen.text.partition("[practice]")
    practice = parts[2].replace('on_failure = "go_on"', 'on_failure = "end"', 1)
    first = opened(every_screen, order=ORDER)
    text = "".join((*parts[:2], practice))
    shell = FakeShell(dataclasses.replace(first, protocol_toml=text), moods=NEVER_ENDING)
    shell.go_on_until(lambda: shell.finished)
    (end,) = [event for event in shell.events if isinstance(event, SessionEnded)]
    assert (end.complete, end.reason) == (False, "the practice was not passed")


def test_scores_are_recorded_with_the_instrument_s_version(every_screen: LoadedProtocol) -> None:
    """The raw score is the mean of the six ratings of that block."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, RevealScreen)
    (score,) = [event for event in shell.events if isinstance(event, InstrumentScored)]
    values = [
        event.value
        for event in shell.events
        if isinstance(event, QuestionAnswered) and event.questionnaire == "nasa_tlx"
    ]
    assert len(values) == 6
    assert (score.scale, score.version, score.condition) == ("raw_tlx", 1, "manual")
    assert score.score == pytest.approx(sum(values) / 6)


def test_a_pause_offers_to_erase_after_a_second_question(every_screen: LoadedProtocol) -> None:
    """E asks, Y confirms; the session ends and asks the shell to remove its recording."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    at(shell, PageScreen, "Teach one robot")
    shell.key("escape")
    assert isinstance(shell.screen, PauseScreen)
    assert shell.screen.can_erase
    shell.key("e")
    assert isinstance(shell.screen, PauseScreen)
    assert shell.screen.confirm_erase
    assert not shell.finished
    shell.key("y")
    assert shell.finished
    assert [effect for effect in shell.effects if isinstance(effect, EraseRecording)]
    (end,) = [event for event in shell.events if isinstance(event, SessionEnded)]
    # By these words an erasure that was not finished is known.
    assert (end.complete, end.reason) == (False, ERASED)


@pytest.mark.parametrize("change", ["resized", "minimised"])
def test_a_changed_window_pauses(every_screen: LoadedProtocol, change: str) -> None:
    """It is recorded why; being restored goes on with nothing by itself."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    shell.go_to_trial(2)
    events = shell.feed(WindowChanged(shell.later(), change, 1280, 720))
    assert [event.reason for event in events if isinstance(event, Paused)] == [f"window {change}"]
    shell.feed(WindowChanged(shell.later(), "restored", 1280, 720))
    assert isinstance(shell.screen, PauseScreen)


def test_recordings_from_before_rules_had_a_version_replay_by_the_old_ones(
    every_screen: LoadedProtocol,
) -> None:
    """No change of an answer, no score and no erasing: what was recorded then follows still."""
    shell = FakeShell(first_input(every_screen, rules=0))
    at(shell, SurveyScreen, "About you")
    shell.key("escape")
    shell.key("e")
    assert isinstance(shell.screen, PauseScreen)
    assert not shell.screen.can_erase
    assert not shell.screen.confirm_erase
    at(shell, EndScreen)
    assert not [e for e in shell.events if isinstance(e, AnswerChanged | InstrumentScored)]


def test_not_understanding_can_end_the_session(every_screen: LoadedProtocol) -> None:
    """Where the protocol says so, the session ends after the last attempt, with the reason."""
    text = every_screen.text.replace(
        '[comprehension]\non_failure = "go_on"', '[comprehension]\non_failure = "end"'
    )
    assert text != every_screen.text
    shell = FakeShell(first_input(every_screen, protocol_toml=text))
    for _ in range(3):
        at(shell, SurveyScreen, "Is everything clear?")
        shell.key("2")
        shell.key("return")
    assert shell.finished
    (end,) = [event for event in shell.events if isinstance(event, SessionEnded)]
    assert (end.complete, end.reason) == (False, "the instructions were not understood")


def test_names_of_conditions_are_never_shown(every_screen: LoadedProtocol) -> None:
    """No text that a participant reads has a condition's name or label in it."""
    shell = FakeShell(opened(every_screen, order=ORDER))
    words = {"switched_at_random", "Random", "Assisted", "Suggested", "Manual"}
    for _ in range(3_000):
        screen = shell.screen
        if isinstance(screen, FleetScreen):
            texts = [screen.heading, screen.message]
        elif isinstance(screen, PageScreen):
            texts = [screen.header_left, screen.title, screen.subtitle, *screen.paragraphs]
        else:
            texts = []
        assert not [word for word in words for text in texts if word in text]
        if shell.finished:
            break
        shell.help()
    assert shell.session.complete


WORDS = (
    "heading", "message", "unit", "header_left", "header_right", "title", "subtitle", "action",
    "next_hint", "text", "prompt", "reminder", "reason", "paragraphs", "options", "labels", "keys",
    "items", "fleet",
)  # fmt: skip
KEY_NAMES = {"up", "down", "left", "right", "space", "tab", "escape"}


def words_of(value: object) -> list[str]:
    """Return all that is read on a screen."""
    if isinstance(value, str):
        return [value]
    if isinstance(value, tuple):
        return [word for item in value for word in words_of(item)]
    return [word for name in WORDS for word in words_of(getattr(value, name, ()))]


def test_the_protocol_s_language_is_that_of_every_text(every_screen: LoadedProtocol) -> None:
    """In the pseudo-locale no plain word is shown, and what is recorded is the same."""
    text = every_screen.text.replace("[study]", '[study]\nlanguage = "pseudo"')
    shell = FakeShell(first_input(every_screen, protocol_toml=text))
    plain: set[str] = set()
    for _ in range(3_000):
        for words in words_of(shell.screen):
            named = KEY_NAMES | {"left up down right"}
            if words not in named and re.search("[A-Za-z]{2}", words):
                plain.add(words)
        if shell.finished:
            break
        shell.help()
    assert plain == set()
    english = FakeShell(opened(every_screen, order=ORDER))
    at(english, EndScreen)
    assert shell.session.complete
    assert english.log == shell.log[: len(english.log)]


def test_a_language_that_is_not_known_here_is_shown_in_english(
    every_screen: LoadedProtocol,
) -> None:
    """A recording from elsewhere replays; a protocol to be run is refused before."""
    text = every_screen.text.replace("[study]", '[study]\nlanguage = "tlh"')
    shell = FakeShell(first_input(every_screen, protocol_toml=text))
    assert isinstance(shell.screen, PageScreen)
    assert shell.screen.title == "Welcome"
