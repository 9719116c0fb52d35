"""Riemann solvers written to PyClaw's Python contract, as they are."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import _validate
from fvkit.riemann.base import RiemannSolver


def _function(value: Any) -> Any:
    if not callable(value):
        raise TypeError("`function` must be a Riemann solver f(q_l, q_r, aux_l, aux_r, problem_data), got "
                        f"{_validate.shown(value)}")
    return value


def _data(value: Any) -> Any:
    return _validate.mapping(value, "problem_data", "{'u': 1.0}")


@attrs.frozen
class PyClawRiemann(RiemannSolver):
    """A solver ``(q_l, q_r, aux_l, aux_r, problem_data) -> (wave, s, amdq, apdq)`` of PyClaw's Python form.

    Arrays are (num_eqn, num_faces), ``wave`` is (num_eqn, num_waves, num_faces), ``s`` is (num_waves, num_faces). The waves
    become f-waves, Z_k = s_k W_k; what they miss of the model's jump (rounding, or a source) is shared among them in equal
    parts, so that every solver conserves.

    Parameters
    ----------
    function : the solver.
    problem_data : what it receives as ``problem_data``.
    fwave : whether its waves are f-waves already.

    Notes
    -----
    Runs on the NumPy backend only: the function needs whole arrays. ``amdq`` and ``apdq`` are not used: an entropy fix
    that lives there is not seen, the scheme has its own (Roe). The model gives flux, wave speeds and, for the first time
    step, bounds; it should be the one that the function was written for, with ``flux(q, aux)`` where that depends on x. Where its
    flux is another and it has no ``matrix_product``, the run is first order, on the waves of the function, and warns.

    Source: the contract of PyClaw's Python solvers, www.clawpack.org (clawpack.riemann).
    """

    compilable: ClassVar[bool] = False

    function: Callable[..., Any] = attrs.field(converter=_function)
    problem_data: Mapping[str, Any] = attrs.field(factory=dict, converter=_data, hash=False)
    fwave: bool = _validate.switch(False)

    def solve(self, model, ql, qr, auxl, auxr, jump):
        wave, speed = self._waves(ql, qr, auxl, auxr)
        missing = (np.array([np.broadcast_to(row, wave.shape[2:]) for row in jump]) - wave.sum(axis=1)) / wave.shape[1]
        return (tuple(tuple(wave[:, k] + missing) for k in range(wave.shape[1])), tuple(speed))

    def total(self, ql, qr, auxl, auxr):
        return tuple(self._waves(ql, qr, auxl, auxr)[0].sum(axis=1))

    def _waves(self, ql: Any, qr: Any, auxl: Any, auxr: Any) -> tuple[Any, Any]:
        """The f-waves of the function, (num_eqn, num_waves, num_faces), and their speeds."""
        shape = np.broadcast(*ql, *qr).shape
        left, right, given_left, given_right = (np.array([np.broadcast_to(row, shape) for row in side])
                                                for side in (ql, qr, auxl, auxr))
        wave, speed, _, _ = self.function(left, right, given_left, given_right, dict(self.problem_data))
        return wave if self.fwave else wave * speed, speed
