"""MacDonald's channels: steady flow with friction over the bottom that belongs to it, between the ends that a user would take.

Depth and discharge are given in closed form, the bottom is the integral of

    db/dx = (q^2/(g h^3) - 1) dh/dx - 2 q r/(g h^2) - Sf,  q = q(0) + r x with rain r,

as Delestre and others have it (SWASHES, Int. J. Numer. Meth. Fluids 72 (2013) 269-300, DOI 10.1002/fld.3741, section 3.2): semi-exact.
"""

from typing import NamedTuple

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from tests.benchmarks.chapter import G, means

CRITICAL = (4.0 / G) ** (1.0 / 3.0)
LENGTH, JUMP = 1000.0, 500.0


def bulge(share, width):
    """Depth that changes by a share of the critical one in the middle, and its derivative."""
    def depth(x):
        y = x / LENGTH - 0.5
        return CRITICAL * (1.0 + share * np.exp(-width * y * y))

    def derivative(x):
        y = x / LENGTH - 0.5
        return -CRITICAL * share * 2.0 * width * y / LENGTH * np.exp(-width * y * y)

    return depth, derivative


def through_critical():
    def depth(x):
        y = x / LENGTH - 0.5
        return CRITICAL * np.where(x < JUMP, 1.0 - np.tanh(3.0 * y) / 3.0, 1.0 - np.tanh(6.0 * y) / 6.0)

    def derivative(x):
        y = x / LENGTH - 0.5
        return -CRITICAL / LENGTH / np.cosh(np.where(x < JUMP, 3.0, 6.0) * y) ** 2

    return depth, derivative


def with_a_jump():
    terms = tuple(enumerate((-0.348427, 0.552264, -0.55558), start=1))

    def depth(x):
        y = x / LENGTH - 0.5
        behind = 1.0 + sum(c * np.exp(-20.0 * k * y) for k, c in terms) + 0.8 * np.exp(y - 0.5)
        return CRITICAL * np.where(x < JUMP, 0.9 - np.exp(-x / 250.0) / 6.0, behind)

    def derivative(x):
        y = x / LENGTH - 0.5
        behind = sum(-20.0 * k * c * np.exp(-20.0 * k * y) for k, c in terms) + 0.8 * np.exp(y - 0.5)
        return CRITICAL * np.where(x < JUMP, np.exp(-x / 250.0) / 1500.0, behind / LENGTH)

    return depth, derivative


class Channel(NamedTuple):
    """A channel of 1 km: its depth and the derivative of that, discharge at its head in m^2/s, roughness, rain in m/s."""

    shape: tuple
    q: float
    n: float
    rain: float = 0.0

    def discharge(self, x):
        return self.q + self.rain * x

    def froude(self, x):
        return self.discharge(x) / np.sqrt(G * self.shape[0](x) ** 3)


CHANNELS = {"subcritical": Channel(bulge(0.5, 16.0), 2.0, 0.033), "supercritical": Channel(bulge(-0.2, 36.0), 2.5, 0.04),
            "sub- to supercritical": Channel(through_critical(), 2.0, 0.0218), "super- to subcritical": Channel(with_a_jump(), 2.0, 0.0218)}
RAINY = {"subcritical, rain": Channel(bulge(0.5, 16.0), 1.0, 0.033, 1e-3), "supercritical, rain": Channel(bulge(-0.2, 36.0), 2.5, 0.04, 1e-3)}


def levels(channel, edges, parts=16):
    """Bottom at the edges, 0 at the lower end, and its cell averages."""
    depth, derivative = channel.shape

    def slope(x):
        h, q = depth(x), channel.discharge(x)
        return (q**2 / (G * h**3) - 1.0) * derivative(x) - 2.0 * q * channel.rain / (G * h**2) - channel.n**2 * q**2 / h ** (10.0 / 3.0)

    fine = np.linspace(edges[0], edges[-1], parts * (len(edges) - 1) + 1)
    at = np.concatenate([[0.0], np.cumsum(means(slope, fine) * np.diff(fine))])
    at -= at[-1]
    # the mean over a piece is the value at its lower edge and the mean of what the slope adds from there on
    added = means(lambda x: (np.repeat(fine[1:], 8) - x) * slope(x), fine)
    return at[::parts], (at[:-1] + added).reshape(-1, parts).mean(axis=1)


def error(channel, riemann, cells, backend="auto"):
    """Return the mean error of the depth, m, and that of the discharge over the discharge, once the flow is steady."""
    grid = fv.Grid(0.0, LENGTH, cells)
    depth, _ = channel.shape
    at, b = levels(channel, grid.edges)
    h, q = means(depth, grid.edges), means(channel.discharge, grid.edges)
    enters = [depth(0.0)] if channel.froude(0.0) > 1.0 else None
    inflow = gr.Hydrograph([0.0], [channel.q], [0.0], depth=enters)
    outflow = fv.Outflow() if channel.froude(LENGTH) > 1.0 else gr.FixedLevel(at[-1] + depth(LENGTH))
    sources = (gr.Manning(channel.n), *((gr.Rain(channel.rain),) if channel.rain else ()))
    problem = fv.Problem(gr.ShallowWater(g=G), grid, np.stack([h, q]), 3000.0, {"b": b}, (inflow, outflow), sources)
    found = fv.solve(problem, fv.WavePropagation(riemann), backend=backend).q[-1]
    return np.abs(found[0] - h).mean(), np.abs(found[1] / q - 1.0).mean()
