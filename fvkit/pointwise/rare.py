"""`rarely`: arithmetic that few cells or faces need, and that is skipped where none of a tile does."""

from collections.abc import Callable
from typing import Any

import numpy as np

from fvkit import validation
from fvkit.pointwise.tracing import Expr, Graph


def rarely(condition, value: Callable[[], Any], otherwise):
    """Return ``where(condition, value(), otherwise)`` for a condition that few cells or faces meet.

    NumPy does not call ``value`` if no entry meets it. Compiled code has two versions of the loop, and takes the one without
    ``value`` in tiles where no cell or face meets it; a short loop before them decides. The numbers are the same.

    Parameters
    ----------
    condition : pointwise condition.
    value : function without arguments that returns a value or a (named) tuple of values, nested or not.
    otherwise : the usual value, or a tuple of the same form; best of constants, which fold what is computed from them.

    Examples
    --------
    >>> import fvkit as fv
    >>> import numpy as np
    >>> depth = np.array([4.0, 9.0])
    >>> fv.rarely(depth > 10.0, lambda: np.sqrt(depth), 0.0)
    0.0
    >>> fv.rarely(depth > 5.0, lambda: np.sqrt(depth), 0.0).tolist()
    [0.0, 3.0]
    """
    validation.function(value, "value", "without arguments, such as lambda: np.sqrt(h)")
    if isinstance(condition, Expr):
        if condition.graph.rare is not None:
            condition.graph.rare.append(condition)
            return otherwise
    elif not np.any(condition):
        return otherwise
    return chosen(condition, value(), otherwise)


def usually(graph: Graph, build: Callable[[], Any]) -> tuple[Any, list[Expr]]:
    """Return what ``build`` traces where no condition of `rarely` is met, and these conditions."""
    graph.rare = []
    try:
        return build(), graph.rare
    finally:
        graph.rare = None


def chosen(condition: Any, value: Any, otherwise: Any) -> Any:
    """Return ``where`` for each entry of tuples, lists and dictionaries; named tuples keep their type, and equal objects stay."""
    if value is otherwise:
        return value
    if isinstance(value, dict):
        return {name: chosen(condition, item, otherwise[name]) for name, item in value.items()}
    if not isinstance(value, tuple | list):
        return np.where(condition, value, otherwise)
    made = [chosen(condition, one, other) for one, other in zip(value, otherwise, strict=True)]
    return type(value)(*made) if hasattr(value, "_fields") else type(value)(made)
