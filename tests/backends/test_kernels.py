"""Generated kernels: only what is used, vectorised, cached by content, safe in bad folders."""

import os
import platform
import re
import stat
import subprocess
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends import NumbaKernel
from fvkit.backends.compiled import disk_cache
from fvkit.backends.compiled.generator import generate
from fvkit.backends.compiled.numba_kernel import _loaded
from fvkit.backends.plan import plan


def text(scheme: fv.WavePropagation, model: fv.Model | None = None, sources: tuple[fv.Source, ...] = (), b: float = 0.1,
         boundary: fv.BoundaryCondition | None = None) -> str:
    chosen = model or gr.TwoPhase()
    start = np.ones((len(chosen.conserved), 20))
    problem = fv.Problem(chosen, fv.Grid(0.0, 1.0, 20), start, 1.0, dict.fromkeys(chosen.aux, b),
                         boundary or fv.Outflow(), sources)
    parts = scheme.parts(problem.model, problem.sources)
    varies = [bool(row.any()) for row in problem.aux_averages.values()]
    return generate(problem, scheme, parts, plan(scheme.stages(parts)), None, varies).text


def test_only_what_a_scheme_uses_is_generated():
    full = text(fv.WavePropagation(fv.Roe()))
    no_fix = text(fv.WavePropagation(fv.Roe(), entropy_fix=False))
    no_cross = text(fv.WavePropagation(fv.Roe(), entropy_fix=False, cross_term=False))
    no_limiter = text(fv.WavePropagation(fv.Roe(), fv.NoLimiter(), entropy_fix=False, cross_term=False))
    first = text(fv.WavePropagation(fv.Roe(), order=1, entropy_fix=False))
    lengths = [len(item) for item in (full, no_fix, no_cross, no_limiter, first)]
    assert lengths == sorted(lengths, reverse=True)
    assert len(set(lengths)) == 5
    assert "hit1 = 0" in full
    assert "hit0 = 0" in no_fix
    assert "hit1" not in no_fix
    assert " = exp " not in full
    assert " = exp " in text(fv.WavePropagation(fv.Roe()), sources=(gr.ConstantDrag(1.0),))
    assert "aux[" in full
    assert "aux[" not in text(fv.WavePropagation(fv.HLL()), fv.Burgers())


def test_a_flat_bottom_costs_nothing():
    scheme = fv.WavePropagation(gr.Relaxation())
    flat, bumpy = text(scheme, gr.ShallowWater(), b=0.0), text(scheme, gr.ShallowWater())
    assert len(flat) < 0.9 * len(bumpy)
    assert "aux[" not in flat
    assert flat.count(" = / ") < bumpy.count(" = / ")


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64") or not Path("/proc/cpuinfo").exists()
                    or "avx2" not in Path("/proc/cpuinfo").read_text(), reason="needs a processor with AVX2 or AVX-512")
@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.TwoPhase()], ids=["shallow", "two-phase"])
def test_the_loops_are_vectorised(model, tmp_path, monkeypatch):
    monkeypatch.setenv("FVKIT_CACHE", str(tmp_path))  # a kernel from the cache has no assembly
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, 20), np.ones((len(model.conserved), 20)), 1.0, boundary=fv.Wall())
    scheme = fv.WavePropagation(fv.Roe(), entropy_fix=False)
    content = text(scheme, model, b=0.0, boundary=fv.Wall())
    module = NumbaKernel(problem, scheme, scheme.parts(model, ())).module
    code = "\n".join(module.tile.inspect_asm().values()) or "\n".join(
        str(item) for item in module.tile.inspect_asm(module.tile.signatures[0]))
    if not code.strip():
        pytest.skip("assembly is not kept with a kernel from the cache")
    wide = len(re.findall(r"vdivpd\s.*[yz]mm", code))
    uniform = 2  # of the threshold of dry cells and of gravity, once per tile
    seldom = 3 if model.defines("hyperbolic_discriminant") else 0  # the loop that counts lost faces takes them one by one
    guesses = len(re.findall(r"vpsubq\s.*[yz]mm", code))  # a quotient made of products has two of them, and nothing else here has
    assert wide + guesses // 2 >= content.count(" = / ") - uniform - seldom >= 4
    assert guesses >= 2 * content.count("by products")
    assert len(re.findall(r"vsqrtpd\s.*[yz]mm", code)) >= content.count(" = sqrt ") >= 2


def test_new_parameter_values_and_new_data_never_recompile():
    def run(g: float, drag: float, cells: int, cfl: float) -> None:
        problem = fv.Problem(gr.TwoPhase(g=g), fv.Grid(0.0, 1.0, cells), np.ones((4, cells)), 0.01, sources=gr.ConstantDrag(drag),
                             boundary=(fv.Wall(), fv.Inflow(np.ones(4) * g)))
        fv.solve(problem, fv.WavePropagation(fv.HLL(), cfl=cfl), backend="numba")

    run(9.81, 1.0, 30, 0.9)
    before = len(_loaded)
    run(1.62, 1e6, 57, 0.5)
    assert len(_loaded) == before


@pytest.mark.parametrize("schemes", [[fv.WavePropagation(fv.HLL(), order=1), fv.WavePropagation(fv.Rusanov())],
                                     [fv.MethodOfLines(fv.HLL()), fv.MethodOfLines(fv.HLL(), fv.WENO5(), fv.ARK4())]],
                         ids=["waves", "lines"])
def test_kernels_with_whatever_ghost_cells_share_one_compiled_time_loop(schemes):
    names = []
    for model, scheme in zip((fv.Burgers(), gr.ShallowWater()), schemes, strict=True):
        q = np.ones((len(model.conserved), 20))
        kernel = fv.Stepper(fv.Problem(model, fv.Grid(0.0, 1.0, 20), q, 1.0, boundary=fv.Outflow()), scheme, backend="numba")._kernel
        names.append((kernel.loop.__name__, kernel.module.__name__))
    assert names[0][0] == names[1][0]
    assert names[0][1] != names[1][1]


SCRIPT = """
import sys, time
import numpy as np
import attrs
import fvkit as fv

def square(u):
    return FACTOR * u * u

@attrs.frozen
class Mine(fv.Model):
    conserved = ("u",)
    def flux(self, q):
        return (square(q[0]),)
    def wave_speeds(self, q):
        return 2 * FACTOR * q[0], 2 * FACTOR * q[0]

problem = fv.Problem(Mine(), fv.Grid(0.0, 1.0, 50), lambda x: 1.0 + x[None], 0.1)
solution = fv.solve(problem, fv.WavePropagation(fv.HLL()), backend="numba")
print(repr(float(solution.q[-1].sum())), solution.stats.compile_seconds)
"""


def run_script(folder: Path, factor: str, name: str = "script.py", wait: bool = True, **variables: str):
    file = folder / name
    file.write_text(SCRIPT.replace("FACTOR", factor))
    environment = os.environ | {"FVKIT_CACHE": str(folder / "cache")} | variables
    process = subprocess.Popen([sys.executable, "-W", "always", str(file)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
    if not wait:
        return process
    out, err = process.communicate(timeout=120)
    assert process.returncode == 0, err
    total, seconds = out.split()
    return float(total), float(seconds), err


def kernels(folder: Path) -> list[str]:
    return sorted(path.name for path in (folder / "cache").glob("kernel_*.py"))


def test_a_second_process_starts_warm_and_an_edit_of_a_helper_recompiles(tmp_path):
    first, cold, _ = run_script(tmp_path, "0.5")
    second, warm, _ = run_script(tmp_path, "0.5", name="moved.py")
    assert second == first
    assert warm < 0.6 * cold
    assert len(kernels(tmp_path)) == 1
    edited, _, _ = run_script(tmp_path, "0.25")
    assert edited != first
    assert len(kernels(tmp_path)) == 2
    restored, again, _ = run_script(tmp_path, "0.5")
    assert restored == first
    assert again < 0.6 * cold


def test_processes_that_start_together_share_the_cache_safely(tmp_path):
    together = [run_script(tmp_path, "0.5", name=f"s{k}.py", wait=False) for k in range(3)]
    results = [process.communicate(timeout=180) for process in together]
    assert [process.returncode for process in together] == [0, 0, 0], results
    assert len({out.split()[0] for out, _ in results}) == 1
    assert len(kernels(tmp_path)) == 1


@pytest.mark.skipif(sys.platform == "win32", reason="folders cannot be made read-only there")
def test_a_folder_that_cannot_be_written_gives_a_warning_and_a_result(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("not a folder")
    total, _, err = run_script(tmp_path, "0.5", FVKIT_CACHE=str(blocked / "below"))
    assert np.isfinite(total)
    assert "cannot be written" in err
    assert "FVKIT_CACHE" in err


def test_the_cache_can_be_listed_and_cleared(tmp_path, monkeypatch):
    monkeypatch.setenv("FVKIT_CACHE", str(tmp_path / "other"))
    assert disk_cache.contents().kernels == 0
    path, lasting = disk_cache.place("kernel_test", "x = 1\n")
    assert lasting
    assert stat.S_ISREG(path.stat().st_mode)
    disk_cache.place("loop_test", "x = 1\n")
    assert disk_cache.contents().kernels == 1, "the time loop that all kernels share is none"
    disk_cache.place("mine", "")
    assert disk_cache.clear().kernels == 1
    assert disk_cache.contents() == disk_cache.Contents(tmp_path / "other", 0, 0)
    assert [path.name for path in (tmp_path / "other").iterdir()] == ["mine.py"], "what is not a kernel's stays"


@pytest.mark.parametrize("package", ["fvkit", "fvkit_granular"])
def test_importing_imports_neither_numba_nor_matplotlib_nor_scipy(package):
    code = f"import sys, {package}; print([name for name in ('numba', 'matplotlib', 'scipy') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def compiled_alone(function):
    """Compile a function of one value by the emitter, to run on an array."""
    import numba

    from fvkit.backends.compiled.llvm import block
    from fvkit.pointwise.tracing import Graph

    made = block("made", [function(Graph().node("load", "x"))], lambda node: node.operation == "load").compiled()

    @numba.njit(error_model="numpy")
    def every(x, y):
        for j in range(x.size):
            y[j] = made(x[j])[0]

    def run(x):
        y = np.empty_like(x)
        every(x, y)
        return y

    return run


def test_exp_of_the_compiled_backend_is_exact_to_a_few_units():
    x = np.concatenate([np.linspace(-707.0, 709.0, 200_001), [0.0, -1e-300, np.inf, -np.inf, np.nan, 800.0, -800.0]])
    y = compiled_alone(np.exp)(x)
    assert np.abs(y[:200_001] / np.exp(x[:200_001]) - 1.0).max() < 5e-16
    assert y[200_001:].tolist()[:4] == [1.0, 1.0, np.inf, 0.0]
    assert np.isnan(y[-3])
    assert y[-2:].tolist() == [np.inf, 0.0]


def test_log_of_the_compiled_backend_is_exact_to_a_few_units():
    x = np.concatenate([np.geomspace(1e-320, 1.7e308, 200_001), np.linspace(0.6, 1.6, 100_001)])
    y, wanted = compiled_alone(np.log)(x), np.log(x)
    assert np.abs(y - wanted).max() < 1e-12
    assert (np.abs(y - wanted) <= 5e-16 * np.abs(wanted)).all()
    assert compiled_alone(np.log)(np.array([1.0, np.inf, 0.0, -0.0])).tolist() == [0.0, np.inf, -np.inf, -np.inf]
    assert np.isnan(compiled_alone(np.log)(np.array([-1.0, -np.inf, np.nan]))).all()


def test_expm1_of_the_compiled_backend_is_exact_to_a_few_units():
    x = np.concatenate([np.linspace(-700.0, 700.0, 100_000), np.linspace(-1.0, 1.0, 100_000), np.geomspace(1e-300, 1.0, 1000)])
    y, wanted = compiled_alone(np.expm1)(x), np.expm1(x)
    assert (np.abs(y - wanted) <= 2e-15 * np.abs(wanted)).all()
    assert compiled_alone(np.expm1)(np.array([0.0, np.inf, -np.inf])).tolist() == [0.0, np.inf, -1.0]
    assert np.isnan(compiled_alone(np.expm1)(np.array([np.nan]))).all()


def test_cube_roots_of_the_compiled_backend_are_exact_to_a_unit_also_where_there_is_little_to_take_a_root_of():
    x = np.concatenate([np.linspace(-700.0, 700.0, 100_001), np.geomspace(5e-324, 1e308, 100_000), 8.0 ** np.arange(-300.0, 300.0)])
    y, wanted = compiled_alone(np.cbrt)(x), np.cbrt(x)
    assert (np.abs(y - wanted) <= 2.0 * np.spacing(np.abs(wanted))).all()  # one of ours and one of the library's
    special = np.array([0.0, -0.0, np.inf, -np.inf, -27.0, np.nan])
    np.testing.assert_array_equal(compiled_alone(np.cbrt)(special), np.cbrt(special))
    assert np.signbit(compiled_alone(np.cbrt)(special[:2])).tolist() == [False, True]


def test_the_cache_command_shows_and_clears(tmp_path, monkeypatch, capsys):
    from fvkit.cli import main

    monkeypatch.setenv("FVKIT_CACHE", str(tmp_path))
    disk_cache.place("kernel_test", "x = 1\n")
    assert main(["cache"]) == 0
    assert f"{tmp_path}: 1 kernels" in capsys.readouterr().out
    assert main(["cache", "--clear"]) == 0
    assert "removed" in capsys.readouterr().out
    assert not list(tmp_path.glob("*.py"))


def test_what_two_faces_ask_of_a_cell_is_computed_once_per_cell():
    @attrs.frozen
    class Waves(fv.Model):
        conserved = ("u",)

        def flux(self, q):
            return (q[0] * np.sqrt(q[0]),)

        def wave_speeds(self, q):
            return 1.5 * np.sqrt(q[0]), 1.5 * np.sqrt(q[0])

    generated = text(fv.WavePropagation(fv.HLL(), order=1), Waves())
    assert generated.count(" = sqrt ") == 1
    assert generated.count("for j in range(nt + 1)") == 1, "the loop over faces reads the roots of both cells"


def test_a_long_run_needs_two_copies_of_the_state_and_a_megabyte():
    import tracemalloc

    scheme = fv.WavePropagation(fv.HLL(), order=1)
    for cells in (1000, 1_000_000):
        q = np.ones((4, cells))
        problem = fv.Problem(gr.TwoPhase(), fv.Grid(0.0, 1.0, cells), q, 1.0, aux={"b": 1.0})
        tracemalloc.start()
        fv.Stepper(problem, scheme, backend="numba").run(1.0, 2)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peak <= 2 * q.nbytes + 1_000_000


def test_constants_that_tracing_finds_are_plain_numbers():
    """On a flat bottom whole expressions of a stage are constants, some of them NumPy's own scalars."""
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 20), np.ones((2, 20)), 0.1)
    solution = fv.solve(problem, fv.MethodOfLines(fv.HLL()), backend="numba")
    np.testing.assert_allclose(solution.q[-1], 1.0, rtol=1e-13)
