"""Where sockets are: in a folder of the user's alone, or nowhere."""

from __future__ import annotations

import os
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from study.console import finding, places
from study.errors import StudyError

pytestmark = pytest.mark.skipif(os.name != "posix", reason="consoles need Unix sockets")


@pytest.fixture
def runtime(monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """The one place there is, with a short path."""
    with tempfile.TemporaryDirectory(prefix="sa") as folder:
        place = Path(folder) / "c"
        monkeypatch.setattr(places, "candidates", lambda: [place])
        yield place


def test_the_folder_is_made_for_its_owner_alone(runtime: Path) -> None:
    path = places.socket_path("abc0")
    assert path == runtime / "abc0.sock"
    assert runtime.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("how", ["open to all", "a link", "a file"])
def test_a_folder_that_is_not_private_is_not_used(runtime: Path, how: str) -> None:
    """Nothing is put there, and nothing there is believed."""
    if how == "open to all":
        runtime.mkdir(mode=0o700)
        runtime.chmod(0o755)
    elif how == "a link":
        (runtime.parent / "real").mkdir(mode=0o700)
        runtime.symlink_to(runtime.parent / "real")
    else:
        runtime.touch()
    with pytest.raises(StudyError, match="no folder for the console's socket"):
        places.socket_path("abc0")
    assert list(places.sockets()) == []
    assert finding.find_sessions() == []


def test_odd_names_and_long_paths_are_refused(
    runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(StudyError, match="no session's identifier"):
        places.socket_path("../x")
    monkeypatch.setattr(places, "candidates", lambda: [runtime / ("x" * 90)])
    with pytest.raises(StudyError, match="too long"):
        places.socket_path("abc0")


def test_what_a_killed_session_left_is_cleared_away(runtime: Path) -> None:
    """Refused there, its socket goes; a file that is no socket stays, and is not asked."""
    path = places.socket_path("abc0")
    with socket.socket(socket.AF_UNIX) as gone:
        gone.bind(str(path))
    (runtime / "note.sock").write_text("not a socket")
    assert finding.find_sessions() == []
    assert [each.name for each in runtime.iterdir()] == ["note.sock"]


def test_a_session_that_says_nothing_is_listed_as_silent(
    runtime: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It may be stopped: it is neither lost nor waited for."""
    monkeypatch.setattr(finding, "PATIENCE_S", 0.05)
    path = places.socket_path("abc0")
    with socket.socket(socket.AF_UNIX) as silent:
        silent.bind(str(path))
        silent.listen()
        (found,) = finding.find_sessions()
        assert found.status is None
        assert "does not answer" in found.name
        assert path.exists()
