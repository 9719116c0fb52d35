"""What the conformance suites share."""
import json
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

from fvkit import Model, Problem, RiemannSolver, Scheme, Stepper, validation
from fvkit.backends.compiled.numba_kernel import available
from fvkit.schemes.riemann import HLL, Roe, Rusanov, default_riemann

#: The backends that are installed.
BACKENDS = ("numpy", "numba") if available() else ("numpy",)


class Suite:
    """What the suites of parts share: the parts are instances, and random states have the shape of the model."""

    kinds: ClassVar[Mapping[str, type]] = {}

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        for name, kind in cls.kinds.items():
            if name in vars(cls):
                validation.instance(vars(cls)[name], f"{name} of {cls.__name__}", kind)


class OnModel(Suite):
    """A suite that draws states of ``model``."""

    model: ClassVar[Model]

    def test_it_is_data(self) -> None:
        for name in self.kinds:
            check_is_data(getattr(self, name))

    def states(self, rng: np.random.Generator, count: int) -> Any:
        """Return random admissible states (num_eqn, count) within the range of the model."""
        raise NotImplementedError(f"define states(rng, count) of {type(self).__name__}")

    def aux(self, rng: np.random.Generator, count: int) -> Any:
        """Return random aux values (num_aux, count) of a model that cannot take 0, such as densities; 0 by default."""
        return np.zeros((len(self.model.aux), count))

    def given(self, seed: int, count: int) -> tuple[Any, ...]:
        """`aux`, of the right shape."""
        shape = (len(self.model.aux), count)
        return tuple(validation.array(self.aux(np.random.default_rng(seed), count), "aux(rng, count)", shape))

    def random(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """`states`, of the right shape."""
        return validation.array(self.states(rng, count), "states(rng, count)", (len(self.model.conserved), count))


def solvers(model: Model) -> list[RiemannSolver]:
    """Return the Riemann solvers that serve a model, its default among them."""
    found: list[RiemannSolver] = [solver for solver in (Roe(), HLL(), Rusanov()) if solver.serves(model)]
    own = default_riemann(model)
    return found if own in found else [own, *found]


def stepped(problem: Problem, scheme: Scheme, steps: int, dt: float | None = None, backend: str = "numpy") -> np.ndarray:
    """Return the state after so many steps, each of at most ``dt``, s."""
    stepper = Stepper(problem, scheme, backend, nonhyperbolic="ignore")
    for _ in range(steps):
        stepper.step(dt)
    return stepper.q.copy()


def need(part: Any, *names: str) -> None:
    """Skip a check of a method that a part does not define."""
    for name in names:
        if not part.defines(name):
            pytest.skip(f"{type(part).__name__} defines no {name}")


def rows(values: Any, count: int) -> np.ndarray:
    """Return a tuple of components, numbers among them, as an array (components, count)."""
    return np.array([np.broadcast_to(value, count) for value in values])


def close(found: Any, wanted: Any, tolerance: float, scale: Any = 0.0) -> None:
    """Compare relative to the largest of both sides and ``scale``, column by column."""
    found, wanted = np.asarray(found), np.asarray(wanted)
    size = np.maximum(np.maximum(np.abs(found).max(axis=0), np.abs(wanted).max(axis=0)), scale) + 1e-300
    worst = np.abs(found - wanted).max(axis=0) / size
    assert worst.max() <= tolerance, f"differs by {worst.max():.2e} of its size, allowed are {tolerance:g}"


def check_is_data(part: Any) -> None:
    """A part is frozen and hashable, equal to its copy, and its parameters are plain numbers."""
    assert attrs.has(type(part)), f"decorate {type(part).__name__} with @attrs.frozen"
    hash(part)
    assert attrs.evolve(part) == part
    json.dumps(part.parameters())
    for name in part.parameter_names():
        with pytest.raises(attrs.exceptions.FrozenInstanceError):
            setattr(part, name, 0.0)


def matrices(model: Model, q: np.ndarray, aux: tuple[Any, ...]) -> np.ndarray:
    """Return the derivatives of ``jump`` at states q over aux values by central differences, (count, num_eqn, num_eqn)."""
    size = 1e-6 * (np.abs(q).max(axis=0) + 1e-300)
    columns = []
    for row in range(len(q)):
        change = np.zeros_like(q)
        change[row] = size
        columns.append(rows(model.jump(tuple(q - change), tuple(q + change), aux, aux), q.shape[1]) / (2.0 * size))
    return np.moveaxis(np.array(columns), (0, 1, 2), (2, 1, 0))
