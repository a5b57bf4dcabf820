"""The plan lock: made beside the protocol, carried by recordings, held against the report."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from analysis.left_out import SetAside
from analysis.plan_status import plan_status
from analysis.recordings import Session, StudyRecordings
from study.commands import main as command
from study.commands.composing import _described, lock_warning
from study.commands.lock import make_lock
from study.errors import StudyError
from study.events.inputs import SessionOpened
from study.loading import load_protocol, shipped_protocols
from study.recording.plan_lock import ATTACHMENT, PlanLock, lock_path, parse_lock, read_lock

LOCKED = "2026-01-01T00:00:00+00:00"


@pytest.fixture
def protocol(tmp_path: Path) -> Path:
    """A copy of the smoke protocol in a folder of its own."""
    path = tmp_path / "mine.toml"
    shutil.copy(shipped_protocols() / "smoke.toml", path)
    return path


@dataclasses.dataclass(frozen=True)
class LockedRecording:
    """As much of a recording as a plan's status needs."""

    attachments: dict[str, bytes]


def opened_by(lock: PlanLock, text: str, sha256: str, questionnaires: str) -> SessionOpened:
    return SessionOpened(
        t_ns=0,
        session_id="s",
        participant="P01",
        seed=1,
        order=(),
        protocol_toml=text,
        protocol_sha256=sha256,
        task_json="{}",
        operator_kind="person",
        operator_json="",
        versions_json="{}",
        started_utc="2026-02-01T00:00:00+00:00",
        planned_index=0,
        questionnaires_json=questionnaires,
        rules=1,
        consent_sha256="",
        consented_utc="",
    )


def study_of(
    lock: PlanLock, protocol: Path, *, carried: bool = True, **changes: str
) -> StudyRecordings:
    loaded = load_protocol(str(protocol))
    opened = opened_by(lock, loaded.text, loaded.sha256, loaded.questionnaires_json())
    opened = dataclasses.replace(opened, **changes)  # type: ignore[arg-type]
    attachments = {ATTACHMENT: lock.to_json().encode()} if carried else {}
    session = Session(
        file="a.mcap",
        recording=LockedRecording(attachments),  # type: ignore[arg-type]
        opened=opened,
        ended=None,
        protocol={},
        task=loaded.description,
        trials={},
        trial_ends={},
    )
    return StudyRecordings((session,), ())


def test_a_lock_reads_back_as_it_was_written(protocol: Path) -> None:
    """Writing and reading a lock loses nothing."""
    lock = make_lock(load_protocol(str(protocol)), LOCKED)
    assert parse_lock(lock.to_json().encode(), "x") == lock
    assert lock.analysis_files["plan_status.py"]


def test_what_was_locked_before_the_first_record_is_confirmatory(protocol: Path) -> None:
    """Nothing changed since: planned analyses confirm, others explore."""
    status = plan_status(study_of(make_lock(load_protocol(str(protocol)), LOCKED), protocol))
    assert status.differences == ()
    assert status.confirmatory
    assert status.label("rm_anova") == "Confirmatory"
    assert status.label("order") == "Exploratory"


def test_a_recording_without_a_lock_is_exploratory(protocol: Path) -> None:
    """Without a lock nothing is confirmatory, and the report says why."""
    lock = make_lock(load_protocol(str(protocol)), LOCKED)
    status = plan_status(study_of(lock, protocol, carried=False))
    assert not status.confirmatory
    assert "no plan lock" in status.differences[0].text


def test_a_lock_made_after_the_first_record_does_not_count(protocol: Path) -> None:
    """A session that began before its lock names the participant."""
    lock = make_lock(load_protocol(str(protocol)), "2026-03-01T00:00:00+00:00")
    status = plan_status(study_of(lock, protocol))
    assert not status.confirmatory
    assert "P01" in status.differences[0].text


def test_a_session_set_aside_that_began_before_the_lock_counts_against_it(protocol: Path) -> None:
    """Whoever was seen before the plan was fixed was seen, analysed or not."""
    study = study_of(make_lock(load_protocol(str(protocol)), LOCKED), protocol)
    after = SetAside("b.mcap", "P01", "another session", "2026-01-15T00:00:00+00:00")
    assert plan_status(dataclasses.replace(study, set_aside=(after,))).confirmatory
    early = dataclasses.replace(after, started_utc="2025-12-31T23:00:00+00:00")
    status = plan_status(dataclasses.replace(study, set_aside=(early,)))
    assert not status.confirmatory
    assert "b.mcap of P01" in status.differences[0].text


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"protocol_sha256": "other", "protocol_toml": "format = 1\n"}, "Protocol"),
        ({"exclusions": "[]", "protocol_sha256": "other"}, "Exclusions"),
        ({"questionnaires_sha256": "other"}, "Questionnaires"),
        ({"analysis_files": {"gone.py": "0"}}, "Analysis code"),
        ({"environment": {"numpy": "0"}}, "Environment"),
    ],
)
def test_what_changed_since_is_printed(
    protocol: Path, change: dict[str, object], what: str
) -> None:
    """Each thing that a lock fixes is compared, and its difference named."""
    lock = make_lock(load_protocol(str(protocol)), LOCKED)
    status = plan_status(study_of(dataclasses.replace(lock, **change), protocol))  # type: ignore[arg-type]
    assert not status.confirmatory
    assert what in {difference.what for difference in status.differences}


def test_recordings_after_a_lock_carry_it(protocol: Path) -> None:
    """What a recording starts with holds the lock's bytes; a changed protocol is told."""
    runner = CliRunner()
    result = runner.invoke(command.app, ["lock", str(protocol)])
    assert result.exit_code == 0, result.output
    loaded = load_protocol(str(protocol))
    found = read_lock(protocol)
    assert found is not None
    opened = opened_by(found[1], loaded.text, loaded.sha256, "{}")
    _, attachments, _ = _described(loaded, opened)
    assert attachments[ATTACHMENT] == lock_path(protocol).read_bytes()
    assert lock_warning(loaded) == ""
    protocol.write_text(loaded.text + "\n# changed\n")
    assert "has changed since it was locked" in lock_warning(load_protocol(str(protocol)))


def test_a_lock_is_replaced_only_when_asked(protocol: Path) -> None:
    """The same plan again is no change; another one needs --again."""
    runner = CliRunner()
    assert runner.invoke(command.app, ["lock", str(protocol)]).exit_code == 0
    before = lock_path(protocol).read_bytes()
    assert "nothing has changed" in runner.invoke(command.app, ["lock", str(protocol)]).output
    protocol.write_text(protocol.read_text() + "\n# changed\n")
    refused = runner.invoke(command.app, ["lock", str(protocol)])
    assert isinstance(refused.exception, StudyError)
    assert lock_path(protocol).read_bytes() == before
    assert runner.invoke(command.app, ["lock", str(protocol), "--again"]).exit_code == 0
    assert lock_path(protocol).read_bytes() != before


@pytest.mark.parametrize("data", [b"", b"{}", b"[]", b'{"format": 2}', b"\xff"])
def test_what_is_no_lock_is_refused_in_words(data: bytes) -> None:
    """A file that is no lock gives one message with what to do."""
    with pytest.raises(StudyError) as caught:
        parse_lock(data, "x.lock.json")
    assert "study lock" in caught.value.hint
