"""Run configuration as JSON data: models, schemes and settings are serialised, and restored from the data.

Reading never imports modules or executes code: a class is looked up by name among the classes that are already loaded.
"""

import json
import platform
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import entry_points
from math import isfinite
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from fvkit import validation
from fvkit.files import Unreadable
from fvkit.output.citation import VERSION, sentence
from fvkit.output.results import Results
from fvkit.output.status import Stats, Status
from fvkit.pointwise.part import Part
from fvkit.problem.grid import Grid
from fvkit.problem.model import Model
from fvkit.problem.problem import Problem
from fvkit.schemes.integrators import Integrator
from fvkit.schemes.scheme import Scheme
from fvkit.schemes.splitting import Splitting

#: Base classes of the objects that a file may contain.
BASES: tuple[type, ...] = (Part, Scheme, Splitting, Integrator, Grid, Stats)

#: Reserved keys for values that JSON cannot express. "class" and "from" cannot be field names, since both are Python keywords.
CLASS, MODULE = "class", "from"
ARRAY, LIST, MAPPING, NUMBER, CALLABLE, OBJECT = "array", "list", "mapping", "number", "callable", "object"
RESERVED = {CLASS, ARRAY, LIST, MAPPING, NUMBER, CALLABLE, OBJECT}


def describe(value: Any) -> Any:
    """Return an object, or the value of a field, as JSON data without loss of precision.

    A model, scheme, splitting, integrator, grid, boundary condition, source or statistics is {"class": its name, "from": its
    module, and its fields}. Numbers, texts and None stay; a tuple becomes a list, a list {"list": [...]}, an array {"array":
    [...]}, an infinite number {"number": "inf"}. A function becomes {"callable": its name}, any other object {"object": its
    class}: these two record what was used and cannot be restored.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, float):
        return value if isfinite(value) else {NUMBER: repr(value)}
    if isinstance(value, tuple):
        return [describe(item) for item in value]
    if isinstance(value, list):
        return {LIST: [describe(item) for item in value]}
    if isinstance(value, np.ndarray):
        return {ARRAY: _rows(value.tolist())}
    if isinstance(value, Mapping) and all(isinstance(key, str) for key in value):
        plain = {key: describe(item) for key, item in value.items()}
        return {MAPPING: plain} if RESERVED & plain.keys() else plain
    if isinstance(value, BASES):
        return fields_of(value)
    if callable(value):
        own = getattr(value, "__name__", type(value).__qualname__)  # a ufunc of NumPy 1 has no __qualname__
        return {CALLABLE: f"{getattr(value, '__module__', None)}.{getattr(value, '__qualname__', own)}"}
    return {OBJECT: f"{type(value).__module__}.{type(value).__qualname__}"}


def fields_of(value: Any) -> dict[str, Any]:
    """Return an instance of an attrs class as a JSON mapping: its class, its module and its fields."""
    kind: Any = type(value)
    return {CLASS: kind.__name__, MODULE: kind.__module__,
            **{field.alias: describe(getattr(value, field.name)) for field in attrs.fields(kind) if field.init}}


def _rows(value: Any) -> Any:
    return [_rows(item) for item in value] if isinstance(value, list) else describe(value)


def build(data: Any, kind: type | None = None, name: str = "data") -> Any:
    """Return the object that `describe` serialised, of class ``kind`` unless None.

    A ValueError for a class that is not loaded, a function, or invalid field values has the position in the data, from ``name``.
    """
    try:
        result = _build(data, validation.text(name, "name"))
    except RecursionError:
        raise ValueError(f"{name} is nested too deeply") from None
    if kind is not None and not isinstance(result, kind):
        raise ValueError(f"{name} must be a {kind.__name__}, got {type(result).__name__}")
    return result


def _build(data: Any, name: str) -> Any:
    if isinstance(data, list):
        return tuple(_build(item, f"{name}[{k}]") for k, item in enumerate(data))
    if not isinstance(data, Mapping):
        return data
    if CLASS in data:
        return _instance(data, name)
    special = RESERVED & data.keys()
    if not special:
        return {key: _build(item, f"{name}.{key}") for key, item in data.items()}
    if CALLABLE in data or OBJECT in data:
        raise ValueError(f"{name} is {data.get(CALLABLE) or data.get(OBJECT)}, which no file can hold")
    (word,) = special if len(special) == len(data) == 1 else ("",)
    inner = data.get(word)
    if word == NUMBER and inner in ("inf", "-inf", "nan"):
        return float(inner)
    if word == MAPPING and isinstance(inner, Mapping):
        return {key: _build(item, f"{name}.{key}") for key, item in inner.items()}
    if word in (LIST, ARRAY) and isinstance(inner, list):
        items = _build(inner, name)
        return list(items) if word == LIST else _array(items, name)
    raise ValueError(f"{name} is not what a configuration holds: {', '.join(map(str, data))}")


def _array(items: tuple[Any, ...], name: str) -> np.ndarray:
    try:
        result = np.array(items)
    except ValueError:
        raise ValueError(f"{name} must be an array, got rows of different lengths") from None
    if result.dtype.kind not in "biufU":
        raise ValueError(f"{name} must be an array of numbers or texts, got {validation.shown(items)}")
    return result


def _instance(data: Mapping[str, Any], name: str) -> Any:
    kind = _find(data[CLASS], data.get(MODULE), name)
    fields = {key: _build(item, f"{name}.{key}") for key, item in data.items() if key not in (CLASS, MODULE)}
    if kind is Stats:  # files of before 0.1.0 count more
        fields = {key: fields[key] for key in fields.keys() & attrs.fields_dict(Stats).keys()}
    try:
        return kind(**fields)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}, a {kind.__name__}, cannot be made from its fields: {error}") from None


#: Current names of classes that files of the previous version store under an old name.
RENAMED = {"Stage": "FixedLevel", "StepLength": "Step"}


def _find(name: Any, module: Any, place: str) -> type:
    """Return the loaded class of that name: the last one defined in ``module``, or the only one in any module."""
    name = RENAMED.get(name, name) if isinstance(name, str) else name
    found = [kind for kind in _known() if kind.__name__ == name]
    if not found:
        for plugin in entry_points(group="fvkit.commands"):
            plugin.load()
        found = [kind for kind in _known() if kind.__name__ == name]
    exact = [kind for kind in found if kind.__module__ == module]
    modules = {kind.__module__ for kind in exact or found}
    if len(modules) == 1:
        return (exact or found)[-1]
    if modules:
        raise ValueError(f"{place} is the class {name} of {module}, but the loaded ones are of {', '.join(sorted(modules))}: "
                         f"import the module that defines it first")
    raise ValueError(f"{place} is a {name} of {module}, which is not loaded: import the module that defines it first")


def _known() -> Iterator[type]:
    """Yield all subclasses of `BASES`, in order of definition for each base."""
    waiting, seen = list(BASES), set()
    while waiting:
        kind = waiting.pop(0)
        if kind not in seen:
            seen.add(kind)
            waiting += kind.__subclasses__()
            yield kind


def effective(problem: Problem, scheme: Scheme, stats: Stats, status: Status, message: str) -> dict[str, Any]:
    """Return the complete configuration of a run, defaults and final status included, as JSON data."""
    versions = {"fvkit": VERSION, "python": platform.python_version(), "numpy": np.__version__}
    if stats.backend == "numba":
        versions["numba"] = sys.modules["numba"].__version__
    given = problem.background
    return {"model": describe(problem.model), "scheme": describe(scheme), "boundary": describe(problem.boundary),
            "sources": describe(problem.sources), "grid": describe(problem.grid), "t_start": problem.t_start,
            "t_end": problem.t_end, "background": describe(given) if callable(given) else given is not None,
            "backend": stats.backend, "versions": versions, "status": status.name, "message": message,
            "statistics": describe(stats), "citation": sentence((problem.model, scheme.riemann, *problem.sources))}


def configuration_of(solution: Results) -> dict[str, Any]:
    """Return the configuration stored in a file: that of the solution, with everything that `fvkit.load` needs."""
    return {**solution.configuration, "model": describe(solution.model), "grid": describe(solution.grid),
            "status": solution.status.name, "message": solution.message, "statistics": describe(solution.stats)}


def parsed(text: str, source: Path) -> dict[str, Any]:
    """Return the configuration of a file, parsed from JSON."""
    try:
        result = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise Unreadable(source, f"its configuration is no JSON ({error})") from None
    if not isinstance(result, dict):
        raise Unreadable(source, "its configuration is no mapping")
    return result


def part(kept: Mapping[str, Any], name: str, kind: type, source: Path) -> Any:
    """Return one object restored from its configuration, or raise `Unreadable`."""
    if name not in kept:
        raise Unreadable(source, f"its configuration has no {name!r}")
    try:
        return build(kept[name], kind, name)
    except ValueError as error:
        raise Unreadable(source, error) from None


def model_and_grid(kept: Mapping[str, Any], source: Path) -> tuple[Model, Grid]:
    """Return the model and the grid restored from a configuration."""
    return part(kept, "model", Model, source), part(kept, "grid", Grid, source)
