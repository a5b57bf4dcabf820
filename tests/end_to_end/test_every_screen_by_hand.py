"""Every screen that there is, passed in a real window by the keyboard alone and by the mouse."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from analysis.commands.report import write_report
from onlooker import Onlooker
from patience import PATIENCE_S
from protocols import variant
from real_study import ROOT, real_study
from seated_participant import AGE, WORDS, SeatedParticipant
from study.events.codes import Phase
from study.events.events import (
    QuestionAnswered,
    RewardRevealed,
    StageEntered,
    Suggestion,
    SwitchAnnounced,
    Switched,
    Timestep,
    TrialStarted,
)
from study.events.inputs import Input, SessionOpened, TextTyped
from study.events.participant_events import (
    ComprehensionChecked,
    ConsentGiven,
    InstrumentScored,
    PracticeChecked,
    TextAnswered,
)
from study.loading import load_protocol
from study.recording.reader import Recording, read_recording
from study.recording.wire import decode
from study.screens import (
    BreakScreen,
    CountdownScreen,
    EndScreen,
    FleetScreen,
    PageScreen,
    RevealScreen,
    Screen,
    SurveyScreen,
    WaitScreen,
)
from study.session.session import Session
from study.verification import verify
from x11_driver import Hands

STAGES = {
    ("pages", "welcome"), ("pages", "practice"), ("pages", "explanation"), ("pages", "phase_one"),
    ("pages", "phase_two"), ("pages", "phase_three"), ("pages", "debrief"), ("pages", "thanks"),
    ("trial", "trial"), ("check", "comprehension"), ("fit", "fit"), ("survey", "survey"),
    ("reveal", "reveal"), ("break", "break"),
}  # fmt: skip
DRIVING = {"up", "down", "left", "right"}
CHOSEN_BY = {False: {"number", "tab", "accept"}, True: {"pointer"}}


def run_session(protocol: str, folder: Path, *, mouse: bool) -> tuple[Path, Hands]:
    """Go through a session by real events; return its recording and the hands."""
    with real_study(protocol, folder) as (hands, study):
        participant = SeatedParticipant(hands, Onlooker(folder), study, mouse=mouse)
        participant.agree(load_protocol(protocol))
        participant.go_through(PATIENCE_S)
    assert study.returncode == 0
    (path,) = folder.glob("*.mcap")
    return path, hands


def screens_of(recording: Recording) -> list[Screen]:
    """Return what was shown after each input."""
    session, found = Session(), []
    for raw in recording.raw("input"):
        given: Input = decode(raw.topic, raw.data)  # type: ignore[assignment]
        session.handle(given)
        assert session.screen is not None
        found.append(session.screen)
    return found


def check_screens(recording: Recording) -> None:
    """Check by the recording's events, and their replay, that each kind of screen was seen."""
    events = [record for _, record in recording.records()]
    assert {(e.kind, e.name) for e in events if isinstance(e, StageEntered)} >= STAGES
    trials = [event for event in events if isinstance(event, TrialStarted)]
    assert {t.allocation for t in trials} == {
        "correction", "manual", "suggested", "assisted", "none"
    }  # fmt: skip
    assert {trial.view for trial in trials} >= {"operated_only", "enlarged", "tiles"}
    assert {type(event) for event in events} >= {
        ConsentGiven, InstrumentScored, PracticeChecked, RewardRevealed, Suggestion,
        SwitchAnnounced, TextAnswered,
    }  # fmt: skip
    checks = [event.passed for event in events if isinstance(event, ComprehensionChecked)]
    assert checks == [False, True]
    screens = screens_of(recording)
    assert {type(screen) for screen in screens} >= {
        BreakScreen, CountdownScreen, EndScreen, FleetScreen, PageScreen, RevealScreen,
        SurveyScreen, WaitScreen,
    }  # fmt: skip
    check_countdowns(events)


def check_countdowns(events: Sequence[object]) -> None:
    """Check that nobody's robots moved before the countdown's second was over."""
    started: dict[int, int] = {}
    for event in events:
        if isinstance(event, TrialStarted) and event.phase != Phase.FOUR:
            started[event.trial_id] = event.t_ns
        elif isinstance(event, Timestep) and event.timestep == 0 and event.trial_id in started:
            assert event.due_ns - started[event.trial_id] > 0.9e9


def check_answers(recording: Recording, *, mouse: bool, asked: int) -> None:
    """Check that all questions are answered, and that what was meant is what was recorded."""
    events = [record for _, record in recording.records()]
    answers = [event for event in events if isinstance(event, QuestionAnswered)]
    assert len(answers) == asked
    assert [answer.value for answer in answers if answer.item == "age"] == [int(AGE)]
    (words,) = [event.text for event in events if isinstance(event, TextAnswered)]
    typed = "".join(event.text for event in events if isinstance(event, TextTyped))
    assert words == typed == ("" if mouse else WORDS)
    causes = {event.cause for event in events if isinstance(event, Switched)}
    assert causes - {"dwell", "ended", "start"} == CHOSEN_BY[mouse]


def check_session(path: Path, hands: Hands, report: Path, *, mouse: bool, asked: int) -> None:
    """Check all that a session passed by hand, with so many questions, must leave."""
    recording = read_recording(path)
    assert recording.complete
    onlooker = Onlooker(path.parent)
    onlooker.look()
    assert onlooker.keys == hands.sent
    assert onlooker.presses == [(float(x), float(y)) for x, y in hands.clicked]
    if mouse:
        assert {key for key, _ in hands.sent} <= DRIVING
    else:
        assert not hands.clicked
    check_screens(recording)
    check_answers(recording, mouse=mouse, asked=asked)
    verdict = verify(path)
    assert verdict.matches, verdict.difference
    page = write_report([path], report).read_text()
    assert "P01" in page
    assert "Simulated participants" not in page


def short(folder: Path) -> str:
    """Return the protocol with two of its four conditions, short trials and one load index."""
    text = (ROOT / "protocols" / "every_screen.toml").read_text()
    _, manual, _, _, rest = text.split("[[conditions]]")
    return str(
        variant(
            folder,
            (f"[[conditions]]{manual}", ""),
            (f"[[conditions]]{rest.split('[phase_four]')[0]}", ""),
            ('order = "latin_square"', 'order = "ab_ba"'),
            ("trial_timesteps = 40", "trial_timesteps = 25"),
            ("attempts = 2", "attempts = 1"),
            ("episodes = 2", "episodes = 1"),
            ("trials = 2\ntrial_timesteps = 30", "trials = 1\ntrial_timesteps = 25"),
            ('"nasa_tlx"\nwhen = ["before_reveal"]', '"nasa_tlx"\nwhen = ["at_start"]'),
            base="every_screen",
        )
    )


@pytest.mark.acceptance
def test_each_screen_in_short_by_keyboard_alone(tmp_path: Path) -> None:
    """Keys pass every kind of screen of a session of two short blocks."""
    folder = tmp_path / "recordings"
    path, hands = run_session(short(tmp_path), folder, mouse=False)
    # About you, the check twice, the load index, and two questions twice in each block.
    check_session(path, hands, tmp_path / "report", mouse=False, asked=3 + 2 + 6 + 2 * 4)


@pytest.mark.acceptance
@pytest.mark.parametrize("mouse", [False, True], ids=["keyboard", "mouse"])
def test_every_screen_by_one_device_alone(tmp_path: Path, mouse: bool) -> None:
    """All four blocks are passed; beside the mouse, keys only drive."""
    folder = tmp_path / "recordings"
    path, hands = run_session("every_screen", folder, mouse=mouse)
    # Here the load index is asked for in each block.
    check_session(path, hands, tmp_path / "report", mouse=mouse, asked=3 + 2 + 4 * (6 + 4))
    opened = [record for _, record in read_recording(path).records("input/session_opened")]
    assert [len(o.order) for o in opened if isinstance(o, SessionOpened)] == [4]
