"""Families of exchangeable members: one file each, named in protocols by the file's stem."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

from study.errors import UnknownNameError

_NOT_MEMBERS = {"base", "registry", "features"}


def known_members(package: str) -> list[str]:
    """Return the stems of a family's files, sorted: ``known_members("study.tasks")``."""
    module = importlib.import_module(package)
    names = (info.name for info in pkgutil.iter_modules(module.__path__))
    return sorted(name for name in names if name not in _NOT_MEMBERS and name[0] != "_")


def load_member(package: str, family: str, name: str) -> ModuleType:
    """Import the member of a family that a protocol names.

    Args:
        package: "study.tasks", "study.policies" or "study.scorers".
        family: what the user calls it: "task", "policy", "scorer".
        name: the member's name.

    Raises:
        UnknownNameError: there is no such file; the message lists those there are.
    """
    known = known_members(package)
    if name not in known:
        raise UnknownNameError(family, name, known)
    return importlib.import_module(f"{package}.{name}")
