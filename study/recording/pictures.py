"""What a recording may hold of pictures, and how they are taken out of their records.

They stay compressed here: whoever unpacks one compares its size with the record's before.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from study.events.shell import PicturesTaken

MAX_SIDE: Final = 4096
"""Longest side of a picture, pixels."""
MAX_BYTES: Final = 2**22
"""Longest picture, compressed."""
MAX_ROBOTS: Final = 1000
MAX_PIXELS: Final = 2**25
"""Of all robots' pictures together."""
MAX_DATA: Final = 2**24
"""Bytes of all pictures in one record."""


def pictures_in(record: PicturesTaken) -> dict[int, bytes] | None:
    """Take a record of pictures apart; it may come from anybody.

    Returns:
        Compressed pictures by robot; None where its numbers do not fit together, or are larger than
        those of any recording.
    """
    robots, width, height = record.robots, record.width, record.height
    changed, lengths, data = record.changed, record.lengths, record.data
    if not (0 < robots <= MAX_ROBOTS and 0 < width <= MAX_SIDE):
        return None
    if not 0 < height <= MAX_SIDE or robots * width * height > MAX_PIXELS:
        return None
    if len(data) > MAX_DATA or len(changed) != len(lengths):
        return None
    places = changed.tolist()
    if places != sorted(set(places)):
        return None
    sizes = lengths.tolist()
    if not all(0 < length <= MAX_BYTES for length in sizes) or sum(sizes) != len(data):
        return None
    ends = np.cumsum(lengths, dtype=np.int64).tolist()
    shown = set(record.shown.tolist())
    if record.encoding != "jpeg" or not set(places) <= shown <= set(range(robots)):
        return None
    return {
        robot: data[end - length : end]
        for robot, length, end in zip(places, sizes, ends, strict=True)
    }
