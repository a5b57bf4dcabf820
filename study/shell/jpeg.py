"""Pictures as JPEG and back; what is to be unpacked may come from anybody.

SDL_image's own encoder, at its own quality of 85 of 100: no other library is needed, neither where
robots are stepped nor where a recording is watched.
"""

from __future__ import annotations

import io
import struct
from typing import Final

import numpy as np
import numpy.typing as npt
import pygame

from study.recording.pictures import MAX_BYTES, MAX_SIDE

Picture = npt.NDArray[np.uint8]

_START, _BASELINE, _SCAN = 0xD8, 0xC0, 0xDA
_SIZE: Final = struct.Struct(">BHHB")
"""In a frame's header: bits a colour, height, width, colours."""


def to_jpeg(pixels: Picture) -> bytes:
    """Compress a picture, uint8 [height, width, 3].

    Raises:
        ValueError: it is larger than any that `from_jpeg` takes.
    """
    height, width = pixels.shape[:2]
    if not (0 < height <= MAX_SIDE and 0 < width <= MAX_SIDE):
        raise ValueError(f"{width}x{height} pixels; a side has at most {MAX_SIDE}")
    packed = io.BytesIO()
    surface = pygame.image.frombuffer(pixels.tobytes(), (width, height), "RGB")
    pygame.image.save(surface, packed, "picture.jpg")
    data = packed.getvalue()
    if len(data) > MAX_BYTES:
        raise ValueError(f"{len(data)} bytes once compressed; a picture has at most {MAX_BYTES}")
    return data


def from_jpeg(data: bytes, size: tuple[int, int]) -> Picture | None:
    """Return a picture, uint8 [height, width, 3].

    Args:
        data: compressed; whatever it is, no more than the size says is unpacked.
        size: width and height that it must have, pixels.

    Returns:
        None where it is no such picture.
    """
    if len(data) > MAX_BYTES or max(size) > MAX_SIDE or jpeg_size(data) != size:
        return None
    try:
        surface = pygame.image.load(io.BytesIO(data), "picture.jpg")
    except (pygame.error, MemoryError):
        return None
    if surface.get_size() != size:
        return None
    # Axes swapped: pygame counts columns first.
    return np.ascontiguousarray(pygame.surfarray.array3d(surface).swapaxes(0, 1))


def jpeg_size(data: bytes) -> tuple[int, int] | None:
    """Return width and height that a picture's header states, without unpacking it.

    Returns:
        None where it is no picture as `to_jpeg` makes them: baseline, three colours of eight bits.
    """
    if data[:2] != bytes([0xFF, _START]):
        return None
    found, place = None, 2
    try:
        while data[place] == 0xFF:
            mark = data[place + 1]
            if mark == _SCAN:
                return found
            if mark == _BASELINE:
                bits, height, width, colours = _SIZE.unpack_from(data, place + 4)
                if found is not None or (bits, colours) != (8, 3):
                    return None
                found = width, height
            elif 0xC0 < mark <= 0xCF and mark not in (0xC4, 0xCC):
                # Another kind of frame: progressive ones can cost any time to unpack.
                return None
            place += 2 + int.from_bytes(data[place + 2 : place + 4], "big")
    except (IndexError, struct.error):
        return None
    return None
