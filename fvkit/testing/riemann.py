"""`RiemannConformance`: conformance checks of a Riemann solver with a model that it serves."""

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import pytest

from fvkit import Grid, Model, Periodic, Problem, RiemannSolver, WavePropagation, solve
from fvkit.problem import answers
from fvkit.testing.common import BACKENDS, OnModel, close, matrices, rows, stepped

#: Number of random faces of a check.
COUNT = 200


class RiemannConformance(OnModel):
    """Conformance checks of a Riemann solver on one model, with random states.

    Attributes
    ----------
    riemann : the solver.
    model : a model that it serves.

    Examples
    --------
    >>> import fvkit as fv
    >>> from fvkit.testing import RiemannConformance
    >>> class TestRoe(RiemannConformance):
    ...     riemann, model = fv.Roe(), fv.Acoustics()
    ...     def states(self, rng, count):
    ...         return rng.uniform(-1.0, 1.0, (2, count))
    >>> TestRoe().test_waves_add_up_to_the_jump()  # pytest calls every check, fvkit.testing.run too
    """

    kinds: ClassVar[Mapping[str, type]] = {"model": Model, "riemann": RiemannSolver}

    riemann: ClassVar[RiemannSolver]

    def face(self, seed: int, step: float = 0.0) -> tuple[Any, Any, Any, Any]:
        """Random states on both sides of faces, and aux values that differ by up to ``step``."""
        rng = np.random.default_rng(seed)
        left, right = (tuple(self.random(rng, COUNT)) for _ in range(2))
        around = np.array(self.given(seed, COUNT)).reshape(len(self.model.aux), COUNT)
        auxl, auxr = (tuple(around + rng.uniform(-step, step, around.shape)) for _ in range(2))
        return left, right, auxl, auxr

    def solved(self, face: tuple[Any, Any, Any, Any]) -> tuple[Any, Any, Any]:
        """The jump of faces, their waves and speeds, as arrays."""
        model = self.model.resolved(np.array(face[0]))
        jump = model.jump(*face)
        waves, speeds = self.riemann.solve(model, *face, jump)
        return rows(jump, COUNT), [rows(wave, COUNT) for wave in waves], rows(speeds, COUNT)

    def test_it_serves_the_model(self) -> None:
        self.riemann.check(self.model)

    def test_waves_add_up_to_the_jump(self) -> None:
        for step in (0.0, 0.3):
            jump, waves, _ = self.solved(self.face(1, step))
            close(sum(waves), jump, 1e-11, np.max([np.abs(wave).max(axis=0) for wave in waves], axis=0))

    def test_one_speed_per_wave_and_all_are_finite(self) -> None:
        _, waves, speeds = self.solved(self.face(2, 0.3))
        assert len(waves) == len(speeds)
        assert np.isfinite(waves).all()
        assert np.isfinite(speeds).all()

    def test_equal_states_send_nothing(self) -> None:
        left, _, auxl, _ = self.face(3)
        _, waves, _ = self.solved((left, left, auxl, auxl))
        flux = np.abs(rows(answers.flux(self.model.resolved(np.array(left)), left, auxl), COUNT)).max(axis=0)
        assert (np.abs(waves).max(axis=(0, 1)) <= 1e-13 * flux).all()

    def test_speeds_reach_as_far_as_what_moves(self) -> None:
        """Between equal states the fastest wave is at least as fast as the matrix of the jump requires, for the time step."""
        left, _, auxl, _ = self.face(4)
        model = self.model.resolved(np.array(left))
        change = tuple(np.array(left) * (1.0 + 1e-9))
        _, _, speeds = self.solved((left, change, auxl, auxl))
        wanted = np.abs(np.linalg.eigvals(matrices(model, np.array(left), auxl)).real).max(axis=1)
        assert (np.abs(speeds).max(axis=0) >= wanted * (1.0 - 1e-5)).all()

    def test_a_run_conserves_and_stays_finite(self) -> None:
        rng = np.random.default_rng(5)
        q = self.random(rng, 50)
        problem = Problem(self.model, Grid(0.0, 1.0, 50), q, 1.0, boundary=Periodic())
        end = stepped(problem, WavePropagation(self.riemann), 30)
        assert np.isfinite(end).all()
        kept = self.model.mass_rows() if self.model.defines("jump") else range(len(q))
        for row in kept:
            assert abs(end[row].sum() - q[row].sum()) < 1e-12 * np.abs(q).sum()

    def test_a_mirrored_run_is_the_mirror_image(self) -> None:
        try:
            signs = np.array(self.model.wall_signs())[:, None]
        except ValueError:
            pytest.skip(f"{type(self.model).__name__} does not say what a wall reflects")
        q = self.random(np.random.default_rng(6), 40)

        def end(state: np.ndarray) -> np.ndarray:
            problem = Problem(self.model, Grid(0.0, 1.0, 40), state, 1.0, boundary=Periodic())
            return stepped(problem, WavePropagation(self.riemann), 5)

        close((signs * end(signs * q[:, ::-1]))[:, ::-1], end(q), 1e-11)

    def test_both_backends_agree(self) -> None:
        q = self.random(np.random.default_rng(7), 60)
        problem = Problem(self.model, Grid(0.0, 1.0, 60), q, 1e-3, boundary=Periodic())
        ends = [solve(problem, WavePropagation(self.riemann), backend=backend, nonhyperbolic="ignore").q[-1]
                for backend in (BACKENDS if self.riemann.compilable else ("numpy",))]
        close(ends[0], ends[-1], 1e-12)
