"""Where compiled kernels are kept, and how a generated module gets there safely."""

import hashlib
import os
import shutil
import sys
import tempfile
import warnings
from pathlib import Path

import attrs

from fvkit.files import write_whole

#: Environment variable that names another folder.
VARIABLE = "FVKIT_CACHE"


def folder() -> Path:
    """Return the folder of compiled kernels: ``$FVKIT_CACHE``, else ``fvkit`` in the platform's folder for caches.

    An OSError where that is in the home of someone who has none.
    """
    chosen = os.environ.get(VARIABLE)
    try:
        if chosen:
            return Path(chosen).expanduser()
        if sys.platform == "win32":
            base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
        elif sys.platform == "darwin":
            base = Path.home() / "Library" / "Caches"
        else:
            base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    except RuntimeError as error:  # containers and batch jobs have users without a home
        raise OSError(f"${VARIABLE} is {chosen!r}, and no home directory is known: {str(error).rstrip('.')}") from None
    return base / "fvkit"


def key(*content: str) -> str:
    """Return a name for compiled content: the same content, the same name."""
    return hashlib.sha256("\0".join(content).encode()).hexdigest()[:24]


def place(name: str, text: str) -> tuple[Path, bool]:
    """Write a module where numba can keep its compiled form beside it; return its path and whether that will last.

    Several processes may do so at once: each writes whole files of the same content. A folder that cannot be written
    gives a warning and a temporary one.
    """
    try:
        target = folder() / f"{name}.py"
        target.parent.mkdir(parents=True, exist_ok=True)
        if not target.exists():
            write_whole(target, text)
        with tempfile.TemporaryFile(dir=target.parent):
            pass
        return target, True
    except OSError as error:
        warnings.warn(f"the cache of compiled kernels cannot be written ({error}): they are compiled again in every process. "
                      f"Set {VARIABLE} to a folder that can be written.", RuntimeWarning, stacklevel=2)
        return Path(tempfile.gettempdir()) / f"{name}.py", False


@attrs.frozen
class Contents:
    """What the cache holds: its folder, the number of kernels, and their bytes."""

    folder: Path
    kernels: int
    size: int


def contents() -> Contents:
    """Return the contents of the cache."""
    files = [path for path in folder().rglob("*") if path.is_file()] if folder().is_dir() else []
    return Contents(folder(), sum(path.match("kernel_*.py") for path in files), sum(path.stat().st_size for path in files))


def clear() -> Contents:
    """Remove every compiled kernel; return what there was."""
    found = contents()
    for path in (*folder().glob("kernel_*.py"), *folder().glob("loop_*.py")) if folder().is_dir() else ():
        path.unlink(missing_ok=True)
    shutil.rmtree(folder() / "__pycache__", ignore_errors=True)
    return found


def forget(name: str) -> None:
    """Remove one kernel, whose files are damaged."""
    for path in (folder() / "__pycache__").glob(f"{name}.*"):
        path.unlink(missing_ok=True)
