"""`RiemannSolver`: the abstract base, and which solver fits which model."""

from abc import ABC, abstractmethod
from typing import ClassVar

import attrs

from fvkit.model import Model
from fvkit.part import Part, default


@attrs.frozen
class RiemannSolver(Part, ABC):
    """Abstract Riemann solver in f-wave form. Contract:

    1. ``solve(model, ql, qr, auxl, auxr, jump)`` returns (waves, speeds): tuples, one entry per wave family; a
       wave has one component per equation. Pointwise.
    2. The waves add up to ``jump``, to rounding, for any data: that is conservation and balance at once.
    3. It asks the model questions (``model.balanced_difference(...)``) and never which model it is;
       ``needs`` names the questions without a usable default.
    4. ``eigenvectors = True`` says that each wave is an eigenvector of the Roe-mean matrix with its speed; else
       second order takes the matrix itself from ``model.matrix_product``.
    5. ``positive = True`` says that masses stay non-negative for any data; else the scheme falls back to the model's
       ``relaxation``, where it defines one, at faces next to dry ground.
    6. ``compilable = False`` says that it needs whole arrays: it runs on the NumPy backend, and its code is not checked.
    7. ``bounds = True`` says that its speeds are bounds from `fvkit.answers.face_speeds`: they must hold for all states between.
    8. The time step keeps every |speed| dt/dx below the CFL number, so speeds bound the true ones.
    """

    needs: ClassVar[tuple[str, ...]] = ()
    eigenvectors: ClassVar[bool] = False
    positive: ClassVar[bool] = False
    compilable: ClassVar[bool] = True
    bounds: ClassVar[bool] = False

    @abstractmethod
    def solve(self, model, ql, qr, auxl, auxr, jump):
        """Return (waves, speeds) of the face whose total fluctuation is ``jump``."""

    @default
    def total(self, ql, qr, auxl, auxr):
        """Return what the solver's own waves add up to, for one that finds them without the model's jump. Asked only where
        defined: of a model whose flux is another the run is first order, and says so."""
        raise NotImplementedError(f"{type(self).__name__} defines no `total`: its waves add up to the jump of the model")

    @classmethod
    def serves(cls, model: Model | type[Model]) -> bool:
        """Whether a model answers what the solver needs."""
        return all(model.defines(need) for need in cls.needs)

    def check(self, model: Model) -> None:
        """Raise ValueError, naming what is missing and what fits, if the solver cannot serve ``model``."""
        missing = [need for need in self.needs if not model.defines(need)]
        if missing:
            fitting = sorted(kind.__name__ for kind in RiemannSolver.__subclasses__()
                             if kind.serves(model))
            raise ValueError(f"{type(self).__name__} cannot serve {type(model).__name__}: the model does not define "
                             f"{', '.join(f'`{name}`' for name in missing)}. "
                             f"Solvers that fit it: {', '.join(fitting) or 'none'}")
