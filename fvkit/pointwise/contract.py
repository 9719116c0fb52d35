"""The pointwise contract: what a method may contain so that one source serves every backend.

Two checks, both before the first step. *Reading*: the bytecode of a method and of all that it calls is
read, not rewritten, and anything that cannot work on arrays and on compiled scalars alike is refused with
file, line and rule. *Rehearsal*: the method runs once on a few cells of the real initial state, and its
result must be a tuple with the right number of components of the right shape. What the user's own code
raises there passes through unchanged. `agree` then compares numbers with what the part's contract promises.
"""

import builtins
import dis
import math
import types
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from fvkit.pointwise.part import Part

_BUILDERS = ("LIST_APPEND", "SET_ADD", "MAP_ADD", "YIELD_VALUE")
#: Functions of Python that cannot look at arrays, and what can.
_SCALAR = {"max": "fv.maximum(a, b)", "min": "fv.minimum(a, b)"}
#: Share of the largest value by which rounding may miss what a contract promises.
ROUNDING = 1e-10
_CONSTANTS = (bool, int, float, tuple, type(None), np.generic)


class PointwiseError(TypeError):
    """A pointwise method breaks a rule; the message names method, file, line and rule."""


def read(part: type[Part], methods: tuple[str, ...], model: type[Part] | None = None) -> None:
    """Refuse methods of ``part`` whose bytecode breaks a rule.

    Parameters
    ----------
    part : class of a model, solver, limiter, boundary condition or source.
    methods : names of its pointwise methods.
    model : class that an argument called ``model`` holds, if any.

    Raises
    ------
    PointwiseError
        With the method, the file, the line and the rule.
    """
    seen: set[types.CodeType] = set()
    holders = {"self": part} | ({"model": model} if model is not None else {})
    for name in methods:
        method = getattr(part, name)
        if not isinstance(method, types.FunctionType) or hasattr(method, "__wrapped__"):
            raise PointwiseError(f"{part.__name__}.{name}: must be a plain method, without decorator; got {method!r}")
        _examine(method, holders, f"{part.__name__}.", seen)


def _examine(function: Any, holders: Mapping[str, type[Part]], owner: str, seen: set[types.CodeType]) -> None:
    if function.__code__ in seen:
        return
    seen.add(function.__code__)
    code, line = function.__code__, function.__code__.co_firstlineno

    def refuse(reason: str) -> None:
        raise PointwiseError(f"{owner}{function.__name__} ({code.co_filename}:{line}): {reason}")

    if code.co_freevars:
        refuse(f"super() and variables of an enclosing scope ({', '.join(code.co_freevars)}) are not available here; "
               "use parameters of the class and module-level functions")
    if any(isinstance(constant, types.CodeType) for constant in code.co_consts):
        refuse("no comprehension, generator, lambda or nested function here; write the components out, "
               "or use fv.pointwise.combine(a, x, b, y) and its like")
    last_name: str | None = None
    for instruction in _instructions(code):
        if instruction.positions is not None and instruction.positions.lineno is not None:
            line = instruction.positions.lineno
        operation, argument = instruction.opname, instruction.argval
        if "JUMP" in operation and "_IF_" in operation:
            refuse("`if`, `while`, `and`, `or`, `not`, `assert` cannot look at values that are arrays; "
                   "use fv.where(condition, a, b)")
        if operation in _BUILDERS:
            refuse("no comprehension or generator here; write the components out, "
                   "or use fv.pointwise.combine(a, x, b, y) and its like")
        if operation == "LOAD_GLOBAL" and argument not in function.__globals__ and not hasattr(builtins, argument):
            refuse(f"the name {argument} is not defined")
        if operation == "LOAD_GLOBAL" and argument in _SCALAR and argument not in function.__globals__:
            refuse(f"{argument} cannot look at values that are arrays; use {_SCALAR[argument]}")
        if operation in ("LOAD_ATTR", "LOAD_METHOD"):
            holder = holders.get(last_name) if last_name is not None else None
            if holder is not None:
                _attribute(holder, last_name, argument, refuse)
                method = getattr(holder, argument, None)
                if isinstance(method, types.FunctionType):
                    _examine(method, {**holders, "self": holder}, f"{holder.__name__}.", seen)
        last_name = _loaded(operation, argument)
    for name, value, read_at in _globals_of(function):
        if value is math:
            line = read_at
            refuse("the module math serves no arrays; use np.sqrt and its like")
        if isinstance(value, types.FunctionType) and value.__module__.split(".")[0] != "numpy":
            if value.__module__.split(".")[0] != __name__.split(".")[0]:  # our own helpers are traced and tested
                _examine(value, {key: holder for key, holder in holders.items() if key != "self"}, "", seen)
        elif not (isinstance(value, (*_CONSTANTS, types.ModuleType)) or callable(value)):
            line = read_at
            refuse(f"the global {name} is a {type(value).__name__}; only numbers, tuples, functions and modules serve")


@lru_cache(maxsize=1024)
def _instructions(code: types.CodeType) -> tuple[dis.Instruction, ...]:
    """The instructions of a code object; problems are built by the thousand, of the same methods."""
    return tuple(dis.get_instructions(code))


def _attribute(holder: type[Part], name: str | None, attribute: str, refuse: Callable[[str], None]) -> None:
    parameters = holder.parameter_names()
    if attribute not in parameters and not isinstance(getattr(holder, attribute, None), (types.FunctionType, tuple)):
        refuse(f"{name}.{attribute} is neither a parameter of {holder.__name__} "
               f"({', '.join(parameters) or 'it has none'}) nor one of its methods or constant tuples; a parameter is annotated "
               "with float in a class that @attrs.frozen decorates")


def _loaded(operation: str, argument: Any) -> str | None:
    """Name of the local variable that an instruction leaves on top of the stack, if it is one."""
    if not operation.startswith("LOAD_FAST"):
        return None
    return argument[-1] if isinstance(argument, tuple) else argument


def _globals_of(function: types.FunctionType) -> Iterator[tuple[str, Any, int]]:
    """What a function reads, and in which line, from its module and, one level down, from modules that it names."""
    last: Any = None
    line = function.__code__.co_firstlineno
    for instruction in _instructions(function.__code__):
        name = instruction.argval
        line = (instruction.positions and instruction.positions.lineno) or line
        if instruction.opname == "LOAD_GLOBAL" and name in function.__globals__:
            last = function.__globals__[name]
            yield name, last, line
        elif instruction.opname in ("LOAD_ATTR", "LOAD_METHOD") and isinstance(last, types.ModuleType):
            last = getattr(last, name, None)
            yield name, last, line
        else:
            last = None


def rehearse(part: Part, method: str, arguments: tuple[Any, ...], components: int, length: int) -> tuple[Any, ...]:
    """Run ``part.method(*arguments)`` and return its result if it is ``components`` rows of ``length`` values.

    Raises
    ------
    PointwiseError
        If the result is no tuple, or has another number of components, or one of another shape, or if what it says of
        a cell depends on the other cells.
    """
    result = _run(part, method, arguments)
    verify(result, components, length, _where(part, method))
    _verify_local(part, method, arguments, result, length)
    return result


def rehearse_value(part: Part, method: str, arguments: tuple[Any, ...], length: int) -> None:
    """Like `rehearse` for a method that returns one value and no tuple."""
    result = _run(part, method, arguments)
    verify((result,), 1, length, _where(part, method))
    _verify_local(part, method, arguments, result, length)


def rehearse_waves(part: Part, method: str, arguments: tuple[Any, ...], components: int, length: int) -> int:
    """Like `rehearse` for a method that returns (waves, speeds); return the number of waves."""
    where = _where(part, method)
    result = _run(part, method, arguments)
    if not (isinstance(result, tuple) and len(result) == 2 and all(isinstance(item, tuple) for item in result)):
        raise PointwiseError(f"{where}: must return the pair (waves, speeds) of tuples, got {_describe(result)}")
    waves, speeds = result
    if len(waves) != len(speeds):
        raise PointwiseError(f"{where}: returns {len(waves)} waves and {len(speeds)} speeds; one speed per wave")
    verify(speeds, len(speeds), length, f"{where}, speeds")
    for k, wave in enumerate(waves):
        verify(wave, components, length, f"{where}, wave {k}")
    _verify_local(part, method, arguments, result, length)
    return len(waves)


def agree(part: Part, method: str, found: Any, wanted: Any, rule: str, size: float = 0.0) -> None:
    """Raise ValueError where a method's values miss those that its contract promises by more than rounding; NaN passes.

    Parameters
    ----------
    part, method : who answered.
    found, wanted : rows of values, or one row.
    rule : what the contract says.
    size : of the numbers that ``found`` was added up of; rounding is a share of that, or of the largest value of a row.
    """
    one, other = np.broadcast_arrays(*(np.array(np.broadcast_arrays(*_leaves(rows))) for rows in (found, wanted)))
    gap, largest = np.abs(one - other), np.fmax(np.abs(one), np.abs(other)).max(axis=-1, keepdims=True)
    wrong = gap > ROUNDING * np.fmax(largest, size)
    if wrong.any():
        worst = np.unravel_index(np.argmax(np.where(wrong, gap, 0.0)), gap.shape)
        raise ValueError(f"{_where(part, method)}: {rule}, got {one[worst]:.8g} where {other[worst]:.8g} is right")


def _run(part: Part, method: str, arguments: tuple[Any, ...]) -> Any:
    with np.errstate(all="ignore"):
        return getattr(part, method)(*arguments)


def _verify_local(part: Part, method: str, arguments: tuple[Any, ...], result: Any, length: int) -> None:
    """Refuse a method whose result in a cell changes when the first cell is taken away."""
    alone = _run(part, method, tuple(_without_first(argument, length) for argument in arguments))
    for once, again in zip(_leaves(_without_first(result, length)), _leaves(alone), strict=True):
        if np.shape(once) != np.shape(again) or not np.allclose(once, again, rtol=1e-12, atol=0.0, equal_nan=True):
            raise PointwiseError(f"{_where(part, method)}: what it returns for one cell depends on other cells; pointwise code "
                                 "looks at its own cell alone (no sums, no extremes, no shifts)")


def _without_first(value: Any, length: int) -> Any:
    if isinstance(value, tuple):
        return tuple(_without_first(item, length) for item in value)
    return value[1:] if np.shape(value) == (length,) else value


def _leaves(value: Any) -> list[Any]:
    return [leaf for item in value for leaf in _leaves(item)] if isinstance(value, tuple) else [value]


def verify(result: Any, components: int, length: int, where: str) -> None:
    """Refuse a result that is not a tuple of ``components`` scalars or arrays of shape (length,)."""
    if not isinstance(result, tuple):
        raise PointwiseError(f"{where}: must return a tuple of {components} components, got {_describe(result)}"
                             + ("; write (value,) for a single component" if components == 1 else ""))
    if len(result) != components:
        raise PointwiseError(f"{where}: returns {len(result)} components, {components} are needed")
    for k, component in enumerate(result):
        if np.asarray(component).dtype.kind not in "fiub":
            raise PointwiseError(f"{where}: component {k} must be a real number or an array of them, got {_describe(component)}")
        if np.shape(component) not in ((), (length,)):
            raise PointwiseError(f"{where}: component {k} has shape {np.shape(component)} for arguments of shape "
                                 f"({length},); pointwise code keeps the shape (no sums, no slices, no np.stack)")


def _where(part: Part, method: str) -> str:
    code = getattr(type(part), method).__code__
    return f"{type(part).__name__}.{method} ({code.co_filename}:{code.co_firstlineno})"


def _describe(result: Any) -> str:
    return f"an array of shape {result.shape}" if isinstance(result, np.ndarray) else f"{type(result).__name__} {result!r}"
