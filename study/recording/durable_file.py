"""A new file that is never overwritten, never buffered and only then renamed.

Loaded by the writer process, so it imports the standard library only.
"""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path

from study.recording.file_lock import hold

PART_SUFFIX = ".part"

# macOS and Windows have no fdatasync.
_sync = getattr(os, "fdatasync", os.fsync)

_COPY_BYTES = 1 << 20


class LostFileError(OSError):
    """The file was deleted from outside and could not be put back: what it held is gone."""


class DurableFile:
    """A file written straight to the operating system, under ``NAME.part`` until published.

    It has the few methods that ``mcap.writer.Writer`` calls on its stream. It is no
    ``io.RawIOBase``, since the Writer would wrap that in a buffer of its own.

    Args:
        final_path: the name that the file gets once it is complete.
        fail_sync_after: a hook for tests: every sync after this many fails with EIO, as on a
            broken disk; None for never.

    Raises:
        FileExistsError: there is a file of the final or of the unfinished name.
    """

    def __init__(self, final_path: Path, fail_sync_after: int | None = None) -> None:
        self._syncs_left = fail_sync_after
        self.final_path = final_path
        self.part_path = final_path.with_name(final_path.name + PART_SUFFIX)
        if os.path.lexists(final_path):
            raise FileExistsError(None, "it exists already", str(final_path))
        self._descriptor = self._make()
        self._written = 0
        _sync_folder(final_path.parent)

    def write(self, data: bytes) -> int:
        """Hand all of `data` to the operating system."""
        self._written += _write_all(self._descriptor, data)
        return len(data)

    def tell(self) -> int:
        """Return the number of bytes written."""
        return self._written

    def flush(self) -> None:
        """Do nothing: there is no buffer."""

    def sync(self) -> None:
        """Wait until everything written is on the disk."""
        if self._syncs_left is not None:
            if self._syncs_left <= 0:
                raise OSError(errno.EIO, os.strerror(errno.EIO), str(self.part_path))
            self._syncs_left -= 1
        _sync(self._descriptor)

    def keep_named(self) -> bool:
        """If the file is no longer where it was made, put all of it back there.

        A file that is deleted or moved while it is open can be written on; of a deleted one
        nothing would be left at the end.

        Returns:
            Whether it had to be put back.

        Raises:
            LostFileError: it was deleted and cannot be put back.
        """
        ours = os.fstat(self._descriptor)
        try:
            named = self.part_path.stat()
            if (named.st_dev, named.st_ino) == (ours.st_dev, ours.st_ino):
                return False
        except (FileNotFoundError, NotADirectoryError):
            pass
        except OSError:
            return False
        try:
            self._put_back()
        except OSError as error:
            if ours.st_nlink == 0:
                raise LostFileError(error.errno, error.strerror, str(self.part_path)) from error
            # It was only moved: what is written is safe, though not here.
            return False
        return True

    def _make(self) -> int:
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        descriptor = os.open(self.part_path, flags, 0o600)
        hold(descriptor)
        return descriptor

    def _put_back(self) -> None:
        """Make the folder again, and in it a file with all that was written."""
        folder = self.part_path.parent
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        copy = self._make()
        try:
            place = 0
            while data := os.pread(self._descriptor, _COPY_BYTES, place):
                place += _write_all(copy, data)
            os.fsync(copy)
            os.dup2(copy, self._descriptor, inheritable=False)
        except OSError:
            with contextlib.suppress(OSError):
                self.part_path.unlink()
            raise
        finally:
            os.close(copy)
        for changed in (folder, folder.parent):
            _sync_folder(changed)

    def discard(self) -> None:
        """Delete the file, of which nothing was made known yet."""
        with contextlib.suppress(OSError):
            self.part_path.unlink()

    def publish(self) -> Path:
        """Close the file and give it its final name, without ever replacing another file.

        Raises:
            FileExistsError: a file took the final name meanwhile; ours keeps ``.part``.
        """
        self.keep_named()
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


def _write_all(descriptor: int, data: bytes) -> int:
    rest = memoryview(data)
    while rest:
        rest = rest[os.write(descriptor, rest) :]
    return len(data)


def _sync_folder(folder: Path) -> None:
    """Bring the folder's list of names to the disk, where the platform can."""
    if os.name != "posix":
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
