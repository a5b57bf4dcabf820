"""Key files of the robot link: who may drive, and which robot is which.

Each party has a key pair of its own. Its private file holds both halves and is its owner's
alone; the file of public keys can be copied anywhere.
"""

from __future__ import annotations

import dataclasses
import importlib
import re
from pathlib import Path
from typing import Any

from study.errors import StudyError
from study.toml_text import decoded, parse_toml
from study.whole_file import replace_text

PUBLIC_FILE = "public_keys.toml"
OPERATOR = "operator"
MAX_BYTES = 64_000

KEY_PATTERN = re.compile(r"[!-~]{40}")
_NAME = re.compile(r"[a-z][a-z0-9_]{0,30}")


def load_zmq() -> Any:  # noqa: ANN401 - an extra
    """Import pyzmq.

    Raises:
        StudyError: it is not installed, or cannot encrypt.
    """
    try:
        zmq = importlib.import_module("zmq")
    except ImportError as error:
        raise StudyError(
            "the robot link needs pyzmq, which is not installed",
            "In a clone `make jetbot`, elsewhere pip install 'scaled-autonomy[jetbot]'.",
        ) from error
    if not zmq.has("curve"):
        raise StudyError(
            "this pyzmq was built without CURVE: the robot link would not be encrypted",
            "Install pyzmq from PyPI: its wheels have it.",
        )
    return zmq


@dataclasses.dataclass(frozen=True, slots=True)
class KeyPair:
    """Keys as 40 characters each (Z85). The secret one is not shown."""

    public: str
    secret: str = dataclasses.field(repr=False)


def make_keys(folder: Path, names: list[str]) -> list[Path]:
    """Make a key pair for each name, and the file of their public keys.

    Args:
        folder: for the files; made if it is missing, for its owner alone. Git ignores it.
        names: "operator" and the robots'.

    Returns:
        The files written: NAME.toml, private, and `PUBLIC_FILE`.

    Raises:
        StudyError: a name is none, there are keys already, or the folder cannot be written.
    """
    zmq = load_zmq()
    for name in names:
        if not _NAME.fullmatch(name) or f"{name}.toml" == PUBLIC_FILE:
            raise StudyError(
                f'"{name}" cannot name a robot', "Use small letters, digits and underscores."
            )
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        there = sorted(path.name for path in folder.glob("*.toml"))
        if there:
            raise StudyError(
                f"{folder} holds keys already: {', '.join(there)}",
                "New keys would lock the robots out that have the old ones; name another folder.",
            )
        # Whatever else is kept in a repository: private keys are not.
        replace_text(folder / ".gitignore", "*\n")
        written, public = [], []
        for name in names:
            public_key, secret_key = (key.decode() for key in zmq.curve_keypair())
            path = folder / f"{name}.toml"
            text = f"public = {_quoted(public_key)}\nsecret = {_quoted(secret_key)}\n"
            replace_text(path, text, private=True)
            written.append(path)
            public.append(f"{name} = {_quoted(public_key)}\n")
        replace_text(folder / PUBLIC_FILE, "".join(public))
    except OSError as error:
        raise StudyError(f"{folder}: keys cannot be written: {error.strerror}") from error
    return [*written, folder / PUBLIC_FILE]


def read_pair(path: Path) -> KeyPair:
    """Read a private key file.

    Raises:
        StudyError: it is missing, others can read it, or it holds no key pair.
    """
    values = _read(path)
    if set(values) != {"public", "secret"}:
        raise StudyError(f"{path}: not a private key file", _HINT)
    if path.stat().st_mode & 0o077:
        raise StudyError(f"{path}: others can read this private key", f"Run: chmod 600 {path}")
    return KeyPair(values["public"], values["secret"])


def read_public(path: Path) -> dict[str, str]:
    """Read public keys by name.

    Raises:
        StudyError: the file is missing or holds something else.
    """
    return _read(path)


_HINT = "Make keys with: study robot-keys FOLDER"


def _read(path: Path) -> dict[str, str]:
    try:
        with path.open("rb") as stream:
            raw = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise StudyError(f"{path}: cannot be read: {error.strerror}", _HINT) from error
    try:
        values = parse_toml(decoded(raw[:MAX_BYTES], str(path)), str(path))
    except StudyError as error:
        raise StudyError(f"{path}: not a key file", _HINT) from error
    for name, key in values.items():
        if not isinstance(key, str) or not KEY_PATTERN.fullmatch(key):
            raise StudyError(f"{path}: {name} is no key", _HINT)
    return values


def _quoted(key: str) -> str:
    """Quote for TOML; Z85 has neither quotes nor backslashes."""
    return f'"{key}"'
