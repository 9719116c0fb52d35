"""A file that bears a full disk, for libraries that do not: HDF5 crashes the process some time after a write that failed."""

import os
from pathlib import Path
from typing import Any

try:
    import fcntl
except ImportError:  # Windows: what is open there cannot be opened again for writing
    fcntl = None  # type: ignore[assignment]  # not on every system


class PatientFile:
    """A new file on disk, open for reading and writing by one process alone, whose errors are told when asked for.

    After the first write that fails nothing more goes to disk, as if the process had been killed there; what is written is kept
    in memory, so that the library sees a file that is whole until it closes it.

    Parameters
    ----------
    path : the file, emptied if it exists.

    Raises
    ------
    ValueError
        If another process, or another run of this one, has it open; the file is as it was then.
    OSError
        If it cannot be opened.
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
        """Go to a place."""
        self._place = offset + {os.SEEK_SET: 0, os.SEEK_CUR: self._place, os.SEEK_END: self._size}[whence]
        return self._place

    def tell(self) -> int:
        """Return the place."""
        return self._place

    def write(self, data: Any) -> int:
        """Write all of it, to disk or, from the first failure on, to memory."""
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
        """Return so many bytes from the place on, fewer at the end."""
        room = bytearray(count)
        return bytes(room[:self.readinto(room)])

    def readinto(self, room: Any) -> int:
        """Fill a buffer from the place on, with zeros where nothing was written; return how much there was."""
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
        """Set the size."""
        try:
            if self.error is None:
                os.ftruncate(self._handle, size)
        except OSError as error:
            self.error = error
        self._size = size
        return size

    def flush(self) -> None:
        """Do nothing: every write goes to disk at once."""

    def close(self) -> None:
        """Close the file, which gives it free for others."""
        if self._handle >= 0:
            os.close(self._handle)
            self._handle = -1
