"""How a recording says that it is one: names and digests shared by writing and reading."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping

PROFILE = "scaled_autonomy"
"""MCAP profile of our files, and name of the metadata record that identifies them."""

FORMAT_VERSION = 1
"""Raised when a reader of the version before could misread a file."""

SELF_DIGEST = "metadata_sha256"
ATTACHMENT_DIGEST = "sha256:"
"""Before an attachment's name, in the metadata: the key of its SHA-256."""


def metadata_digest(metadata: Mapping[str, str]) -> str:
    """Return the SHA-256 of all metadata but the digest itself, hexadecimal.

    MCAP protects chunks by checksums, but not metadata.
    """
    items = sorted((key, value) for key, value in metadata.items() if key != SELF_DIGEST)
    return hashlib.sha256(json.dumps(items).encode()).hexdigest()


PART = "part"
"""Key of a part's number in the metadata; a file without it is part 1."""

PILOT = "pilot"
"""Key that is "true" in the metadata of a pilot's recording."""

CHANNELS = "channels"
"""Key of the topics in order of their channels, from 1: JSON. With it, what follows a lost
first chunk, which declares the channels, can still be told apart."""

SALVAGED_FROM = "salvaged_from_sha256"
SALVAGED_LOSSES = "salvaged_losses"
SALVAGED_BY_TOPIC = "salvaged_lost_by_topic"
SALVAGED_PROBLEMS = "salvaged_problems"
SALVAGED_NUMBERS = "salvaged_numbers"
"""Keys that a salvaged file has besides those of its original."""
