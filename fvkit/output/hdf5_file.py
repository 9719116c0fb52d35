"""File object for h5py that survives ENOSPC. Without it HDF5 crashes the process some time after a failed write."""

import os
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows: the system itself refuses a second writer of an open file
    fcntl = None  # type: ignore[assignment]  # not on every system


class PatientFile:
    """Exclusively locked file, open for reading and writing, that stores write errors in ``error`` instead of raising them.

    After the first failed write the file on disk no longer changes, as if the process had been killed there. Later writes are
    kept in memory, so that the library reads consistent data until it closes the file. An existing file is truncated, unless
    another process, or another run of this process, has it open: a ValueError then leaves it unchanged.
    """

    def __init__(self, path: Path) -> None:
        self.error: OSError | None = None
        self._late: list[tuple[int, bytes]] = []
        self._place = self._size = 0
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666)
        try:
            if fcntl is not None:
                fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            os.ftruncate(self._handle, 0)
        except BlockingIOError:
            os.close(self._handle)
            raise ValueError(f"{path} is open elsewhere, by a run that writes it or by a reader: give this run another name") \
                from None

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        """Set the file position and return it."""
        self._place = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        return self._place

    def tell(self) -> int:
        """Return the file position in bytes."""
        return self._place

    def write(self, data: Any) -> int:
        """Write all bytes, to disk or, after a failed write, to memory; return their number."""
        content = bytes(data)
        try:
            if self.error is None:
                self._to_disk(content)
        except OSError as error:
            self.error = error
        if self.error is not None:
            self._late.append((self._place, content))
        self._place += len(content)
        self._size = max(self._size, self._place)
        return len(content)

    def _to_disk(self, content: bytes) -> None:
        os.lseek(self._handle, self._place, os.SEEK_SET)
        while content:
            content = content[os.write(self._handle, content):]

    def read(self, count: int) -> bytes:
        """Return up to ``count`` bytes from the file position on."""
        room = bytearray(count)
        return bytes(room[:self.readinto(room)])

    def readinto(self, room: Any) -> int:
        """Fill a buffer from the file position on, with zeros where nothing was written; return the number of bytes read."""
        view = memoryview(room).cast("B")
        begin, end = self._place, min(self._place + len(view), self._size)
        os.lseek(self._handle, begin, os.SEEK_SET)
        count = max(end - begin, 0)
        content = bytearray(count)
        found = os.read(self._handle, count)
        content[:len(found)] = found
        for start, late in self._late:
            low, high = max(start, begin), min(start + len(late), end)
            if low < high:
                content[low - begin:high - begin] = late[low - start:high - start]
        view[:count] = content
        self._place += count
        return count

    def truncate(self, size: int) -> int:
        """Set the file size in bytes and return it."""
        try:
            if self.error is None:
                os.ftruncate(self._handle, size)
        except OSError as error:
            self.error = error
        self._size = size
        return size

    def flush(self) -> None:
        """Do nothing, since writes are not buffered."""

    def close(self) -> None:
        """Close the file and release its lock."""
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1
