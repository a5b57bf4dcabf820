"""Errors that a user can cause. Commands print them as one message, never a traceback."""

from __future__ import annotations

from typing import ClassVar

from study.spelling import closest


class StudyError(Exception):
    """Something that the user can mend; the message says what was given and what to do.

    Args:
        message: what was given and what was expected.
        hint: what to do about it.

    Attributes:
        exit_status: with which a command ends that shows it.
    """

    exit_status: ClassVar[int] = 2

    def __init__(self, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.hint = hint

    def __str__(self) -> str:
        return f"{self.message}\n  {self.hint}" if self.hint else self.message

    @property
    def sentence(self) -> str:
        """All of it as one sentence without its full stop, to stand within other text."""
        hint = self.hint
        # What does not begin as a sentence does, such as a name in capitals, stays as it is.
        if hint[:1].isupper() and hint[1:2].islower():
            hint = hint[0].lower() + hint[1:]
        parts = (" ".join(part.split()).removesuffix(".") for part in (self.message, hint))
        return "; ".join(filter(None, parts))

    def __reduce__(self) -> tuple[object, ...]:
        """Let the error cross from a worker process, whatever its class is made from."""
        return _rebuilt, (type(self), self.args, self.__dict__)


def _rebuilt(kind: type[StudyError], args: tuple[object, ...], attributes: object) -> StudyError:
    error = kind.__new__(kind, *args)
    vars(error).update(attributes)  # type: ignore[call-overload]
    return error


class ProtocolError(StudyError):
    """A protocol file that cannot be used: one entry a problem.

    Args:
        source: the file's name.
        problems: each a full sentence with key path, what was given and what is allowed.
    """

    def __init__(self, source: str, problems: list[str]) -> None:
        count = "1 problem" if len(problems) == 1 else f"{len(problems)} problems"
        lines = "\n".join(f"  {problem}" for problem in problems)
        super().__init__(f"{source}: {count}\n{lines}")
        self.source = source
        self.problems = problems


class RecordingError(StudyError):
    """A file that is no recording of ours, is damaged, or is newer than this program."""


class RecordingFailedError(StudyError):
    """A session could not be recorded to its end; the message says what of it is safe."""

    exit_status = 4


class UnknownNameError(StudyError):
    """A name that no file of its family has.

    Args:
        family: "task", "policy", "scorer" or "questionnaire".
        given: the name given.
        known: the names there are.
    """

    def __init__(self, family: str, given: str, known: list[str]) -> None:
        near = closest(given, known)
        hint = f'Did you mean "{near}"? ' if near else ""
        super().__init__(f'unknown {family} "{given}"', f"{hint}Known: {', '.join(sorted(known))}")
        self.given = given
        self.known = known
