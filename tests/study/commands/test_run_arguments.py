"""What `study run` is given is checked before anybody has a slot or a pseudonym."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import pytest

from command_line import study
from protocols import variant
from study.commands.given import check_given
from study.commands.recorded_scorers import recorded_weights
from study.commands.simulating import simulate_session, simulated_assignments
from study.enrolment.register import Register
from study.errors import StudyError
from study.loading import load_protocol
from study.preflight_result import Check, Preflight, keep_preflight

OWN_SCORER = (
    'name = "luce"\nfit_budget_seconds = 30.0\n\n'
    "[scorers.luce.parameters]\nhidden = [32, 32]\nepochs = EPOCHS\nweight_decay = 1.0\n"
)


def with_recorded_scorer(folder: Path, base: str = "smoke", epochs: int = 10) -> str:
    """Write a protocol whose scorer "luce" comes from another participant's recording."""
    change = (OWN_SCORER.replace("EPOCHS", str(epochs)), 'name = "recorded"\n')
    return str(variant(folder, change, base=base))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of navigation, in which scorers were fitted."""
    loaded = load_protocol("smoke")
    (simulated,) = simulated_assignments(loaded, 1, seed=1)
    return simulate_session("smoke", simulated, 1, tmp_path_factory.mktemp("other"))


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--scorer", "luce=nope.mcap"], "no recording"),
        (["--scorer", "luce=torn.mcap"], "torn.mcap"),
        (["--scorer", "luce"], "NAME=PATH"),
        ([], "comes from a recording, and none is named"),
        (["--scorer", "luce=nope.mcap", "--resume"], "no recording"),
    ],
    ids=" ".join,
)
def test_recordings_of_scorers_are_looked_at_before_a_slot_is_taken(
    tmp_path: Path, words: list[str], message: str
) -> None:
    """No pseudonym is drawn and no register made for a session that cannot begin."""
    protocol, folder = with_recorded_scorer(tmp_path), tmp_path / "recordings"
    (tmp_path / "torn.mcap").write_bytes(b"torn")
    done = study("run", protocol, "-o", folder, *words, folder=tmp_path)
    assert done.returncode == 2
    assert message in done.stderr
    assert "Participant" not in done.stdout
    assert not folder.exists()


def test_a_scorer_must_be_in_the_recording_and_fit_the_task(
    tmp_path: Path, recording: Path
) -> None:
    """Both are known before the session begins; what fits is taken as it is."""
    loaded = load_protocol(with_recorded_scorer(tmp_path))
    assert list(recorded_weights(loaded, {"luce": str(recording)})) == ["scorer:luce"]
    carts = load_protocol(with_recorded_scorer(tmp_path, "cart_pole", 100))
    with pytest.raises(StudyError, match=rf"{recording.name}: .*does not fit this task"):
        recorded_weights(carts, {"luce": str(recording)})
    other = ('name = "recorded"\n', 'name = "recorded"\nparameters.scorer = "novelty"\n')
    path = tmp_path / "novelty.toml"
    path.write_text(Path(loaded.path).read_text().replace(*other))
    with pytest.raises(StudyError, match='holds no scorer "novelty"'):
        recorded_weights(load_protocol(str(path)), {"luce": str(recording)})
    with pytest.raises(StudyError, match="no scorer from a recording"):
        recorded_weights(loaded, {"luce": str(recording), "classifier": str(recording)})


@pytest.mark.parametrize(
    "words",
    [["--live", "--live-host", "203.0.113.1"], ["--order", "manual"], ["--size", "1x1"]],
    ids=" ".join,
)
def test_other_arguments_are_looked_at_before_a_slot_is_taken(
    tmp_path: Path, words: list[str]
) -> None:
    """An address that is none of this computer's, an order that is none, a window too small."""
    folder = tmp_path / "recordings"
    done = study("run", "smoke", "-o", folder, *words)
    assert done.returncode == 2
    assert "Participant" not in done.stdout
    assert not folder.exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["-p", "Jane"], "looks like a name"),
        (["-p", "P 01"], "P 01"),
        (["--order", "manual"], "is no order of these conditions"),
        (["--resume", "--order", "manual"], "--resume keeps"),
        (["--scorer", "luce"], "NAME=PATH"),
        ([], "is red"),
    ],
    ids=" ".join,
)
def test_a_slip_is_told_before_a_red_preflight(
    tmp_path: Path, words: list[str], message: str
) -> None:
    """Who mends the computer first would learn only then of the mistake; no register is made."""
    utc = datetime.now(UTC).isoformat(timespec="seconds")
    red = Check(name="disk", state="red", found="full", wanted="room")
    keep_preflight(
        tmp_path,
        Preflight(utc=utc, host="h", protocol="p", protocol_sha256="0", seconds=1.0, checks=(red,)),
    )
    done = study("run", "smoke", "-o", tmp_path, *words)
    assert done.returncode == 2
    assert message in done.stderr
    assert (" is red" in done.stderr) == (not words)
    assert [path.name for path in tmp_path.iterdir()] == ["preflight.json"]


def test_who_took_part_under_a_name_still_can(tmp_path: Path) -> None:
    """Such an id is in every file already."""
    loaded = load_protocol("smoke")
    with Register(tmp_path) as register:
        register.reserve("smoke", [("manual", "assisted")], pseudonym="Jane")
    check_given(loaded, "Jane", "", tmp_path)
    with pytest.raises(StudyError, match="looks like a name"):
        check_given(loaded, "Janet", "", tmp_path)
