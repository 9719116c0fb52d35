"""Backends: who runs the stages of a scheme."""

import os
from typing import Any

from fvkit import validation
from fvkit.backends.compiled.numba_kernel import SWITCH, NumbaKernel, available, switched_off
from fvkit.backends.compiled.numba_sweeps import NumbaPlaneKernel
from fvkit.backends.compiled.threads import SMALLEST, ThreadedKernel
from fvkit.backends.kernel import Kernel
from fvkit.backends.march import March, Outcome
from fvkit.backends.numpy_kernel import NumpyKernel
from fvkit.backends.numpy_sweeps import NumpyPlaneKernel
from fvkit.pointwise.tracing import Untraceable
from fvkit.problem.problem import Problem
from fvkit.schemes.riemann import RiemannSolver
from fvkit.schemes.scheme import Parts, Scheme

#: Names of the backends, and the environment variable that replaces ``"auto"``.
BACKENDS, VARIABLE = ("auto", "numba", "numpy"), "FVKIT_BACKEND"

__all__ = [
    "BACKENDS",
    "Kernel",
    "March",
    "NumbaKernel",
    "NumpyKernel",
    "Outcome",
    "Untraceable",
    "array_kernel",
    "backend_for",
    "make_kernel",
    "threads_for",
]


def array_kernel(problem: Problem, scheme: Scheme, every: tuple[Parts, ...]) -> Any:
    """Return the NumPy kernel that fits a problem and a scheme."""
    if len(every) > 1:
        return NumpyPlaneKernel(problem, scheme, every)
    return NumpyKernel(problem, scheme, every[0])


def backend_for(riemann: RiemannSolver, backend: str) -> str:
    """Return the backend that ``$FVKIT_BACKEND`` makes of ``"auto"``; ValueError where it cannot run the Riemann solver."""
    if backend == "auto":
        backend = validation.choice(os.environ.get(VARIABLE, "auto"), f"${VARIABLE}", BACKENDS)
    if not riemann.compilable and backend == "numba":
        raise ValueError(f"{type(riemann).__name__} needs whole arrays: use backend='numpy' or 'auto', got 'numba'")
    return backend


def threads_for(threads: int | str, problem: Problem, scheme: Scheme, backend: str) -> int:
    """Return a number of threads; ``"all"`` means the cores of this process where threads pay, else one."""
    if threads != "all":
        return validation.whole(threads, "threads", at_least=1, hint='or "all"')
    pays = problem.grid.size >= SMALLEST and not scheme.program.registers and scheme.riemann.compilable and available()
    return validation.cores() if pays and backend_for(scheme.riemann, backend) != "numpy" else 1


def make_kernel(backend: str, problem: Problem, scheme: Scheme, every: tuple[Parts, ...], threads: int = 1) -> Kernel:
    """Return the kernel of a backend; ``"auto"`` compiles where numba is installed and the Riemann solver is compilable.

    ``$FVKIT_BACKEND`` overrides ``"auto"``. A ValueError refuses ``"numba"`` or threads where numba is not installed or switched
    off, and threads with too few cells.
    """
    parts = every[0]
    backend = backend_for(parts.riemann, backend)
    advice = f"unset {SWITCH}" if switched_off() else "pip install 'fvkit[fast]'"
    if backend == "numpy" or (backend == "auto" and not (available() and parts.riemann.compilable)):
        if threads > 1:
            raise ValueError(f"`threads` needs the compiled backend, got {threads} threads with NumPy: {advice}")
        return array_kernel(problem, scheme, every)
    if not available():
        raise ValueError(f"`backend` is 'numba', which is {'switched off' if switched_off() else 'not installed'}: {advice}, or "
                         "backend='numpy'")
    if len(every) > 1:
        return NumbaPlaneKernel(problem, scheme, every, threads)
    if threads > 1 and scheme.program.registers:
        raise ValueError(f"`threads` serve WavePropagation, got {threads} threads with {type(scheme).__name__}: use threads=1")
    if threads > 1:
        return ThreadedKernel(problem, scheme, parts, threads)
    return NumbaKernel(problem, scheme, parts)
