"""`run`: a conformance suite without pytest's collection, for notebooks and scripts."""

from collections.abc import Iterator
from inspect import getmembers, isfunction
from itertools import product
from traceback import extract_tb
from typing import Any

import attrs
import pytest

from fvkit.testing.common import Suite
from fvkit.validation import shown


@attrs.frozen
class Outcome:
    """Outcome of `run`.

    Attributes
    ----------
    passed : names of the checks that passed.
    skipped : {name: reason} of checks that do not apply to the part.

    Examples
    --------
    >>> from fvkit.testing import Outcome
    >>> print(Outcome(passed=("test_it_is_data",), skipped={"test_walls_keep_the_masses": "Burgers has no phases"}))
    1 checks passed, 1 skipped
      test_walls_keep_the_masses: Burgers has no phases
    """

    passed: tuple[str, ...]
    skipped: dict[str, str]

    def __str__(self) -> str:
        lines = [f"{len(self.passed)} checks passed, {len(self.skipped)} skipped"]
        return "\n".join(lines + [f"  {name}: {reason}" for name, reason in self.skipped.items()])


def run(suite: type) -> Outcome:
    """Run every check of a conformance suite, without pytest.

    Parameters
    ----------
    suite : subclass of `ModelConformance`, `RiemannConformance`, `SourceConformance` or `LimiterConformance`.

    Returns
    -------
    Outcome
        ``print`` it.

    Raises
    ------
    AssertionError
        If a check fails: the names of all that do, with their reasons.
    TypeError
        If ``suite`` is not a class with checks.

    Examples
    --------
    >>> import fvkit as fv
    >>> from fvkit.testing import LimiterConformance, run
    >>> class TestMinmod(LimiterConformance):
    ...     limiter = fv.Minmod()
    >>> print(run(TestMinmod))
    4 checks passed, 0 skipped
    """
    if not isinstance(suite, type):
        raise TypeError(f"`suite` must be the class, not an instance of it, got {shown(suite)}")
    checks = [(name, check) for name, check in getmembers(suite, isfunction) if name.startswith("test_")]
    if not checks or not issubclass(suite, Suite):
        raise TypeError(f"`suite` must be a subclass of a suite such as fvkit.testing.ModelConformance, got {shown(suite)}")
    missing = [name for name in suite.kinds if not hasattr(suite, name)]
    if missing:
        raise TypeError(f"{suite.__name__} must set {', '.join(f'`{name}`' for name in missing)}")
    passed, skipped, failed = [], {}, {}
    for name, check in checks:
        for arguments in _arguments(check):
            label = name + "".join(f"[{value}]" for value in arguments.values())
            try:
                check(suite(), **arguments)
            except pytest.skip.Exception as reason:
                skipped[label] = str(reason)
            except KeyboardInterrupt:  # also that of a run, which is a RuntimeError as well
                raise
            except Exception as error:
                failed[label] = f"{type(error).__name__}: {str(error) or extract_tb(error.__traceback__)[-1].line}"
            else:
                passed.append(label)
    if failed:
        raise AssertionError(f"{suite.__name__}: {len(failed)} of {len(failed) + len(passed)} checks failed\n"
                             + "\n".join(f"  {name}: {reason}" for name, reason in failed.items()))
    return Outcome(tuple(passed), skipped)


def _arguments(check: Any) -> Iterator[dict[str, Any]]:
    """The arguments of the calls that pytest would make of a check that is parametrized by single names."""
    marks = [mark.args for mark in getattr(check, "pytestmark", []) if mark.name == "parametrize"]
    for values in product(*(given for _, given in marks)):
        yield dict(zip((name for name, _ in marks), values, strict=True))
