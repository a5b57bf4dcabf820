"""An experiment's files: whole, checked, and never trusted."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from study.errors import StudyError
from study.trial_files import (
    Head,
    Tables,
    file_name,
    read_results,
    read_trial,
    results_sha256,
    write_head,
    write_trial,
)
from study.trial_tables import COLUMNS

TEXT = "[experiment]\n"


def _head() -> Head:

    return Head(TEXT, hashlib.sha256(TEXT.encode()).hexdigest(), "held_out", {"python": "3"})


def _tables(trial: int, reward: float = 1.5) -> Tables:
    examples: dict[str, object] = {"whole": 2, "text": "luce", "number": reward}
    return {
        name: [{c: examples[kind] for c, (kind, _) in columns.items()} | {"trial": trial}]
        for name, columns in COLUMNS.items()
    }


def _write(folder: Path, trial: int, reward: float = 1.5, seconds: float = 1.0) -> Path:
    return write_trial(
        folder,
        trial,
        _tables(trial, reward),
        protocol_sha256=_head().sha256,
        seconds=seconds,
        versions={"numpy": "2"},
    )


def test_what_is_written_is_read(tmp_path: Path) -> None:
    """Head and trials come back, in order of their numbers, to the last digit."""
    folder = tmp_path / "results"
    write_head(folder, _head())
    _write(folder, 3, 0.1 + 0.2)
    _write(folder, 1)
    found = read_results(folder)
    assert found.head == _head()
    assert [each.trial for each in found.trials] == [1, 3]
    assert found.trials[1].tables == _tables(3, 0.1 + 0.2)
    assert found.damaged == ()


def test_hashes_are_of_results_not_of_times(tmp_path: Path) -> None:
    """Equal results have equal hashes, however long they took; another number changes them."""
    write_head(tmp_path / "results", _head())
    paths = [
        _write(tmp_path / "results", 0, *numbers)
        for numbers in ((1.0, 1.0), (1.0, 9.0), (2.0, 1.0))
    ]
    assert paths[0] == paths[1]
    hashes = []
    for numbers in ((1.0, 1.0), (1.0, 9.0), (2.0, 1.0)):
        path = _write(tmp_path / "results", 0, *numbers)
        hashes.append(results_sha256([read_trial(path, _head().sha256)]))
    assert hashes[0] == hashes[1] != hashes[2]


def test_every_changed_digit_is_found(tmp_path: Path) -> None:
    """A file whose content was changed is named and not used."""
    folder = tmp_path / "results"
    write_head(folder, _head())
    path = _write(folder, 0, 1.25)
    path.write_text(path.read_text().replace("1.25", "1.26", 1))
    found = read_results(folder)
    assert found.trials == ()
    assert found.damaged == ((path.name, f"{path.name}: damaged: its hash differs"),)


@pytest.mark.parametrize(
    "content",
    [b"", b"{", b"[]", b"\xff", b'{"format": 2}', b'{"format": 1, "kind": "trial"}', b"NaN",
     b"[" * 100_000],
)  # fmt: skip
def test_what_is_no_trial_is_refused(tmp_path: Path, content: bytes) -> None:
    """Torn, foreign and hostile files are errors of ours, never tracebacks."""
    path = tmp_path / file_name(0)
    path.write_bytes(content)
    with pytest.raises(StudyError):
        read_trial(path, _head().sha256)


def test_a_row_of_another_shape_is_never_written(tmp_path: Path) -> None:
    """A missing column, a wrong type and a number that is none are refused before writing."""
    for change in ({"team_reward": "much"}, {"goals": True}, {"scorer": None}, {"more": 1}):
        tables = _tables(0)
        tables["runs"][0] = tables["runs"][0] | change
        with pytest.raises(StudyError):
            write_trial(tmp_path, 0, tables, protocol_sha256="", seconds=0.0, versions={})
    assert list(tmp_path.iterdir()) == []


def test_a_folder_holds_one_experiment(tmp_path: Path) -> None:
    """Another protocol's, another seed set's and foreign folders are refused."""
    folder = tmp_path / "results"
    write_head(folder, _head())
    write_head(folder, _head())
    with pytest.raises(StudyError, match="other seeds"):
        write_head(folder, Head(TEXT, _head().sha256, "development", {}))
    with pytest.raises(StudyError, match="another protocol"):
        write_head(folder, Head("x", "0" * 64, "held_out", {}))
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "thesis.txt").write_text("mine")
    with pytest.raises(StudyError, match="other files"):
        write_head(foreign, _head())


def test_a_head_that_was_changed_is_refused(tmp_path: Path) -> None:
    """The protocol in the folder is the one that its hash is of."""
    folder = tmp_path / "results"
    write_head(folder, _head())
    path = folder / "experiment.json"
    record = json.loads(path.read_text())
    path.write_text(json.dumps(record | {"protocol": "[other]\n"}))
    with pytest.raises(StudyError, match="damaged"):
        read_results(folder)
