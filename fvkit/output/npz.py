"""Archives of named arrays in ``.npz`` files: atomic writing, and a reader for untrusted files."""

import struct
import zipfile
from collections.abc import Mapping
from math import prod
from pathlib import Path
from tokenize import TokenError
from typing import IO, Any

import numpy as np
from numpy.lib import format as npy

from fvkit import validation
from fvkit.files import Unreadable, write_whole
from fvkit.validation import file

_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def write_archive(path: str | Path, arrays: Mapping[str, Any]) -> Path:
    """Write arrays and texts to an uncompressed ``.npz`` file atomically and return its path."""
    given: dict[str, Any] = {name: np.asarray(values) for name, values in arrays.items()}
    return write_whole(path, lambda file: fill(file, given))


def fill(file: IO[bytes], arrays: Mapping[str, np.ndarray]) -> None:
    """Write the entries of an ``.npz`` file. Before NumPy 2 `numpy.savez` left its archive open when the disk was full."""
    with zipfile.ZipFile(file, "w") as archive:
        for name, values in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                npy.write_array(entry, values, allow_pickle=False)


class Archive:
    """Reader that loads and checks all arrays of an ``.npz`` file; `Unreadable` says what is wrong with an invalid one.

    Compressed entries, object arrays and entries that declare more bytes than the file has are errors. So nothing is
    unpickled, and the arrays need no more memory than the size of the file.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = file(path, "path")
        try:
            with open(self.path, "rb") as stream, zipfile.ZipFile(stream) as archive:
                self._check(archive.infolist())
                self.arrays = {entry.filename.removesuffix(".npy"): self._read(archive, entry)
                               for entry in archive.infolist()}
        except Unreadable:
            raise
        except OSError as error:
            if error.filename is not None:
                raise
            raise self.refused(f"it is damaged or no .npz file ({error})") from None  # a seek to nowhere
        except (zipfile.BadZipFile, struct.error, EOFError, OverflowError, RuntimeError, ValueError) as error:
            raise self.refused(f"it is damaged or no .npz file ({error})") from None

    def refused(self, reason: str) -> Unreadable:
        """Return the error `Unreadable` for this file and a reason."""
        return Unreadable(self.path, reason)

    def _check(self, entries: list[zipfile.ZipInfo]) -> None:
        size = self.path.stat().st_size
        for entry in entries:
            if entry.compress_type != zipfile.ZIP_STORED:
                raise self.refused(f"its entry {entry.filename!r} is compressed, which fvkit never writes")
        declared = sum(entry.file_size for entry in entries)
        if declared > size:
            raise self.refused(f"it declares {declared} bytes of content, but has {size}")

    def _read(self, archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> np.ndarray:
        with archive.open(entry) as file:
            try:
                shape, _, dtype = _HEADERS[npy.read_magic(file)](file)
            except (ValueError, KeyError, TypeError, SyntaxError, TokenError, RecursionError, MemoryError) as error:
                raise self.refused(f"its entry {entry.filename!r} is no array ({validation.shown(error)})") from None
            size = entry.file_size - file.tell()
        if dtype.hasobject or dtype.kind not in "biufU":
            raise self.refused(f"its entry {entry.filename!r} holds {dtype}: numbers and texts alone are read")
        if prod(shape) * dtype.itemsize != size or min(shape, default=0) < 0:
            raise self.refused(f"its entry {entry.filename!r} declares shape {shape} of {dtype}, but has {size} bytes")
        with archive.open(entry) as file:  # from its start: after a seek zipfile compares no checksum
            return npy.read_array(file, allow_pickle=False)

    def _get(self, name: str) -> np.ndarray:
        if name not in self.arrays:
            raise self.refused(f"it has no {name!r}, only {', '.join(self.arrays) or 'nothing'}")
        return self.arrays[name]

    def text(self, name: str) -> str:
        """Return the text stored under ``name``."""
        value = self._get(name)
        if value.ndim or value.dtype.kind != "U":
            raise self.refused(f"{name!r} must be a text, got shape {value.shape} of {value.dtype}")
        try:
            return str(value)
        except ValueError as error:
            raise self.refused(f"{name!r} is no text ({error})") from None

    def numbers(self, name: str, shape: tuple[int | None, ...] | None, kind: str = "f") -> np.ndarray:
        """Return the array stored under ``name``, checked: shape None is any, a length None is any; kind f float64, i int64."""
        value = self._get(name)
        shape = value.shape if shape is None else shape
        allowed = ", ".join("any" if length is None else str(length) for length in shape)
        if value.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, value.shape, strict=True)):
            raise self.refused(f"{name!r} must have shape ({allowed}), got {value.shape}")
        if value.dtype != np.dtype(f"{kind}8"):
            raise self.refused(f"{name!r} must be of type {kind}8, got {value.dtype}")
        return value


#: Format identifiers, stored in the entry ``format``.
FORMAT, CHECKPOINT = "fvkit solution 1", "fvkit checkpoint 3"


def expect_format(archive: Archive, kind: str) -> None:
    """Raise `Unreadable` for an archive of another format; the message contains the function that reads it."""
    found = archive.text("format")
    if found != kind:
        other = {FORMAT: "fv.load reads it", CHECKPOINT: "fv.resume continues it"}.get(found, "nothing here reads it")
        raise archive.refused(f"it is no {kind!r} but {found!r}: {other}")
