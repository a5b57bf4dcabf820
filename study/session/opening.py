"""What a session was opened with, read anew."""

from __future__ import annotations

import json
from typing import Any

from study.errors import RecordingError
from study.messages import SOURCE, Messages, locales, messages_for
from study.questionnaire import Questionnaire


def texts_of(language: str) -> Messages:
    """Return a language's texts; English where a recording's language is not known here."""
    return messages_for(language if language in locales() else SOURCE)


def questionnaires_of(text: str) -> dict[str, Questionnaire]:
    """Return the questionnaires that a session was opened with, by name.

    Raises:
        RecordingError: they cannot be read.
    """
    try:
        raw: dict[str, Any] = json.loads(text or "{}")
        return {name: Questionnaire.model_validate(item) for name, item in raw.items()}
    except (ValueError, AttributeError, RecursionError) as error:
        raise RecordingError(f"the questionnaires opened with cannot be read: {error}") from error
