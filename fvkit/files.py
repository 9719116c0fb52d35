"""Files: written whole or not at all."""

import csv
import io
import os
import tempfile
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import IO, Any
from uuid import uuid4

from fvkit import validation
from fvkit.validation import Portable


def write_whole(path: str | Path, content: str | bytes | Callable[[IO[bytes]], Any], *, replace: bool = True) -> Path:
    """Write a temporary file beside ``path``, then rename it: an existing file survives any failure. Return ``path``.

    ``content`` is text, bytes, or a function that writes to the open binary file. Any number of processes and threads may do so
    at once, each with a temporary file of its own: the last one counts. ``replace=False`` refuses where a file exists
    (FileExistsError), also one that another process has made in the meantime. An OSError names ``path``.
    """
    target = Path(path)
    temporary = temporary_beside(target)
    try:
        with open(temporary, "xb") as file:
            content(file) if callable(content) else file.write(content.encode() if isinstance(content, str) else content)
        if replace:
            os.replace(temporary, target)
        else:
            _name_new(temporary, target)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise OSError(error.errno, f"{error.strerror or error}, so nothing was changed", str(target)) from error
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    return target


def csv_text(columns: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a table as CSV text with a header."""
    buffer = io.StringIO()
    csv.writer(buffer, lineterminator="\n").writerows([columns, *rows])
    return buffer.getvalue()


def remove(folder: Path, names: Iterable[str], but: Iterable[str] = ()) -> None:
    """Remove the files of those names, but for some, from a folder: of an earlier run, they would pass for results of this one.

    Call it after the new files are written, so that a full disk leaves the old ones.
    """
    for name in set(names) - set(but):
        (folder / name).unlink(missing_ok=True)


def usable_folder(path: str | Path, name: str, files: Iterable[str] = ()) -> Path:
    """Return a folder if files can be written into it, or raise ValueError naming ``name``: a check before a long run.

    It may be missing: it is made for the trial, and removed again. Of ``files``, which will be written there, none may be a
    folder.
    """
    target, made = validation.file(path, name), []
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
    for file in files:
        if (target / file).is_dir():
            raise ValueError(f"`{name}` must be a folder to write {file} into, got {str(path)!r}, where that is a folder")
    return target


def temporary_beside(target: Path) -> Path:
    """Return an unused name in the folder of a file."""
    return target.with_name(f".{target.name}.{uuid4().hex[:12]}.part")


def _name_new(temporary: Path, target: Path) -> None:
    """Give a file a name that is free, in one move where the file system has links."""
    try:
        os.link(temporary, target)
    except FileExistsError:
        raise
    except OSError:  # no links here: what is left is a moment in which two processes may both find the name free
        if target.exists():
            raise FileExistsError(None, "it exists", str(target)) from None
        os.replace(temporary, target)
    else:
        temporary.unlink()


#: Characters of a reason that are told; some libraries quote whole parts of a damaged file.
TOLD = 300


class Unreadable(Portable, ValueError):
    """A file that cannot be used; the message contains its name and the reason."""

    def __init__(self, path: Path, reason: object) -> None:
        super().__init__(f"{path} cannot be read: {validation.cut(str(reason), TOLD)}")
