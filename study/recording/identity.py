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
