"""Problems on grids with two axes that several tests ask for."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.problem.directions import in_plane

MODELS = (gr.ShallowWater(), gr.TwoPhase(), gr.Reduced(), gr.TwoLayer())
SOLVERS = (gr.Relaxation(), fv.Roe(), fv.HLL(), fv.Rusanov())
CLOSED = {"west": fv.Wall(), "east": fv.Wall(), "south": fv.Wall(), "north": fv.Wall()}


def square(n, length=10.0, m=None):
    """A grid of n x m cells."""
    return fv.Grid((0.0, 0.0), (length, length), (n, m or n))


def state(model, h, phi, vx=(0.0, 0.0), vy=(0.0, 0.0)):
    """The state of given depth, solid fraction and velocities (solid, fluid) along x and along y."""
    return in_plane(model, model.conserved_from(h, phi, *vx), model.conserved_from(h, phi, *vy))


def rough(model, grid, seed=0, dry=0.3, speed=3.0):
    """Rough data: depths over many orders of magnitude, a share of them dry, absent phases, any velocities, rough bottom."""
    rng = np.random.default_rng(seed)
    h = 10.0**rng.uniform(-6.0, 0.5, grid.shape) * (rng.uniform(size=grid.shape) >= dry)
    phi = rng.choice([0.0, 0.3, 0.6, 1.0], grid.shape)
    speeds = rng.uniform(-speed, speed, (4, *grid.shape))
    return state(model, h, phi, speeds[:2], speeds[2:]), rng.uniform(0.0, 1.0, grid.shape)


def vortex(n, drift=0.0, t_end=0.5, g=9.81):
    """A vortex of shallow water that stands or drifts with velocity (drift, drift), periodic; exact."""
    solved = gr.exact.Vortex(drift=(drift, drift), period=(1.0, 1.0), g=g)

    def at(t):
        def values(x, y):
            h, v_x, v_y = solved.at(x, y, t).values()
            return [h, h * v_x, h * v_y]

        return fv.Problem(gr.ShallowWater(g=g), fv.Grid((0.0, 0.0), (1.0, 1.0), (n, n)), values, t_end, boundary=fv.Periodic())

    return at(0.0), at(t_end).q0


def transposed(q):
    """A state of one phase or more with x and y exchanged: (mass, momentum x, momentum y) for each phase of one mass."""
    rows = [row for k in range(0, len(q), 3) for row in (k, k + 2, k + 1)]
    return np.swapaxes(q[rows], 1, 2)


def hillside(model, cells=(24, 16), t_end=1.5):
    """A heap of debris that runs down a hillside into a closed basin; the rest of the ground is dry."""
    def initial(x, y):
        return state(model, np.where((x - 3.0) ** 2 + (y - 4.5) ** 2 < 4.0, 1.5, 0.0), 0.55)

    sources = (gr.CoulombFriction(0.2), *((gr.ConstantDrag(3.0),) if len(model.phases) > 1 else ()))
    return fv.Problem(model, fv.Grid((0.0, 0.0), (12.0, 8.0), cells), initial, t_end,
                      aux={"b": lambda x, y: np.maximum(5.0 - 0.6 * x, 0.3) + 0.1 * y}, boundary=CLOSED, sources=sources)
