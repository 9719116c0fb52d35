"""Wrap a model so that jumps are taken relative to a steady background flow; further wrappers of models used by schemes.

A scheme that works face by face preserves every state whose jumps and differences vanish. With jumps relative to the
background it preserves the background, whatever its truncation error, and resolves perturbations of it. Derived here.
"""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import attrs

from fvkit.pointwise import add, subtract
from fvkit.pointwise.part import Wrapper
from fvkit.problem.questions import aux_places


@attrs.frozen(repr=False)
class Deviation(Wrapper):
    """A model whose jumps, differences and waves at a face are those of the state minus those of a steady flow.

    The cell averages of the steady flow are additional aux values, after those of the model.
    """

    def defines(self, name: str) -> bool:
        return name in ("jump", "difference", "balanced_difference", "matrix_product") or self.part.defines(name)

    def jump(self, ql, qr, auxl, auxr):
        auxl, auxr, flowl, flowr = self.split(auxl, auxr)
        return subtract(self.part.jump(ql, qr, auxl, auxr), self.part.jump(flowl, flowr, auxl, auxr))

    def difference(self, ql, qr, auxl, auxr):
        _, _, flowl, flowr = self.split(auxl, auxr)
        return subtract(subtract(qr, ql), subtract(flowr, flowl))

    def balanced_difference(self, ql, qr, auxl, auxr):
        auxl, auxr, flowl, flowr = self.split(auxl, auxr)
        return subtract(self.part.balanced_difference(ql, qr, auxl, auxr),
                        self.part.balanced_difference(flowl, flowr, auxl, auxr))

    def decompose(self, ql, qr, auxl, auxr, jump):
        return self.part.decompose(ql, qr, *self.split(auxl, auxr)[:2], jump)

    def relaxation(self, ql, qr, auxl, auxr, jump):
        auxl, auxr, flowl, flowr = self.split(auxl, auxr)
        own = self.part.jump(flowl, flowr, auxl, auxr)
        waves, speeds = self.part.relaxation(ql, qr, auxl, auxr, add(jump, own))  # which needs the full jump
        standing, _ = self.part.relaxation(flowl, flowr, auxl, auxr, own)
        return tuple(map(subtract, waves, standing)), speeds

    def matrix_product(self, ql, qr, auxl, auxr, v):
        return self.part.matrix_product(ql, qr, *self.split(auxl, auxr)[:2], v)

    def cross(self, ql, qr, auxl, auxr):
        return self.part.cross(ql, qr, *self.split(auxl, auxr)[:2])

    def split(self, auxl: Any, auxr: Any) -> tuple[Any, Any, Any, Any]:
        """Return the aux values of the model on both sides of a face, and the steady flow there."""
        given = len(self.part.aux)
        return auxl[:given], auxr[:given], auxl[given:], auxr[given:]


@attrs.frozen(repr=False)
class Scanning(Wrapper):
    """A scalar model whose wave speeds are also sampled between the two states of a face."""

    scans: ClassVar[bool] = True


@attrs.frozen(repr=False)
class AddingUp(Wrapper):
    """A model whose jump is the sum of a Riemann solver's own waves, ``total(ql, qr, auxl, auxr)``."""

    total: Callable[..., Any]

    def defines(self, name: str) -> bool:
        return name == "jump" or self.part.defines(name)

    def jump(self, ql, qr, auxl, auxr):
        return self.total(ql, qr, auxl, auxr)


@attrs.frozen(repr=False)
class GivenMore(Wrapper):
    """A model with additional aux values for sources, after its own; the methods of the model do not receive them."""

    more: tuple[str, ...]

    @property
    def aux(self) -> tuple[str, ...]:
        """Names of all aux values."""
        return (*self.part.aux, *self.more)

    def __getattr__(self, name: str) -> Any:
        answer = Wrapper.__getattr__(self, name)
        places, own = aux_places(self.part.questions).get(name) if callable(answer) else None, len(self.part.aux)
        if places is None:
            return answer
        return lambda *arguments: answer(*[item[:own] if k in places else item for k, item in enumerate(arguments)])


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
