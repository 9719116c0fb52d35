"""The folder of a sweep: one whole file per finished member, so that a sweep goes on where it stopped."""

import json
import re
import zipfile
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from tokenize import TokenError
from typing import Any

import attrs
import numpy as np

from fvkit.files import write_whole
from fvkit.output.npz import write_archive
from fvkit.sweeps.member import ERROR, LOST, MemberResult, MemberTask
from fvkit.sweeps.samples import Samples

#: Version of the files.
FORMAT = 1

#: What a folder of another sweep has, by the entry of ``sweep.json`` that differs.
OTHER = {"format": "another format", "function": "another function (scene, model, scheme, cells)", "keep": "other outputs",
         "parameters": "other parameters"}


def _name(part: Any) -> str:
    """A name of a function that is the same in every process."""
    if hasattr(part, "__qualname__"):
        return f"{part.__module__}.{part.__qualname__}"
    return re.sub(r" at 0x[0-9a-f]+", "", repr(part))


@attrs.frozen
class ResultFolder:
    """Members on disk.

    ``sweep.json`` names function and samples; ``member-000012.npz`` is how member 12 ended. Members whose function raised
    something else than `fvkit.SolveError`, and lost ones, are not kept: they are run again.
    """

    folder: Path

    @classmethod
    def open(cls, folder: str | Path, work: MemberTask, samples: Samples) -> "ResultFolder":
        """Return the store in a folder, which is made if missing; a folder of another sweep is refused."""
        store = cls(Path(folder))
        store.folder.mkdir(parents=True, exist_ok=True)
        plan = {"format": FORMAT, "function": _name(work.function), "keep": _name(work.keep),
                "parameters": {name: column.tolist() for name, column in samples.values.items()}}
        path = store.folder / "sweep.json"
        if not path.exists():
            with suppress(FileExistsError):  # another sweep began here just now: is it the same?
                write_whole(path, json.dumps(plan), replace=False)
        try:
            known = json.loads(path.read_text(encoding="utf-8"))
            differing = [key for key in plan if known.get(key) != plan[key]]
        except (ValueError, AttributeError):
            raise ValueError(f"`folder` {store.folder} has a sweep.json that is no plan of a sweep: give another") from None
        if differing:
            other = " and ".join(OTHER[key] for key in differing)
            raise ValueError(f"`folder` {store.folder} holds another sweep, of {other}: give another folder, or remove this one")
        return store

    def _path(self, member: int) -> Path:
        return self.folder / f"member-{member:06d}.npz"

    def write(self, outcome: MemberResult) -> None:
        """Keep how a member ended."""
        if outcome.status not in (ERROR, LOST):
            told: dict[str, Any] = {"status": np.array(outcome.status), "message": np.array(outcome.message),
                                    "seconds": np.array(outcome.seconds)}
            arrays = told | {f"output_{name}": values for name, values in outcome.outputs.items()}
            write_archive(self._path(outcome.member), arrays)

    def read(self, members: int) -> Iterator[MemberResult]:
        """Yield what earlier runs kept; a file that cannot be read counts as missing."""
        for member in range(members):
            try:
                with np.load(self._path(member), allow_pickle=False) as data:
                    outputs = {name.removeprefix("output_"): data[name] for name in data.files if name.startswith("output_")}
                    yield MemberResult(member, str(data["status"]), str(data["message"]), float(data["seconds"]), outputs)
            except (OSError, ValueError, KeyError, EOFError, SyntaxError, TokenError, zipfile.BadZipFile):
                continue
