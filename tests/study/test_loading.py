"""Where protocols and questionnaires are found, and what is refused before it is read."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from protocols import ROOT, variant
from study.errors import ProtocolError, StudyError
from study.experiment.protocol import load_experiment
from study.loading import MAX_BYTES, find_protocol, load_protocol, shipped_protocols


@pytest.mark.parametrize("given", ["smoke", "smoke.toml", "protocols/smoke.toml"])
def test_shipped_protocols_are_found_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, given: str
) -> None:
    """From any folder the shipped ones can be named."""
    monkeypatch.chdir(tmp_path)
    assert find_protocol(given) == shipped_protocols() / "smoke.toml"


def test_a_file_goes_before_a_shipped_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Who has a smoke.toml in this folder means that one."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "smoke.toml").write_text("")
    assert find_protocol("smoke.toml") == Path("smoke.toml")


@pytest.mark.parametrize("given", ["nowhere.toml", "elsewhere/smoke.toml", "", "../smoke"])
def test_missing_file_lists_the_shipped_ones(given: str) -> None:
    """The message says what could be named instead."""
    with pytest.raises(StudyError) as caught:
        find_protocol(given)
    assert "pilot, scaled_autonomy, simulation, smoke" in str(caught.value)


def test_what_cannot_be_run_is_not_offered() -> None:
    """An experiment is no protocol of a session, nor the other way round."""
    with pytest.raises(StudyError) as caught:
        load_protocol("nowhere")
    assert "scaled_autonomy, smoke." in caught.value.hint
    with pytest.raises(StudyError) as caught:
        load_experiment("nowhere")
    assert caught.value.hint.endswith("one of: simulation.")
    with pytest.raises(StudyError) as caught:
        load_protocol("simulatio")
    assert "Did you mean" not in caught.value.hint


def test_a_mistyped_name_is_guessed(tmp_path: Path) -> None:
    """The nearest shipped one is asked for; a folder is said to be one."""
    with pytest.raises(StudyError) as caught:
        find_protocol("smokee")
    assert 'Did you mean "smoke"?' in str(caught.value)
    with pytest.raises(StudyError, match="is a folder; a protocol is a file"):
        find_protocol(str(tmp_path))


def test_text_and_hash_are_the_file_s_bytes(tmp_path: Path) -> None:
    """What is recorded is the file as it is, Windows line ends included."""
    path = variant(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"\n", b"\r\n"))
    loaded = load_protocol(str(path))
    assert loaded.text.encode() == path.read_bytes()
    assert loaded.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"\xff\xfe\x00", "UTF-16 text, not UTF-8"),
        ("format = 1".encode("utf-16-be"), "UTF-16 text, not UTF-8"),
        (b"format = 1\n# \xe9", "not UTF-8 text: line 2 has the byte 0xe9"),
        (b"#" * (MAX_BYTES + 1), f"at most {MAX_BYTES}"),
        (b"", "format: missing"),
        (b"\x00", "not TOML"),
    ],
    ids=["utf-16", "utf-16 unmarked", "latin", "huge", "empty", "zero"],
)
def test_files_that_are_no_protocol(tmp_path: Path, content: bytes, words: str) -> None:
    """Other files are refused with the reason."""
    path = tmp_path / "x.toml"
    path.write_bytes(content)
    with pytest.raises(StudyError) as caught:
        load_protocol(str(path))
    assert words in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_byte_order_mark_is_passed_over(tmp_path: Path) -> None:
    """Windows' editors put one before UTF-8; what is recorded and hashed has none."""
    path = variant(tmp_path)
    plain = load_protocol(str(path))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    loaded = load_protocol(str(path))
    assert (loaded.text, loaded.sha256) == (plain.text, plain.sha256)


def test_a_wrong_questionnaire_hides_no_other_mistake(tmp_path: Path) -> None:
    """The file of a questionnaire is one more thing that may be wrong."""
    folder = tmp_path / "questionnaires"
    folder.mkdir()
    (folder / "ease_and_success.toml").write_text("[")
    with pytest.raises(ProtocolError) as caught:
        load_protocol(str(variant(tmp_path, ('up = "up"', 'up = "flurb"'))))
    of_key, of_questionnaire = caught.value.problems
    assert of_key.startswith("keys.up:")
    assert of_questionnaire.startswith(f"{folder / 'ease_and_success.toml'}: not TOML")


def test_questionnaire_beside_the_protocol_is_used(tmp_path: Path) -> None:
    """A folder questionnaires/ beside the protocol goes before the shipped one."""
    shipped = ROOT / "protocols" / "questionnaires" / "ease_and_success.toml"
    folder = tmp_path / "questionnaires"
    folder.mkdir()
    mine = folder / "ease_and_success.toml"
    mine.write_text(shipped.read_text().replace("version = 1", "version = 7"))
    loaded = load_protocol(str(variant(tmp_path)))
    assert loaded.questionnaires["ease_and_success"].version == 7
    recorded = json.loads(loaded.questionnaires_json())
    assert recorded["ease_and_success"]["version"] == 7


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('name = "ease_and_success"', 'name = "other"', '"other" given; must be the file'),
        ("version = 1", "version = 0", "version: 0 given"),
    ],
)
def test_wrong_questionnaire_names_its_own_file(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    """What is wrong in a questionnaire is said of its file."""
    shipped = ROOT / "protocols" / "questionnaires" / "ease_and_success.toml"
    folder = tmp_path / "questionnaires"
    folder.mkdir()
    mine = folder / "ease_and_success.toml"
    assert old in shipped.read_text()
    mine.write_text(shipped.read_text().replace(old, new))
    with pytest.raises(ProtocolError) as caught:
        load_protocol(str(variant(tmp_path)))
    assert str(mine) in str(caught.value)
    assert words in str(caught.value)


def test_a_gate_at_a_scorer_that_learns_nothing_is_refused(tmp_path: Path) -> None:
    """A control measures nothing, so that its gate would fail for every participant."""
    gated = '[scorers.control]\nname = "random"\n\n[scorers.control.gate]\n\n[practice]'
    path = variant(tmp_path, ("[practice]", gated), base="scaled_autonomy")
    with pytest.raises(ProtocolError) as caught:
        load_protocol(str(path))
    assert 'scorers.control.gate: given for "random", which learns nothing' in str(caught.value)


def test_pictures_of_a_task_without_any_are_refused(tmp_path: Path) -> None:
    """Nothing could be recorded; the message says what to write instead."""
    path = variant(tmp_path)
    text = path.read_text()
    path.write_text(text + '\n[recording]\npictures = "none"\n')
    assert load_protocol(str(path)).protocol.recording.pictures == "none"
    path.write_text(text + '\n[recording]\npictures = "jpeg"\n')
    with pytest.raises(ProtocolError, match=r"recording\.pictures") as caught:
        load_protocol(str(path))
    assert 'the task "navigation" takes no pictures' in str(caught.value)
    path.write_text(text + '\n[recording]\npictures = "png"\n')
    with pytest.raises(ProtocolError, match=r"recording\.pictures"):
        load_protocol(str(path))
