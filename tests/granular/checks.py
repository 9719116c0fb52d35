"""What every model with two masses must pass, whatever its equations."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.scenes.library.model_differences import layers
from tests.cases import (
    SOLVERS,
    Stepper,
    l1,
    pseudo_spectral,
    slip_over_bottom,
    slip_over_bottom_conserved,
    solve,
    spectral_averages,
)

G = 9.81


def serving(model):
    """The Riemann solvers that serve a model."""
    return tuple(solver for solver in (*SOLVERS, gr.Relaxation()) if all(model.defines(need) for need in solver.needs))


def random_faces(seed, count=1000, thinnest=0.3, fastest=3.0):
    """Primitive states (hs, vs, hf, vf) on both sides of random faces."""
    rng = np.random.default_rng(seed)
    return tuple(np.array([rng.uniform(thinnest, 3.0, count), rng.uniform(-fastest, fastest, count),
                           rng.uniform(thinnest, 3.0, count), rng.uniform(-fastest, fastest, count)]) for _ in range(2))


def conserved(primitive):
    hs, vs, hf, vf = primitive
    return np.array([hs, hs * vs, hf, hf * vf])


def integral_along(path, matrix, nodes=40):
    """Integral of A(q) dq over s in (0, 1): ``path`` maps s to q, complex s included, ``matrix`` q to (4, 4, n)."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    total = 0.0
    for point, weight in zip(0.5 + 0.5 * points, 0.5 * weights, strict=True):
        tangent = path(point + 1e-30j).imag / 1e-30
        total = total + weight * np.einsum("ijn,jn->in", matrix(path(point)), tangent)
    return total


def check_the_waves_add_up(model, seed=5, count=4000):
    """For any data: depths over nine decades and more, Froude numbers to 100, absent masses, steps of the bottom."""
    rng = np.random.default_rng(seed)
    sides = []
    for _ in range(2):
        hs, hf = 10.0 ** rng.uniform(-9.0, 0.5, (2, count))
        hs, hf = np.where(rng.random(count) < 0.1, 0.0, hs), np.where(rng.random(count) < 0.1, 0.0, hf)
        froude = rng.uniform(-100.0, 100.0, (2, count)) * np.where(rng.random(count) < 0.5, 1.0, 0.01)
        sides.append(conserved((hs, froude[0] * np.sqrt(G * (hs + hf)), hf, froude[1] * np.sqrt(G * (hs + hf)))))
    bl, br = np.where(rng.random(count) < 0.5, 0.0, rng.uniform(-1.0, 1.0, (2, count)))
    face = (tuple(sides[0]), tuple(sides[1]), (bl,), (br,))
    for solver in serving(model):
        with np.errstate(all="ignore"):
            jump = model.jump(*face)
            waves, speeds = solver.solve(model, *face, jump)
            waves = np.array([[np.broadcast_to(item, count) for item in wave] for wave in waves])
        first, second = sides[0][0] + sides[1][0], sides[0][2] + sides[1][2]
        some = np.minimum(first, second) > 0.0 if solver.eigenvectors else first + second > 0.0  # else no eigenvectors: the fallback
        size = 1e-300 + np.abs(jump).max(axis=0) + np.abs(waves).max(axis=(0, 1))
        assert np.isfinite(waves[..., some]).all(), solver
        assert all(np.isfinite(speed[some]).all() for speed in speeds), solver
        assert (np.abs(waves.sum(axis=0) - jump) / size)[:, some].max() < 1e-13, solver


def steps(problem, scheme, count):
    """The stepper after a number of steps."""
    stepper = Stepper(problem, scheme, nonhyperbolic="ignore")
    for _ in range(count):
        stepper.step()
    return stepper


def schemes(model, orders=(1, 2)):
    return [fv.WavePropagation(solver, order=order) for solver in serving(model) for order in orders]


def check_masses_are_kept(model):
    """Rough data on a ring over a bottom."""
    rng = np.random.default_rng(4)
    q = model.conserved_from(rng.uniform(0.8, 1.2, 60), rng.uniform(0.3, 0.7, 60), *rng.uniform(0.2, 0.8, (2, 60)))
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 60), q, 1e3, {"b": lambda x: 0.1 * np.sin(2.0 * np.pi * x)}, fv.Periodic())
    for scheme in schemes(model):
        stepper = steps(problem, scheme, 100)
        np.testing.assert_allclose(stepper.q[[0, 2]].sum(axis=1), q[[0, 2]].sum(axis=1), rtol=1e-13)
        assert np.abs(stepper.q - q).max() > 0.01


def order_errors(model, solver, forces, cross_term=True):
    """L1 errors of smooth flow with slip over a bottom, on 40 to 320 cells."""
    reference, errors = pseudo_spectral(0.15, forces=forces), []
    for cells in (40, 80, 160, 320):
        grid = fv.Grid(0.0, 1.0, cells)
        problem = fv.Problem(model, grid, slip_over_bottom_conserved, 0.15, {"b": lambda x: slip_over_bottom(x)[4]}, fv.Periodic())
        solution = solve(problem, fv.WavePropagation(solver, cross_term=cross_term))
        errors.append(l1(grid, solution.q[-1] - spectral_averages(reference, grid)))
    return errors


def check_both_backends_agree(model, solver):
    """Slip, varying phi, a bottom with a step, an absent mass: 50 steps."""
    def initial(x):
        return model.conserved_from(1.0 + 0.2 * np.sin(2.0 * np.pi * x), np.where(x < 0.8, 0.5 + 0.2 * np.cos(2.0 * np.pi * x), 1.0),
                                    0.3 + 0.2 * np.sin(2.0 * np.pi * x), 0.1)

    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 64), initial, 1e3, {"b": lambda x: np.where(x > 0.7, 0.05, 0.1 * x)}, fv.Wall())
    steppers = [fv.Stepper(problem, fv.WavePropagation(solver), backend=backend, nonhyperbolic="ignore")
                for backend in ("numba", "numpy")]
    for stepper in steppers:
        for _ in range(50):
            stepper.step()
    compiled, plain = steppers
    assert compiled.t == plain.t or abs(compiled.t / plain.t - 1.0) < 1e-12
    assert np.abs(compiled.q - plain.q).max() <= 1e-12 * np.abs(plain.q).max()


#: (h, phi, vs, vf) left and right, and the bottom on the right: vacuum, absent masses, violent flow.
HARD = [
    ((1.0, 0.6, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0), 0.0), ((0.0, 0.0, 0.0, 0.0), (2.0, 1.0, 0.0, 0.0), 0.5),
    ((1.0, 1.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.0), ((3.0, 0.7, 0.0, 0.0), (1e-9, 0.3, 0.0, 0.0), 0.0),
    ((1.0, 0.6, -8.0, -8.0), (1.0, 0.6, 8.0, 8.0), 0.0), ((1.0, 0.6, 8.0, 8.0), (1.0, 0.6, -8.0, -8.0), 0.0),
    ((1.0, 0.6, 1.0, -1.0), (0.5, 0.2, 0.0, 0.0), 0.4), ((1.0, 1e-9, 0.0, 0.0), (0.5, 1.0 - 1e-9, 0.0, 0.0), -0.5),
    ((1.0, 0.0, 2.0, 2.0), (0.0, 0.0, 0.0, 0.0), 2.0), ((0.2, 0.5, 3.0, 1.0), (0.1, 0.5, 0.0, 0.0), 1.0),
    ((1.0, 0.6, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), 0.0), ((2.0, 0.4, 20.0, 20.0), (1e-3, 0.6, -1.0, 1.0), 0.0),
]


def check_masses_stay_positive(model, scheme):
    for left, right, step in HARD:
        def initial(x, left=left, right=right):
            return model.conserved_from(*(np.where(x < 0.0, a, b) for a, b in zip(left, right, strict=True)))

        def bottom(x, step=step):
            return np.where(x < 0.0, 0.0, step)

        problem = fv.Problem(model, fv.Grid(-5.0, 5.0, 50), initial, 1e3, {"b": bottom}, fv.Wall())
        stepper = steps(problem, scheme, 40)
        assert np.isfinite(stepper.q).all(), (left, right, step)
        assert stepper.q[[0, 2]].min() >= 0.0, (left, right, step)


def two_layers(model, above, below):
    """Conserved state at rest of an upper and a lower layer."""
    flow = layers(above, below)
    return model.conserved_from(flow["h"], flow["phi"])
