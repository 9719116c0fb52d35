"""Files: written whole or not at all."""

import os
import tempfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from fvkit import _validate


def write_whole(path: str | Path, write: Callable[[IO[bytes]], Any]) -> Path:
    """Let ``write`` fill a temporary file beside ``path``, then rename it: an existing file survives any failure.

    Parameters
    ----------
    path : where the file shall stand; its folder must exist.
    write : function of the open binary file.

    Returns
    -------
    pathlib.Path
        ``path``.
    """
    target = Path(path)
    handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as file:
            write(file)
        os.chmod(temporary, 0o666 & ~_umask())
        os.replace(temporary, target)
    except BaseException:
        Path(temporary).unlink(missing_ok=True)
        raise
    return target


def usable_folder(path: str | Path, name: str) -> Path:
    """Return a folder if files can be written into it, or raise ValueError naming ``name``: to be asked before a long run.

    It may be missing: it is made for the trial, and removed again.
    """
    target, made = _validate.file(path, name), []
    try:
        made = [folder for folder in (target, *target.parents) if not folder.exists()]
        target.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=target):
            pass
    except OSError as error:
        raise ValueError(f"`{name}` must be a folder that can be written, got {str(path)!r}: {error.strerror}") from None
    finally:
        for folder in made:
            with suppress(OSError):  # what was not made
                folder.rmdir()
    return target


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
