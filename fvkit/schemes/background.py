"""Wrap a model so that jumps are taken relative to a steady background flow; further wrappers of models used by schemes.

A scheme that works face by face preserves every state whose jumps and differences vanish. With jumps relative to the
background it preserves the background, whatever its truncation error, and resolves perturbations of it. Derived here.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

from fvkit.pointwise import add, subtract
from fvkit.problem.fields import seen_as
from fvkit.problem.model import Model
from fvkit.problem.questions import aux_places


def deviation(model: Model) -> Model:
    """Return a model whose jumps, differences and waves at a face are those of the state minus those of a steady flow.

    The cell averages of the steady flow are additional aux values, after those of the model.
    """
    return seen_as(model, _seen_from_flow(type(model)), {})


def scanning(model: Model) -> Model:
    """Return a scalar model whose wave speeds are also sampled between the two states of a face."""
    return seen_as(model, _scanning(type(model)), {})


def adding_up(model: Model, total: Callable[..., Any]) -> Model:
    """Return a model whose jump is the sum of a Riemann solver's own waves, ``total(ql, qr, auxl, auxr)``."""
    class AddingUp(type(model)):  # type: ignore[misc]  # its base is known at run time
        """See `adding_up`."""

        def jump(self, ql, qr, auxl, auxr):
            return total(ql, qr, auxl, auxr)

    AddingUp.__name__, AddingUp.__qualname__ = type(model).__name__, type(model).__qualname__
    return seen_as(model, AddingUp, {})


def given_more(model: Model, more: Sequence[str]) -> Model:
    """Return a model with additional aux values for sources, after its own; the methods of the model do not receive them."""
    return seen_as(model, _given_more(type(model), tuple(more)), {})


@lru_cache(maxsize=64)
def _scanning(kind: type[Model]) -> type[Model]:
    class Scanning(kind):  # type: ignore[misc, valid-type]  # its base is known at run time
        """See `scanning`."""

        scans = True

    Scanning.__name__, Scanning.__qualname__ = kind.__name__, kind.__qualname__
    return Scanning


@lru_cache(maxsize=64)
def _given_more(kind: Any, more: tuple[str, ...]) -> type[Model]:
    class GivenMore(kind):
        """See `given_more`."""

        aux = (*kind.aux, *more)

    def cut(name: str, places: tuple[int, ...]) -> Callable[..., Any]:
        def method(self: Any, *arguments: Any) -> Any:
            return getattr(kind, name)(self, *[item[:len(kind.aux)] if k in places else item for k, item in enumerate(arguments)])

        return method

    may = {one.name for one in kind.questions if one.also}
    for name, places in aux_places(kind.questions).items():
        if kind.defines(name) and (name not in may or name in kind.takes_aux):
            setattr(GivenMore, name, cut(name, places))
    GivenMore.takes_aux = kind.takes_aux
    GivenMore.__name__, GivenMore.__qualname__ = kind.__name__, kind.__qualname__
    return GivenMore


@lru_cache(maxsize=64)
def _seen_from_flow(kind: type[Model]) -> type[Model]:
    given = len(kind.aux)

    def split(auxl: Any, auxr: Any) -> tuple[Any, Any, Any, Any]:
        return auxl[:given], auxr[:given], auxl[given:], auxr[given:]

    class Deviation(kind):  # type: ignore[misc, valid-type]  # its base is known at run time
        """See `deviation`."""

        def jump(self, ql, qr, auxl, auxr):
            auxl, auxr, flowl, flowr = split(auxl, auxr)
            return subtract(kind.jump(self, ql, qr, auxl, auxr), kind.jump(self, flowl, flowr, auxl, auxr))

        def difference(self, ql, qr, auxl, auxr):
            _, _, flowl, flowr = split(auxl, auxr)
            return subtract(subtract(qr, ql), subtract(flowr, flowl))

        def balanced_difference(self, ql, qr, auxl, auxr):
            auxl, auxr, flowl, flowr = split(auxl, auxr)
            return subtract(kind.balanced_difference(self, ql, qr, auxl, auxr),
                            kind.balanced_difference(self, flowl, flowr, auxl, auxr))

        def decompose(self, ql, qr, auxl, auxr, jump):
            return kind.decompose(self, ql, qr, auxl[:given], auxr[:given], jump)

        def relaxation(self, ql, qr, auxl, auxr, jump):
            auxl, auxr, flowl, flowr = split(auxl, auxr)
            plain: Any = seen_as(self, kind, {})  # the unwrapped model, whose relaxation needs the full jump
            own = plain.jump(flowl, flowr, auxl, auxr)
            waves, speeds = plain.relaxation(ql, qr, auxl, auxr, add(jump, own))
            standing, _ = plain.relaxation(flowl, flowr, auxl, auxr, own)
            return tuple(map(subtract, waves, standing)), speeds

        def matrix_product(self, ql, qr, auxl, auxr, v):
            return kind.matrix_product(self, ql, qr, auxl[:given], auxr[:given], v)

        def cross(self, ql, qr, auxl, auxr):
            return kind.cross(self, ql, qr, auxl[:given], auxr[:given])

    for name in ("decompose", "relaxation", "cross"):
        if not kind.defines(name):
            setattr(Deviation, name, getattr(kind, name))
    Deviation.__name__, Deviation.__qualname__ = kind.__name__, kind.__qualname__
    return Deviation


class Background(NamedTuple):
    """Background flow in a cell: its average, face values, third mode and residual."""

    mean: Any
    left: Any
    right: Any
    third: Any
    residual: Any


def of_background(model, aux):
    """Return the `Background` stored after the model's aux values of a cell; None without a background."""
    rows, own = len(model.conserved), len(model.aux)
    behind = aux[own:]
    return Background(*(behind[k:k + rows] for k in range(0, 5 * rows, rows))) if behind else None
