"""A new file that is never overwritten, never buffered and only then renamed.

Loaded by the writer process, so it imports the standard library only.
"""

from __future__ import annotations

import os
from pathlib import Path

PART_SUFFIX = ".part"

# macOS and Windows have no fdatasync.
_sync = getattr(os, "fdatasync", os.fsync)


class DurableFile:
    """A file written straight to the operating system, under ``NAME.part`` until published.

    It has the few methods that ``mcap.writer.Writer`` calls on its stream. It is no
    ``io.RawIOBase``, since the Writer would wrap that in a buffer of its own.

    Args:
        final_path: the name that the file gets once it is complete.

    Raises:
        FileExistsError: there is a file of the final or of the unfinished name.
    """

    def __init__(self, final_path: Path) -> None:
        self.final_path = final_path
        self.part_path = final_path.with_name(final_path.name + PART_SUFFIX)
        if os.path.lexists(final_path):
            raise FileExistsError(None, "it exists already", str(final_path))
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        self._descriptor = os.open(self.part_path, flags, 0o600)
        self._written = 0
        _sync_folder(final_path.parent)

    def write(self, data: bytes) -> int:
        """Hand all of `data` to the operating system."""
        rest = memoryview(data)
        while rest:
            rest = rest[os.write(self._descriptor, rest) :]
        self._written += len(data)
        return len(data)

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self._written

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

    def sync(self) -> None:
        """Wait until everything written is on the disk."""
        _sync(self._descriptor)

    def publish(self) -> Path:
        """Close the file and give it its final name, without ever replacing another file.

        Raises:
            FileExistsError: a file took the final name meanwhile; ours keeps ``.part``.
        """
        self.sync()
        os.close(self._descriptor)
        try:
            os.link(self.part_path, self.final_path)
        except FileExistsError:
            raise
        except OSError:
            # A file system without hard links. The name is claimed by an empty file, which
            # ours then replaces: nobody else's file can be in the way.
            os.close(os.open(self.final_path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600))
            self.part_path.replace(self.final_path)
        else:
            self.part_path.unlink()
        _sync_folder(self.final_path.parent)
        return self.final_path


def _sync_folder(folder: Path) -> None:
    """Bring the folder's list of names to the disk, where the platform can."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
