"""Families of exchangeable members: one file each, named in protocols by the file's stem."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

from study.errors import StudyError, UnknownNameError

_NOT_MEMBERS = {"base", "registry", "features"}


def known_members(package: str) -> list[str]:
    """Return the stems of a family's files, sorted: ``known_members("study.tasks")``."""
    module = importlib.import_module(package)
    names = (info.name for info in pkgutil.iter_modules(module.__path__))
    return sorted(name for name in names if name not in _NOT_MEMBERS and name[0] != "_")


def load_member(package: str, family: str, name: str) -> ModuleType:
    """Import the member of a family that a protocol names.

    A file may stand for many members, as one for all environments of a library. It then has a
    function ``member`` that makes one from what the name says after a colon.

    Args:
        package: "study.tasks", "study.policies" or "study.scorers".
        family: what the user calls it: "task", "policy", "scorer".
        name: the member's name: the file's stem, or "STEM:NAME".

    Raises:
        UnknownNameError: there is no such file; the message lists those there are.
        StudyError: the file cannot be imported, or makes no member of that name.
    """
    known = known_members(package)
    stem, colon, rest = name.partition(":")
    if stem not in known:
        raise UnknownNameError(family, name, known)
    try:
        module = importlib.import_module(f"{package}.{stem}")
    except StudyError:
        raise
    except Exception as error:
        # The file may be somebody's own, with whatever mistake.
        raise StudyError(
            f'the {family} "{stem}" cannot be imported: {type(error).__name__}: {error}',
            f"Mend {package.replace('.', '/')}/{stem}.py.",
        ) from error
    if not colon:
        return module
    if not hasattr(module, "member"):
        raise UnknownNameError(family, name, known)
    made: ModuleType = module.member(rest)
    return made
