"""The pointwise contract: rules for methods, so that one source serves every backend.

Two checks, both before the first step. *Tracing*: the method runs once on symbols, which see all that it does, through helpers,
closures, comprehensions and loops alike; what has no meaning for them is refused with file, line and rule. *Rehearsal*: it runs
once on a few cells of the real initial state. Both answers must have the right number of components of the right shape. What the
user's own code raises passes through unchanged. `agree` then compares numbers with those that the contract of the part requires.
"""

import inspect
import re
import sys
from traceback import walk_tb
from types import CodeType, ModuleType
from typing import Any, NamedTuple

import numpy as np

from fvkit.pointwise.part import Part
from fvkit.pointwise.tracing import Expr, Graph, Untraceable, with_symbols

#: Tolerance for rounding when values are compared with a contract, relative to the largest value.
ROUNDING = 1e-10
#: Packages whose frames no user looks for.
_OTHERS = {"fvkit", "numpy", *sys.stdlib_module_names}


class PointwiseError(TypeError):
    """A pointwise method breaks a rule; the message names method, file, line and rule.

    Examples
    --------
    >>> import fvkit as fv
    >>> class Branching(fv.Burgers):
    ...     def flux(self, q):
    ...         return (q[0] if q[0] > 0.0 else 0.0,)
    >>> fv.Problem(Branching(), fv.Grid(0.0, 1.0, 5), lambda x: [x], 1.0)  # doctest: +IGNORE_EXCEPTION_DETAIL
    Traceback (most recent call last):
    fvkit.pointwise.contract.PointwiseError: `flux` must not branch on values: use fv.where
    """


class Answer(NamedTuple):
    """Form of a result: a tuple of so many components, one value and no tuple (None), or waves of so many, and their speeds."""

    components: int | None
    optional: bool = False
    waves: bool = False


def check(part: Part, method: str, arguments: tuple[Any, ...], wanted: Answer, length: int, traced: bool = True) -> Any:
    """Return what ``part.method(*arguments)`` answers, or raise PointwiseError; arrays have shape (length,).

    ``traced`` is False for a method that needs whole arrays, and never runs compiled.
    """
    if not callable(getattr(type(part), method)):
        raise PointwiseError(f"{type(part).__name__}.{method}: must be a method, got {getattr(part, method)!r}")
    with np.errstate(all="ignore"):
        if traced:
            _verify(_trace(part, method, arguments), wanted, length, where(part, method))
        result = getattr(part, method)(*arguments)
    _verify(result, wanted, length, where(part, method))
    return result


def _trace(part: Part, method: str, arguments: tuple[Any, ...]) -> Any:
    """Return the result of a method with symbols in place of all parameters, numbers and arrays."""
    graph = Graph()

    def symbol(operation: str = "uniform") -> Expr:
        return graph.node(operation, len(graph.nodes))

    def symbols(value: Any) -> Any:
        if isinstance(value, tuple):
            items = [symbols(item) for item in value]
            return type(value)(*items) if hasattr(value, "_fields") else tuple(items)
        if not isinstance(value, Part):
            return symbol("load" if np.ndim(value) else "uniform")
        copy: Any = with_symbols(value, symbol)
        seen = {*value.parameter_names(), *dict(value.varying())}
        for field in type(copy).__attrs_attrs__:
            if field.init and field.name not in seen:  # pointwise code sees numbers alone: new values make no new code
                object.__delattr__(copy, field.name)
        return copy

    try:
        return getattr(symbols(part), method)(*symbols(arguments))
    except (AttributeError, NameError, TypeError) as error:
        reason = _reason(error)
        if reason is None:
            raise
        raise PointwiseError(f"{where(part, method, error)}: {reason}") from None


def _reason(error: Any) -> str | None:
    """Return the rule that an error belongs to; None for an error of user code."""
    if isinstance(error, Untraceable):
        return str(error)
    if isinstance(error, NameError):
        return error.name and f"the name {error.name} is not defined"
    if isinstance(error, AttributeError) and isinstance(error.obj, Part):
        return (f"{error.name} is neither a parameter of {type(error.obj).__name__} "
                f"({', '.join(error.obj.parameter_names()) or 'it has none'}) nor one of its methods or constants of its class; "
                "a parameter is annotated with float in a class that @attrs.frozen decorates")
    if isinstance(error, AttributeError) and isinstance(error.obj, ModuleType):
        return str(error)
    if re.search(r"\bExpr\b", str(error)):
        return (f"{str(error).replace('Expr', 'value')}: a value is the number of one cell, not an array (no sums, no "
                "extremes, no shifts); use arithmetic, np.sqrt and its like, fv.where(condition, a, b)")
    return None


def where(part: Part, method: str, error: BaseException | None = None) -> str:
    """Name a method, file and line: where the user's own code raised an error, else where the method begins."""
    own: Any = getattr(inspect.unwrap(getattr(type(part), method)), "__code__", None)
    code, line = users(error) or (own, getattr(own, "co_firstlineno", 0))
    inside = "" if code is own else f", in {code.co_qualname.rsplit('<locals>.', 1)[-1]}"
    return f"{type(part).__name__}.{method}{inside}" + (f" ({code.co_filename}:{line})" if code is not None else "")


def users(error: BaseException | None) -> tuple[CodeType, int] | None:
    """Return code and line of the innermost call of the user's own code in the traceback of an error, None without any."""
    frames = [(frame.f_code, line) for frame, line in walk_tb(error.__traceback__ if error is not None else None)
              if frame.f_globals.get("__name__", "").split(".")[0] not in _OTHERS]
    return frames[-1] if frames else None


def _verify(result: Any, wanted: Answer, length: int, at: str) -> None:
    """Refuse an answer that does not have the form that is wanted, of scalars, symbols or arrays of shape (length,)."""
    if wanted.waves:
        if not (isinstance(result, tuple) and len(result) == 2 and all(isinstance(item, tuple) for item in result)):
            raise PointwiseError(f"{at}: must return the pair (waves, speeds) of tuples, got {_describe(result)}")
        waves, speeds = result
        if len(waves) != len(speeds):
            raise PointwiseError(f"{at}: returns {len(waves)} waves and {len(speeds)} speeds; one speed per wave")
        _verify(speeds, Answer(len(speeds)), length, f"{at}, speeds")
        for k, wave in enumerate(waves):
            _verify(wave, Answer(wanted.components), length, f"{at}, wave {k}")
        return
    if wanted.components is None:
        if isinstance(result, tuple):
            raise PointwiseError(f"{at}: must return one value and no tuple, got {_describe(result)}")
        result = (result,)
    elif not isinstance(result, tuple):
        raise PointwiseError(f"{at}: must return a tuple of {wanted.components} components, got {_describe(result)}"
                             + ("; write (value,) for a single component" if wanted.components == 1 else ""))
    elif len(result) != wanted.components and not (wanted.optional and result == ()):
        raise PointwiseError(f"{at}: returns {len(result)} components, {wanted.components} are needed")
    for k, component in enumerate(result):
        if isinstance(component, Expr):
            continue
        if np.asarray(component).dtype.kind not in "fiub":
            raise PointwiseError(f"{at}: component {k} must be a real number or an array of them, got {_describe(component)}")
        if np.shape(component) not in ((), (length,)):
            raise PointwiseError(f"{at}: component {k} has shape {np.shape(component)} for arguments of shape "
                                 f"({length},); pointwise code keeps the shape (no sums, no slices, no np.stack)")


def _describe(result: Any) -> str:
    if isinstance(result, (Expr, np.ndarray)):
        return "one value" if isinstance(result, Expr) else f"an array of shape {result.shape}"
    return f"a tuple of {len(result)}" if isinstance(result, tuple) else f"{type(result).__name__} {result!r}"


def agree(part: Part, method: str, found: Any, wanted: Any, rule: str, size: float = 0.0) -> None:
    """Raise ValueError where a method's values differ from those of its contract by more than rounding; NaN passes.

    Rounding is a share of the ``size`` of the numbers that ``found`` was added up of, or of the largest value of a row.
    """
    one, other = np.broadcast_arrays(*(np.array(np.broadcast_arrays(*(rows if isinstance(rows, tuple) else (rows,))))
                                       for rows in (found, wanted)))
    gap, largest = np.abs(one - other), np.fmax(np.abs(one), np.abs(other)).max(axis=-1, keepdims=True)
    wrong = gap > ROUNDING * np.fmax(largest, size)
    if wrong.any():
        worst = np.unravel_index(np.argmax(np.where(wrong, gap, 0.0)), gap.shape)
        raise ValueError(f"{where(part, method)}: {rule}, got {one[worst]:.8g} where {other[worst]:.8g} is right")
