"""Sources that vary over the grid and in time: manufactured solutions, fields of sources, and what is said of wrong ones."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr

G = 9.81
WAVE = fv.WavePropagation(fv.Roe(), fv.NoLimiter())
LINES = fv.MethodOfLines(fv.HLL())

#: The method of lines says that it alternates these sources with the transport: tested once, below.
pytestmark = pytest.mark.filterwarnings("ignore:SSPRK104 alternates:UserWarning")


# ---------------------------------------------------------------------- a manufactured solution of shallow water over a bottom

K, OMEGA = 2.0 * np.pi, 3.0


def exact(x, t):
    """h = 2 + .3 cos(K x - OMEGA t) and v = .5 + .2 sin(K x + OMEGA t) over b = .2 sin(K x), of period 1."""
    h, v = 2.0 + 0.3 * np.cos(K * x - OMEGA * t), 0.5 + 0.2 * np.sin(K * x + OMEGA * t)
    return [h, h * v]


def rate(x, t):
    """What its equations leave, by the chain rule."""
    wave, swing = K * x - OMEGA * t, K * x + OMEGA * t
    h, v = exact(x, t)[0], 0.5 + 0.2 * np.sin(swing)
    h_t, h_x, v_t, v_x = 0.3 * OMEGA * np.sin(wave), -0.3 * K * np.sin(wave), 0.2 * OMEGA * np.cos(swing), 0.2 * K * np.cos(swing)
    mass = h_t + h_x * v + h * v_x
    return [mass, v * mass + h * (v_t + v * v_x) + G * h * (h_x + 0.2 * K * np.cos(K * x))]


def manufactured(cells, t_end=0.25):
    return fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, cells), lambda x: exact(x, 0.0), t_end, {"b": lambda x: 0.2 * np.sin(K * x)},
                      fv.Periodic(), fv.Forcing(rate))


def error(solution):
    wanted = fv.Problem(gr.ShallowWater(), solution.grid, lambda x: exact(x, solution.t[-1]), 1.0).q0
    return np.abs(solution.q[-1] - wanted).mean(axis=1)


def test_the_method_of_lines_says_that_it_is_of_second_order_with_a_source_beside_it():
    with pytest.warns(UserWarning, match="SSPRK104 alternates Forcing with the transport: the run is of second order in time"):
        fv.solve(manufactured(20, t_end=0.01), LINES, backend="numpy")


@pytest.mark.parametrize(("scheme", "least"), [(WAVE, 1.95), (LINES, 1.95)], ids=["wave", "lines"])
def test_a_manufactured_solution_converges_at_second_order(scheme, least, backend):
    coarse, fine = (error(fv.solve(manufactured(cells), scheme, backend=backend)) for cells in (100, 200))
    assert (np.log2(coarse / fine) >= least).all(), np.log2(coarse / fine)


def test_what_forcing_makes_of_masses_is_booked(backend):
    solution = fv.solve(manufactured(50), WAVE, backend=backend)
    assert abs(solution.stats.mass_drift["h"]) < 1e-13


@pytest.mark.parametrize("scheme", [WAVE, LINES], ids=["wave", "lines"])
def test_both_backends_agree(scheme):
    pytest.importorskip("numba", reason="the compiled backend needs the extra `fast`")
    one, two = (fv.solve(manufactured(600, 0.05), scheme, backend=backend) for backend in ("numpy", "numba"))
    np.testing.assert_allclose(one.q, two.q, rtol=1e-12, atol=1e-12)


def test_a_run_goes_on_bit_for_bit(tmp_path, backend):
    file = tmp_path / "forced.npz"
    whole = fv.solve(manufactured(50), WAVE, times=[0.1, 0.25], backend=backend)
    with pytest.raises(fv.SolveError):
        fv.solve(manufactured(50), WAVE, times=[0.1, 0.25], backend=backend, checkpoint=fv.Checkpoint(file), limits=fv.Limits(steps=20))
    with pytest.raises(ValueError, match=r"sources\[0\].rate is .*rate, which no file can hold; or give `problem` to fvkit.resume"):
        fv.resume(file)
    again = fv.resume(file, problem=manufactured(50))
    np.testing.assert_array_equal(again.q, whole.q)
    assert again.stats.entered_by_sources == whole.stats.entered_by_sources


def test_forcing_in_the_rates_of_the_scheme():
    """`rhs` has the rates of sources at its own time."""
    problem = fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, 10), np.ones((1, 10)), 1.0, boundary=fv.Periodic(),
                         sources=fv.Forcing(lambda x, t: [np.full_like(x, 3.0 * t)]))
    np.testing.assert_allclose(fv.rhs(problem)(2.0, np.ones((1, 10))), 6.0, rtol=1e-12)


# ---------------------------------------------------------------------- fields of sources of one's own

@attrs.frozen
class Decay(fv.Source):
    """dq/dt = -k q, k any field, no converter."""

    k: float

    def step(self, model, q, aux, dt):
        return (q[0] * np.exp(-self.k * dt),)

    def rate(self, model, q, aux):
        return (-self.k * q[0],)


def decaying(k, cells=20, **settings):
    return fv.Problem(fv.Advection(0.0), fv.Grid(0.0, 1.0, cells), np.ones((1, cells)), 1.0, sources=Decay(k), **settings)


@pytest.mark.parametrize("scheme", [fv.WavePropagation(fv.Roe()), fv.MethodOfLines(fv.Roe())], ids=["wave", "lines"])
@pytest.mark.parametrize("k", [lambda x: 2.0 * x, 2.0 * fv.Grid(0.0, 1.0, 20).centers, lambda x, t: 4.0 * x * t],
                         ids=["function of x", "averages", "function of x and t"])
def test_a_field_of_any_source_may_vary(k, scheme, backend):
    stepper = fv.Stepper(decaying(k), scheme, backend)
    for _ in range(10):
        stepper.step(0.1)
    np.testing.assert_allclose(stepper.q[0], np.exp(-2.0 * stepper.problem.grid.centers), rtol=1e-12)


@attrs.frozen
class Tilted(fv.Model):
    """Takes exactly its own aux values."""

    conserved = ("u",)
    aux = ("c",)

    def flux(self, q, aux):
        (c,) = aux
        return (c * q[0],)

    def wave_speeds(self, q, aux):
        (c,) = aux
        return c, c

    def decompose(self, ql, qr, auxl, auxr, jump):
        (cl,), (cr,) = auxl, auxr
        return (jump,), (0.5 * (cl + cr),)


@pytest.mark.parametrize("scheme", [fv.WavePropagation(fv.Roe()), fv.MethodOfLines(fv.Roe())], ids=["wave", "lines"])
def test_models_see_their_own_aux_values_alone(scheme, backend):
    problem = fv.Problem(Tilted(), fv.Grid(0.0, 1.0, 40), lambda x: [np.exp(-50.0 * (x - 0.5) ** 2)], 0.2, {"c": 1.0}, fv.Periodic(),
                         Decay(lambda x: 1.0 + 0.0 * x))
    q = fv.solve(problem, scheme, backend=backend).q[-1]
    free = fv.solve(attrs.evolve(problem, sources=()), scheme, backend=backend).q[-1]
    np.testing.assert_allclose(q, np.exp(-0.2) * free, rtol=1e-12)


def test_ghost_cells_of_a_field_follow_the_cells_that_they_look_at():
    ring = attrs.evolve(decaying(np.arange(20.0)), boundary=fv.Periodic())
    kernel = fv.Stepper(ring, fv.WavePropagation(fv.Roe()), "numpy")._kernel
    np.testing.assert_array_equal(kernel.padded_aux()[0], np.arange(-kernel.halo, 20 + kernel.halo) % 20)


# ---------------------------------------------------------------------- what is refused

def test_wrong_fields_are_refused():
    with pytest.raises(ValueError, match=r"`k of Decay` must have shape \(20,\), got \(5,\)"):
        decaying(np.ones(5))
    with pytest.raises(ValueError, match=r"`rate of Forcing\(x\)` must return shape \(2, 500\)"):
        attrs.evolve(manufactured(100), sources=fv.Forcing(lambda x: x))
    with pytest.raises(ValueError, match=r"`rate` must be a function of x or of \(x, t\), or have shape \(num_eqn, num_cells\), got"):
        fv.Forcing([1.0, 2.0])


def test_a_field_that_leaves_its_range_later_ends_the_run(backend):
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 10), [np.ones(10), np.ones(10)], 1.0,
                         sources=gr.Manning(lambda x, t: 0.1 - t + 0.0 * x))
    with pytest.raises(ValueError, match=r"`n` must be finite and >= 0, got -.*of Manning in cell 0 at x = 0.05"):
        fv.solve(problem, backend=backend)
