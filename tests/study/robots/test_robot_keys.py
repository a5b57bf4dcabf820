"""Key files are private, and refused if they are not."""

from __future__ import annotations

from pathlib import Path

import pytest

from extras import need
from study.errors import StudyError
from study.robots.keys import PUBLIC_FILE, make_keys, read_pair, read_public

need("zmq")


def test_private_files_are_their_owners_alone(tmp_path: Path) -> None:
    """Private files and their folder are closed to others; public keys match."""
    folder = tmp_path / "keys"
    written = make_keys(folder, ["operator", "robot1"])
    assert folder.stat().st_mode & 0o777 == 0o700
    for path in written[:2]:
        assert path.stat().st_mode & 0o777 == 0o600
    public = read_public(folder / PUBLIC_FILE)
    assert public == {name: read_pair(folder / f"{name}.toml").public for name in public}
    assert len(set(public.values())) == 2
    assert read_pair(written[0]).secret not in repr(read_pair(written[0]))
    assert read_pair(written[0]).secret not in (folder / PUBLIC_FILE).read_text()


def test_keys_are_not_replaced(tmp_path: Path) -> None:
    """A second set in the same folder would lock robots out."""
    make_keys(tmp_path / "keys", ["operator"])
    with pytest.raises(StudyError, match="holds keys already"):
        make_keys(tmp_path / "keys", ["operator"])


def test_readable_private_keys_are_refused(tmp_path: Path) -> None:
    """A private key that others can read is not used."""
    path = make_keys(tmp_path / "keys", ["operator"])[0]
    path.chmod(0o640)
    with pytest.raises(StudyError, match="others can read"):
        read_pair(path)


@pytest.mark.parametrize(
    "text", ["", "public = 1\nsecret = 2\n", "[", "public = 'short'\nsecret = 'short'\n", "a" * 99]
)
def test_other_files_are_no_keys(tmp_path: Path, text: str) -> None:
    """Files of other content are refused in words."""
    path = tmp_path / "operator.toml"
    path.write_text(text)
    path.chmod(0o600)
    with pytest.raises(StudyError, match="key"):
        read_pair(path)


def test_names_are_file_names(tmp_path: Path) -> None:
    """A name cannot lead out of the folder."""
    for name in ("../operator", "public_keys", ""):
        with pytest.raises(StudyError, match="cannot name a robot"):
            make_keys(tmp_path / "keys", [name])
