"""What a user is told when something is wrong."""

from __future__ import annotations

import pickle

import pytest

from study.errors import ProtocolError, RecordingError, StudyError, UnknownNameError

ERRORS = [
    StudyError("no disk", "Insert one."),
    StudyError("no disk"),
    ProtocolError("x.toml", ["a: 1 given", "b: missing"]),
    UnknownNameError("scorer", "luse", ["luce", "classifier"]),
    RecordingError("torn"),
]


def test_hint_stands_on_a_line_of_its_own() -> None:
    """The message comes first, what to do below it."""
    assert str(ERRORS[0]) == "no disk\n  Insert one."
    assert str(ERRORS[1]) == "no disk"


@pytest.mark.parametrize(
    ("error", "sentence"),
    [
        (StudyError("no disk", "Insert one."), "no disk; insert one"),
        (StudyError("no disk."), "no disk"),
        (StudyError("no disk", "CD or DVD"), "no disk; CD or DVD"),
        (
            ProtocolError("x.toml", ["a: 1 given", "b: missing"]),
            "x.toml: 2 problems a: 1 given b: missing",
        ),
    ],
    ids=["hint", "bare", "capitals", "lines"],
)
def test_an_error_within_other_text(error: StudyError, sentence: str) -> None:
    """On one line, without the full stop of whoever goes on."""
    assert error.sentence == sentence


def test_protocol_error_counts_its_problems() -> None:
    """One line a problem, under the file's name and their number."""
    assert str(ERRORS[2]).splitlines() == ["x.toml: 2 problems", "  a: 1 given", "  b: missing"]
    assert str(ProtocolError("x.toml", ["a"])).splitlines()[0] == "x.toml: 1 problem"


def test_unknown_name_offers_the_nearest() -> None:
    """The nearest known name is proposed, and all are listed."""
    assert 'Did you mean "luce"? Known: classifier, luce' in str(ERRORS[3])
    assert "Did you mean" not in str(UnknownNameError("task", "zzz", ["navigation"]))


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_errors_survive_the_way_from_a_worker_process(error: StudyError) -> None:
    """Class, message and attributes are the same on the other side."""
    again = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own, just made
    assert type(again) is type(error)
    assert str(again) == str(error)
    assert vars(again) == vars(error)
