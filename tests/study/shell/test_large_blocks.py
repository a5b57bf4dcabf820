"""What surfaces took for a moment is given back to the system."""

from __future__ import annotations

import ctypes
import subprocess
import sys

import pytest

PROGRAM = """
import ctypes, os, sys
os.environ["SDL_VIDEODRIVER"] = "dummy"
import pygame
from study.shell.window import Window

class Heap(ctypes.Structure):
    _fields_ = [(name, ctypes.c_size_t) for name in
                ("arena", "ordblks", "smblks", "hblks", "hblkhd",
                 "usmblks", "fsmblks", "uordblks", "fordblks", "keepcost")]

libc = ctypes.CDLL(None)
libc.mallinfo2.restype = Heap
if sys.argv[1] == "window":
    Window((1280, 960)).close()
pygame.Surface((2048, 2048))
before = libc.mallinfo2().hblkhd
kept = [pygame.Surface((512, 512), depth=32) for _ in range(32)]
print(libc.mallinfo2().hblkhd - before)
"""


@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "mallinfo2"), reason="another library than glibc allocates"
)
@pytest.mark.parametrize(("opened", "mapped"), [("window", True), ("nothing", False)])
def test_a_large_surface_is_a_mapping_of_its_own(opened: str, mapped: bool) -> None:
    """So it is once a window was opened, and was not before: else this would prove nothing."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, opened], capture_output=True, text=True, check=True
    )
    # Some may find room in holes of the heap.
    assert (int(done.stdout.splitlines()[-1]) >= 16 * 512 * 512 * 4) == mapped


HOLES = """
import pygame
from study.allocation import give_holes_back

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096

surfaces = [pygame.Surface((64, 64), depth=32) for _ in range(2048)]
kept = surfaces[::16]
surfaces.clear()
before = resident()
give_holes_back()
print(before - resident())
"""


@pytest.mark.skipif(
    not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="another library than glibc allocates"
)
def test_holes_among_small_surfaces_are_given_back() -> None:
    """Of 32 MiB of which every sixteenth block is still used most is given back."""
    done = subprocess.run([sys.executable, "-c", HOLES], capture_output=True, text=True, check=True)
    assert int(done.stdout.splitlines()[-1]) > 24 << 20
