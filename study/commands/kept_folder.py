"""The folder of a study's recordings, for commands that begin nothing in it."""

from __future__ import annotations

from pathlib import Path

from study.commands.clearing import is_simulated
from study.errors import StudyError
from study.recording.enrolled import TOMBSTONES
from study.recording.register_folders import has_register, recordings_under, register_folder


def check_kept(folder: Path) -> None:
    """Refuse a folder that holds nothing of a study: looking into it would make a register there.

    Raises:
        StudyError: it is not there, is a file, has neither register nor recordings, or has no
            register and recordings of simulated participants only, or those of a folder above.
    """
    if not folder.is_dir():
        what = "is a file" if folder.exists() else "is not there"
        raise StudyError(f"no folder {folder}: it {what}", "Give the folder of the recordings.")
    if has_register(folder) or (folder / TOMBSTONES).exists():
        return
    if above := register_folder(folder):
        raise StudyError(
            f"the recordings in {folder} belong to the register of the folder {above}",
            "Give that folder.",
        )
    recordings = recordings_under(folder)
    if not recordings:
        raise StudyError(
            f"{folder} holds neither a register of participants nor recordings",
            "Give the folder of the recordings; `study run` makes it.",
        )
    if all(map(is_simulated, recordings)):
        raise StudyError(
            f"no people took part in {folder}: all {len(recordings)} recordings there are of "
            "simulated participants",
            "Give the folder of the sessions with people; `study run` makes it.",
        )
