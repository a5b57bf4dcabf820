"""How much a recording's pictures take, against what they are as pixels.

python -m benchmarks.recorded_pictures RECORDING

For each fleet size and number of robots shown at once: how many moments there are, bytes of
pictures a second of driving, and what part that is of the pixels. The last line is for all of the
session's driving, and for the file.
"""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path

from study.events.shell import PicturesTaken
from study.protocol import parse_protocol
from study.recording.parts import read_whole_session


def main(path: Path) -> int:
    """Measure one recording; return the exit status."""
    session = read_whole_session(path)
    text = session.attachments["protocol.toml"].decode()
    rate = parse_protocol(text, path.name).timing.timesteps_per_second
    moments: Counter[tuple[int, int]] = Counter()
    stored: Counter[tuple[int, int]] = Counter()
    pixels: Counter[tuple[int, int]] = Counter()
    for _, record in session.records(PicturesTaken.topic):
        assert isinstance(record, PicturesTaken)
        kind = record.robots, len(record.shown)
        moments[kind] += 1
        stored[kind] += len(record.data)
        pixels[kind] += 3 * record.width * record.height * len(record.shown)
    if not moments:
        print(f"{path.name} holds no pictures")
        return 1
    print("robots  shown  moments  kB/s of driving  of the pixels")
    for (robots, shown), count in sorted(moments.items()):
        kind = robots, shown
        speed, part = stored[kind] * rate / count / 1e3, stored[kind] / pixels[kind]
        print(f"{robots:6d}  {shown:5d}  {count:7d}  {speed:15.0f}  {part:13.3f}")
    seconds = moments.total() / rate
    size = sum(part.path.stat().st_size for part in session.parts)
    print(
        f"{seconds:.0f} s driven, {stored.total() / seconds / 1e3:.0f} kB/s of pictures, "
        f"{stored.total() / pixels.total():.3f} of their pixels; the file has {size / 1e6:.0f} MB"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
