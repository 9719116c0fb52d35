"""What the exceptions of both packages have in common."""

import copyreg
from typing import Any


class Portable:
    """Exception that pickling and copying keep whatever its ``__init__`` takes: it is made again of ``args`` and attributes.

    Python's own way calls the class with ``args``, and an error in unpickling loses every result of a pool of processes.
    """

    args: tuple[Any, ...]

    def __reduce__(self) -> tuple[Any, ...]:
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__  # type: ignore[attr-defined]
