"""`study preflight` in a real window, and what `study run` makes of its result."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from analysis.recordings import load_recordings
from analysis.tables.study_tables import StudyTables
from patience import PATIENCE_S, until
from study.commands.composing import seed_from
from study.commands.preflight import _rehearsed, preflight_before
from study.enrolment.register import Register
from study.enrolment.withdrawing import leave_tombstone
from study.errors import StudyError
from study.loading import load_protocol
from study.orders import possible_orders
from study.preflight_result import FILE
from study.verification import verify
from x11_driver import Hands, x_server


def _study(*words: str, display: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "DISPLAY": display, "SDL_VIDEODRIVER": "x11"}
    command = [sys.executable, "-m", "study.commands.main", *words]
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=180, check=False
    )


def test_red_blocks_and_an_override_is_recorded(tmp_path: Path) -> None:
    """Every check is made and kept; a red result stops `study run`, a reason lets it begin."""
    with x_server(1280, 960) as display:
        done = _study("preflight", "smoke", "-o", str(tmp_path), "--no-keys", "--json",
                      display=display)  # fmt: skip
        told = json.loads(done.stdout)
        assert "cannot be opened" not in done.stdout, done.stdout
        names = [check["name"] for check in told["checks"]]
        assert names == [
            "rehearsal", "fits", "disk space", "writing", "clock",
            "display", "fonts", "punctuality", "keyboard",
        ]  # fmt: skip
        assert (done.returncode == 3) == (told["state"] == "red")
        assert (tmp_path / FILE).stat().st_mode & 0o077 == 0

        kept = json.loads((tmp_path / FILE).read_text())
        kept["checks"][2] |= {"state": "red", "found": "2 MiB free"}
        (tmp_path / FILE).write_text(json.dumps(kept))
        refused = _study("run", "smoke", "-p", "P01", "-o", str(tmp_path), display=display)
    assert refused.returncode != 0
    assert "2 MiB free" in refused.stderr
    assert "Traceback" not in refused.stderr
    assert not list(tmp_path.glob("*.mcap*"))

    sha256 = load_protocol("smoke").sha256
    before = preflight_before(tmp_path, sha256, "the disk is emptied at noon")
    assert before.remark.endswith("begun all the same: the disk is emptied at noon")
    check_note_of_override(tmp_path)
    with pytest.raises(StudyError, match="--override-preflight"):
        preflight_before(tmp_path, sha256, "  ")


def check_note_of_override(folder: Path) -> None:
    """Begin a session although the preflight is red; check that the reason is among its notes."""
    why = "the disk is emptied at noon"
    with x_server(1280, 960) as display:
        study = subprocess.Popen(
            [sys.executable, "-m", "study.commands.main", "run", "smoke", "-p", "P01",
             "-o", str(folder), "--override-preflight", why],
            env={**os.environ, "DISPLAY": display, "SDL_VIDEODRIVER": "x11"},
        )  # fmt: skip
        hands = Hands(display)
        try:
            hands.wait_for_window()
            until(lambda: any(path.stat().st_size > 20_000 for path in folder.glob("*.part")))
        finally:
            study.terminate()
            study.wait(PATIENCE_S)
            hands.close()
    (note,) = StudyTables(load_recordings([folder])).frame("notes").to_dict("records")
    assert note["text"].startswith("Begun although the preflight is red (disk space: 2 MiB free")
    assert note["text"].endswith(why)
    (recording,) = folder.glob("*.mcap")
    assert verify(recording).matches


@pytest.mark.parametrize("together", [True, False], ids=["held together", "one after the other"])
def test_the_keyboard_is_tried_with_real_keys(tmp_path: Path, together: bool) -> None:
    """Two real keys held at once are green; the same keys one by one are red, and so is all."""
    environment = {**os.environ, "SDL_VIDEODRIVER": "x11"}
    command = [sys.executable, "-m", "study.commands.main", "preflight", "smoke", "-o",
               str(tmp_path), "--json"]  # fmt: skip
    with x_server(1280, 960) as display:
        preflight = subprocess.Popen(
            command, env={**environment, "DISPLAY": display}, stdout=subprocess.PIPE, text=True
        )
        hands = Hands(display)
        hands.wait_for_window()
        # Nobody says when the page is there: they are pressed until the preflight has ended.
        while preflight.poll() is None:
            if together:
                hands.key("up", down=True)
            else:
                hands.tap("up")
            hands.tap("left")
            if together:
                hands.key("up", down=False)
            hands.focus_whatever_is_there()
        hands.close()
        out, _ = preflight.communicate()
    (check,) = [each for each in json.loads(out)["checks"] if each["name"] == "keyboard"]
    if together:
        assert (check["state"], check["found"]) == ("green", "both arrived together")
    else:
        assert (check["state"], check["found"]) == ("red", "both arrived, never together")
        assert preflight.returncode == 3


def test_a_participants_own_sequence_is_rehearsed(tmp_path: Path) -> None:
    """Order by the register: one's own, or the one that is next; nothing is reserved by it."""
    loaded = load_protocol("smoke")
    study, design = loaded.protocol.study.name, loaded.protocol.phase_three.order
    names = [condition.name for condition in loaded.protocol.conditions]
    first, second = possible_orders(names, design)
    with Register(tmp_path) as register:
        register.reserve(study, [first, second], pseudonym="P01", order=second)
        register.start(study, "P01")

    def rehearsed(participant: str) -> tuple[str, ...]:
        return _rehearsed(loaded, participant, "", tmp_path, pilot=False).order

    assert rehearsed("P01") == second
    assert rehearsed("P02") == first
    with Register(tmp_path) as register:
        assert [each.pseudonym for each in register.participants(study)] == ["P01"]
        register.reserve(study, [first, second], pseudonym="P02")
        register.start(study, "P02")
        register.reserve(study, [first, second], pseudonym="P03")
        register.start(study, "P03")
    assert rehearsed("P04") == second
    # Pilots are balanced among themselves.
    assert _rehearsed(loaded, "P04", "", tmp_path, pilot=True).order == first
    assert _rehearsed(loaded, "P01", ",".join(first), tmp_path, pilot=False).order == first
    assert _rehearsed(loaded, "P01", "", tmp_path, pilot=False).seed == seed_from(
        f"{loaded.sha256} P01"
    )
    with pytest.raises(StudyError, match="cannot be used"):
        rehearsed("../P01")
    with Register(tmp_path) as register:
        leave_tombstone(register, study, "P03")
    with pytest.raises(StudyError, match="P03"):
        rehearsed("P03")
