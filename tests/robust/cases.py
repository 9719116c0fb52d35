"""Runs that several robustness tests share."""

import hashlib
import os
import resource
from contextlib import contextmanager
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr

TIMES = [0.05, 0.13, 0.3]

#: A dozen kernels: every Riemann solver, both families of schemes, several limiters and models.
SETTINGS = tuple((model, scheme) for model in (gr.TwoPhase, gr.ShallowWater) for scheme in (
    fv.WavePropagation(gr.Relaxation()), fv.WavePropagation(gr.Relaxation(), fv.Superbee()), fv.WavePropagation(fv.HLL(), order=1),
    fv.WavePropagation(fv.Roe(), fv.VanLeer(), splitting=fv.Godunov()), fv.WavePropagation(fv.Rusanov()),
    fv.MethodOfLines(fv.HLL(), fv.WENO5(), fv.SSPRK3())))


def avalanche(model=gr.TwoPhase, cells=60, t_end=0.3, depth=0.3, drag=2.0):
    """A dam break over a hump, with drag, between a wall and an open end."""
    scene = gr.Scene((-1.0, 2.0), t_end, lambda x: {"h": np.where(x < 0, 1.0, depth), "phi": 0.6 - 0.1 * np.tanh(x), "vs": 0.2},
                     bottom=lambda x: 0.1 * np.exp(-(x**2)), boundary=(fv.Wall(), fv.Outflow()), sources=gr.ConstantDrag(drag))
    return scene.problem(model, cells)


def shaken(number, backend="numpy"):
    """Run one of the random settings; return a digest of all that does not hang on the clock."""
    rng = np.random.default_rng([7, number])
    model, scheme = SETTINGS[rng.integers(len(SETTINGS))]
    problem = avalanche(model, int(rng.integers(20, 60)), float(rng.uniform(0.02, 0.06)), float(rng.uniform(0.2, 0.9)),
                        float(rng.uniform(0.0, 5.0)))
    solution = fv.solve(problem, scheme, backend=backend, nonhyperbolic="ignore", throw=False)
    stats = solution.stats
    told = (solution.status, stats.steps, stats.rejected, stats.max_cfl, stats.nonhyperbolic_faces, stats.mass_drift)
    return hashlib.sha256(solution.t.tobytes() + solution.q.tobytes() + repr(told).encode()).hexdigest()


def forked(work):
    """Run ``work()`` in a child that is forked now; return its process id. The child ends without cleaning up."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            code = work() or 0
        finally:
            os._exit(code)
    return child


@contextmanager
def full_disk(size):
    """No file may grow beyond ``size`` bytes: what a full disk does, with another number of the error."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def resident(name="VmRSS"):
    """Memory of this process, bytes: VmRSS now, VmHWM at its peak."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(f"{name}:"):
            return 1024 * int(line.split()[1])
    raise OSError(f"/proc/self/status has no {name}")
