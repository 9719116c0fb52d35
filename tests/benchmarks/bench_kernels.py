"""Step times through pytest-benchmark, outside the normal test run: python -m pytest tests/benchmarks/bench_kernels.py"""

import pytest

from fvkit import HLL, Roe, Rusanov
from fvkit_granular import Reduced, Relaxation, ShallowWater, TwoPhase
from fvkit_granular.studies.bench import stepping

STEPS = 100


@pytest.mark.parametrize("backend", ["numba", "numpy"])
@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("riemann", [Relaxation(), Roe(), HLL(), Rusanov()], ids=["relaxation", "roe", "hll", "rusanov"])
@pytest.mark.parametrize("model", [TwoPhase(), Reduced(), ShallowWater()], ids=["two-phase", "reduced", "shallow-water"])
def test_step(benchmark, model, riemann, order, backend):
    if backend == "numba":
        pytest.importorskip("numba")
    run = stepping(model, riemann, order, backend, 1000)
    run(3)
    benchmark.extra_info["cell_steps"] = 1000 * STEPS
    benchmark.pedantic(run, args=(STEPS,), rounds=5)
