"""Known limits: what is expected to fail, why, and by how much. One place, short, each explained."""

from typing import Any

import attrs


@attrs.frozen
class Limit:
    """A check that is known to fail on some runs.

    Parameters
    ----------
    where : {field of a run: value or tuple of values}; every run that matches must fail the check.
    check : beginning of the name of the check.
    cause : why.
    size : by how much.
    """

    where: dict[str, Any]
    check: str
    cause: str
    size: str

    def matches(self, row: dict[str, Any]) -> bool:
        """Whether the limit is about a run."""
        return all(row[key] in (value if isinstance(value, tuple) else (value,)) for key, value in self.where.items())


LIMITS: tuple[Limit, ...] = ()
