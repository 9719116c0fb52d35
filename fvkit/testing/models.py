"""`ModelConformance`: conformance checks of a model."""
from collections.abc import Mapping
from functools import partial
from itertools import pairwise
from typing import Any, ClassVar

import attrs
import numpy as np
import pytest

from fvkit import Grid, Model, NoLimiter, Outflow, Periodic, Problem, Stepper, Wall, WavePropagation, solve
from fvkit.problem import answers
from fvkit.problem.directions import directions
from fvkit.problem.questions import check_answers, samples
from fvkit.schemes.cautions import lacks_balance
from fvkit.schemes.method_of_lines import MethodOfLines
from fvkit.schemes.riemann import default_riemann
from fvkit.testing.common import BACKENDS, OnModel, close, matrices, need, rows, solvers, stepped

#: Number of random states of a check.
COUNT = 200


class ModelConformance(OnModel):
    """Conformance checks of a model. A subclass has ``model`` and ``states``; a check that does not apply is set to None.

    Attributes
    ----------
    model : the model.
    smooth : relative size of the waves of the smooth checks.
    large : relative size of larger waves for second order, since a missing `cross` grows with the square of it.
    order : orders that the schemes must reach on smooth data: second order, fifth order.

    Examples
    --------
    ``states`` draws random states that the model can handle:

    >>> import fvkit as fv
    >>> from fvkit.testing import ModelConformance
    >>> class TestBurgers(ModelConformance):
    ...     model = fv.Burgers()
    ...     def states(self, rng, count):
    ...         return rng.uniform(-1.0, 1.0, (1, count))
    >>> TestBurgers().test_equal_states_make_no_jump()  # pytest calls every check, fvkit.testing.run too
    """

    kinds: ClassVar[Mapping[str, type]] = {"model": Model}

    smooth: ClassVar[float] = 0.02
    large: ClassVar[float] = 0.1
    order: ClassVar[tuple[float, float]] = (1.7, 4.3)

    def rest(self, aux: dict[str, np.ndarray]) -> Any:
        """Return a state at rest (num_eqn, count) over given aux values, dry where they rise above 1; None if there is none."""
        return None

    # ------------------------------------------------------------------ helpers

    @property
    def parts(self) -> Model:
        """The model, its open parameters set."""
        return self.model.resolved(self.drawn(3))

    def drawn(self, seed: int, count: int = COUNT) -> np.ndarray:
        """Random states."""
        return self.random(np.random.default_rng(seed), count)

    def face(self, seed: int, step: float = 0.0) -> tuple[Any, Any, Any, Any]:
        """Random states on both sides of faces, and aux values that differ by up to ``step``."""
        rng = np.random.default_rng(seed)
        left, right = (tuple(np.array(self.given(number, COUNT)).reshape(len(self.model.aux), COUNT)
                             + ("flux" not in self.model.takes_aux) * rng.uniform(-step, step, (len(self.model.aux), COUNT)))
                       for number in ((seed, seed + 1) if step else (seed, seed)))
        return tuple(self.drawn(seed)), tuple(self.drawn(seed + 1)), left, right

    def waves(self, cells: int, amplitude: float, boundary: Any = None) -> Problem:
        """A smooth periodic problem near one state, run for half the time a wave needs to cross it, and at most half of that in
        which it may steepen to a shock."""
        base = self.drawn(7, 1)
        size = np.abs(base) + 0.1 * np.abs(base).max()
        given = self.given(7, 1)
        speed = max(float(np.abs(bound).max()) for bound in answers.wave_speeds(self.parts, tuple(base), given)) or 1.0
        aux = {name: partial(_wavy, float(value[0])) for name, value in zip(self.model.aux, given, strict=True)}

        def initial(x: np.ndarray) -> np.ndarray:
            shape = np.array([np.sin(2.0 * np.pi * (x + 0.1 * row)) for row in range(len(base))])
            return base + amplitude * size * shape

        x = np.linspace(0.0, 1.0, 401)
        bounds = answers.wave_speeds(self.parts, tuple(initial(x)), tuple(aux[name](x) for name in self.model.aux))
        steepening = max(float(-np.diff(np.broadcast_to(bound, x.shape)).min()) for bound in bounds) / x[1]
        return Problem(self.model, Grid(0.0, 1.0, cells), initial, 0.5 / max(speed, steepening), aux, boundary or Periodic())

    # ------------------------------------------------------------------ checks

    def test_names_match_the_state(self) -> None:
        assert len(self.drawn(1)) == len(self.model.conserved) == len(set(self.model.conserved))
        assert all(0 <= row < len(self.model.conserved) for row in self.model.mass_rows())

    def test_every_question_gets_an_answer_of_its_form(self) -> None:
        check_answers(self.parts, samples(self.parts, tuple(self.drawn(1)), self.given(1, COUNT)))

    def test_flux_is_finite(self) -> None:
        q = self.drawn(1)
        assert np.isfinite(rows(answers.flux(self.parts, tuple(q), self.given(1, COUNT)), COUNT)).all()

    def test_speeds_bound_the_derivative_of_the_jump(self) -> None:
        q, aux = self.drawn(1), self.given(1, COUNT)
        low, high = (np.broadcast_to(bound, COUNT) for bound in answers.wave_speeds(self.parts, tuple(q), aux))
        speeds = np.linalg.eigvals(matrices(self.parts, q, aux)).real
        width = 1e-5 * (np.abs(speeds).max(axis=1) + 1e-300)
        assert (low - width <= speeds.min(axis=1)).all()
        assert (speeds.max(axis=1) <= high + width).all()

    def test_equal_states_make_no_jump(self) -> None:
        q, flat = tuple(self.drawn(1)), self.given(1, COUNT)
        for name in ("jump", "difference", "balanced_difference"):
            assert not rows(getattr(self.parts, name)(q, q, flat, flat), COUNT).any(), name

    def test_the_jump_changes_its_sign_with_the_path(self) -> None:
        left, right, auxl, auxr = self.face(2, step=0.1)
        there, back = self.parts.jump(left, right, auxl, auxr), self.parts.jump(right, left, auxr, auxl)
        size = np.abs(rows(answers.flux(self.parts, left, auxl), COUNT)).max(axis=0)
        close(rows(there, COUNT), -rows(back, COUNT), 1e-12, size)

    def test_masses_jump_by_their_fluxes(self) -> None:
        left, right, auxl, auxr = self.face(2, step=0.1)
        jump = self.parts.jump(left, right, auxl, auxr)
        for row in self.model.mass_rows():
            here, there = answers.flux(self.parts, left, auxl)[row], answers.flux(self.parts, right, auxr)[row]
            close([jump[row]], [there - here], 1e-12, np.abs(here))

    def test_waves_of_every_solver_add_up_to_the_jump_in_ascending_speeds(self) -> None:
        face = self.face(4, step=0.1)
        jump = self.parts.jump(*face)
        for solver in solvers(self.model):
            waves, speeds = solver.solve(self.parts, *face, jump)
            total = sum(rows(wave, COUNT) for wave in waves)
            close(total, rows(jump, COUNT), 1e-11, np.max([np.abs(rows(wave, COUNT)).max(axis=0) for wave in waves], axis=0))
            if solver.eigenvectors:
                assert (np.diff(rows(speeds, COUNT), axis=0) >= 0.0).all(), solver

    def test_the_decomposition_is_that_of_a_matrix(self) -> None:
        need(self.model, "decompose", "matrix_product")
        face = self.face(4)
        waves, speeds = self.parts.decompose(*face, self.parts.jump(*face))
        for wave, speed in zip(waves, speeds, strict=True):
            product = rows(self.parts.matrix_product(*face, wave), COUNT)
            size = max(float(np.abs(rows(speeds, COUNT)).max()), 1e-300) * np.abs(rows(wave, COUNT)).max(axis=0)
            close(product, np.broadcast_to(speed, COUNT) * rows(wave, COUNT), 1e-6, size)

    def test_modes_are_inverted(self) -> None:
        here, w = self.drawn(5), self.drawn(6)
        back = rows(self.parts.from_modes(tuple(here), self.parts.to_modes(tuple(here), tuple(w))), COUNT)
        close(back, w, 1e-9)

    def test_the_cell_integral_is_that_of_the_jump(self) -> None:
        need(self.model, "cell_integral", "jump")
        from fvkit.pointwise.polynomial import polynomial
        from fvkit.schemes.stages.cell_polynomial import romberg

        q, rng = self.drawn(5), np.random.default_rng(6)
        aux = np.array(self.given(6, COUNT)).reshape(len(self.model.aux), COUNT)
        aux = aux + rng.uniform(-0.1, 0.1, aux.shape)

        def on_cell(mean: np.ndarray) -> tuple[Any, Any, Any]:
            # Small: what a jump adds for the head over a step of the bottom is of third order.
            left, right, third = mean * rng.uniform(-1e-4, 1e-4, (3, *mean.shape))
            return tuple(mean + left), tuple(mean + right), tuple(map(polynomial, mean, mean + left, mean + right, third))

        left, right, inside = on_cell(q)
        _, _, given = on_cell(aux)
        found = rows(self.parts.cell_integral(left, right, inside, given), COUNT)
        close(found, rows(romberg(self.parts, left, right, inside, given), COUNT), 1e-7)

    @pytest.mark.parametrize("backend", BACKENDS)
    def test_a_uniform_state_stays(self, backend: str) -> None:
        q = np.repeat(self.drawn(7, 1), 30, axis=1)
        for scheme in (WavePropagation(solver) for solver in solvers(self.model)):
            aux = {name: float(value[0]) for name, value in zip(self.model.aux, self.given(7, 1), strict=True)}
            problem = Problem(self.model, Grid(0.0, 1.0, 30), q, 1.0, aux, Periodic())
            close(stepped(problem, scheme, 10, 1.0, backend), q, 1e-12)

    @pytest.mark.parametrize("axis", [0, 1])
    def test_a_wave_along_one_axis_of_a_plane_is_that_on_a_line(self, axis: int) -> None:
        n, across = 24, 3
        grid = Grid((0.0, 0.0), ((1.0, 0.1), (0.1, 1.0))[axis], ((n, across), (across, n))[axis])
        try:
            direction = directions(self.model, grid)[axis]
        except ValueError as refused:
            pytest.skip(str(refused))
        line = attrs.evolve(self.waves(n, 5.0 * self.smooth), model=direction.model)
        spread = np.expand_dims(line.q0, 1 + axis)
        q = np.zeros((len(direction.names), *grid.shape))
        q[list(direction.rows)] = spread
        aux = {name: np.broadcast_to(np.expand_dims(values, axis), grid.shape) for name, values in line.aux_averages.items()}
        plane = Problem(self.model, grid, q, line.t_end, aux, Periodic())
        for solver in solvers(self.model):
            ends = [stepped(problem, WavePropagation(solver), 10, line.t_end / n) for problem in (plane, line)]
            found = ends[0][list(direction.rows)]
            assert np.abs(found - np.expand_dims(ends[1], 1 + axis)).max() < 1e-12 * np.abs(q).max(), solver

    def test_what_is_conserved_stays_in_a_closed_circle(self) -> None:
        problem = self.waves(40, 10.0 * self.smooth)
        for solver in solvers(self.model):
            solution = solve(problem, WavePropagation(solver), backend="numpy", nonhyperbolic="ignore")
            kept = range(len(problem.q0)) if not self.model.defines("jump") else self.model.mass_rows()
            for row in kept:
                change = solution.q[-1][row].sum() - problem.q0[row].sum()
                assert abs(change) < 1e-12 * np.abs(problem.q0).sum(), (solver, self.model.conserved[row])

    def test_walls_keep_the_masses(self) -> None:
        if not self.model.phases:
            pytest.skip(f"{type(self.model).__name__} has no phases")
        solution = solve(self.waves(40, 5.0 * self.smooth, Wall()), backend="numpy", nonhyperbolic="ignore")
        assert all(abs(drift) < 1e-13 for drift in solution.stats.mass_drift.values())

    def test_masses_never_turn_negative(self) -> None:
        if not self.model.phases:
            pytest.skip(f"{type(self.model).__name__} has no phases")
        q = self.drawn(8, 60)
        q[:, 20:40] = 0.0
        problem = Problem(self.model, Grid(0.0, 1.0, 60), q, 1.0, boundary=Outflow())
        for solver in solvers(self.model):
            stepper = Stepper(problem, WavePropagation(solver), backend="numpy", nonhyperbolic="ignore")
            for _ in range(40):
                stepper.step()
                assert all(stepper.q[row].min() >= 0.0 for row in self.model.mass_rows()), solver

    @pytest.mark.parametrize("bottom", ["random", "island"])
    def test_rest_stays(self, bottom: str) -> None:
        x = (np.arange(60) + 0.5) / 60
        b = (0.5 * np.random.default_rng(9).random(60) if bottom == "random" else 1.3 * np.exp(-(((x - 0.5) / 0.1) ** 2)))
        aux = dict.fromkeys(self.model.aux, b)
        q = self.rest(aux)
        if q is None:
            pytest.skip(f"{type(self).__name__} gives no state at rest")
        problem = Problem(self.model, Grid(0.0, 1.0, 60), q, 1.0, aux, boundary=Periodic())
        for solver in solvers(self.model):
            for scheme in (WavePropagation(solver), MethodOfLines(solver)):
                assert np.abs(stepped(problem, scheme, 20, 1.0) - q).max() < 1e-13 * np.abs(q).max(), scheme

    def test_no_viscosity_moves_what_is_at_rest_over_a_step(self) -> None:
        if not self.model.aux:
            pytest.skip(f"{type(self.model).__name__} has no aux functions")
        assert not lacks_balance(self.parts, self.drawn(1), self.given(1, COUNT), [0.1] * len(self.model.aux)), \
            "the jump pushes what is at rest over a step of the aux functions: define `balanced_difference`, 0 at rest"

    def test_second_order_where_the_flow_is_smooth(self) -> None:
        for solver in solvers(self.model):
            self.check_order(WavePropagation(solver, NoLimiter()), (20, 40, 80), self.order[0])

    def test_second_order_of_larger_waves(self) -> None:
        """Small waves are almost linear: they hide a `cross` that is missing or wrong."""
        scheme = WavePropagation(default_riemann(self.model), NoLimiter())
        self.check_order(scheme, (40, 80, 160), self.order[0] - 0.2, self.large)

    def test_speeds_between_two_states_are_bounded(self) -> None:
        need(self.model, "speeds_between")
        face = self.face(4)
        low, high = (np.broadcast_to(bound, COUNT) for bound in answers.face_speeds(self.parts, *face))
        for share in np.linspace(0.0, 1.0, 21):
            q, aux = ([(1.0 - share) * left + share * right for left, right in zip(*sides, strict=True)]
                      for sides in (face[:2], face[2:]))
            lower, upper = answers.wave_speeds(self.parts, tuple(q), tuple(aux))
            width = 1e-9 * np.maximum(np.abs(low), np.abs(high))
            assert (low <= lower + width).all()
            assert (upper <= high + width).all()

    def test_fifth_order_where_the_flow_is_smooth(self) -> None:
        from fvkit.schemes.integrators import DP5

        self.check_order(MethodOfLines(default_riemann(self.model), integrator=DP5()), (20, 40, 80), self.order[1])

    def check_order(self, scheme: Any, cells: tuple[int, ...], order: float, size: float | None = None) -> None:
        """Differences of successive grids fall with the order; ``size`` is that of the waves."""
        ends = [solve(self.waves(n, size or self.smooth), scheme, backend="numpy", nonhyperbolic="ignore").q[-1] for n in cells]
        apart = [np.abs(a - 0.5 * (b[:, ::2] + b[:, 1::2])).mean() for a, b in pairwise(ends)]
        found = float(np.log2(apart[-2] / apart[-1]))
        assert found >= order, f"{scheme}: observed order {found:.2f}, expected {order:g}"

    def test_both_backends_agree(self) -> None:
        if "numba" not in BACKENDS:
            pytest.skip("numba is not installed")
        problem = self.waves(70, 5.0 * self.smooth)
        for scheme in (WavePropagation(default_riemann(self.model)), MethodOfLines(default_riemann(self.model))):
            ends = [solve(problem, scheme, backend=backend, nonhyperbolic="ignore").q[-1] for backend in BACKENDS]
            close(ends[0], ends[1], 1e-11)

    def test_a_stop_and_a_new_start_change_nothing(self) -> None:
        problem = self.waves(40, self.smooth)
        whole, cut = (Stepper(problem, WavePropagation(default_riemann(self.model)), backend="numpy", nonhyperbolic="ignore")
                      for _ in range(2))
        whole.run(problem.t_end, 6)
        for _ in range(3):
            cut.run(problem.t_end, 2)
        np.testing.assert_array_equal(whole.q, cut.q)

    def test_a_wrong_state_is_refused_with_its_shape(self) -> None:
        with pytest.raises(ValueError, match="initial"):
            Problem(self.model, Grid(0.0, 1.0, 10), np.ones((len(self.model.conserved) + 1, 10)), 1.0)


def _wavy(base: float, x: np.ndarray) -> np.ndarray:
    """A smooth periodic function around a value; 0 everywhere around 0."""
    return base * (1.0 + 0.1 * np.cos(2.0 * np.pi * x))
