"""Long loop bodies are cut into several loops, with the same bits; and the vectors of the loops are the widest there are."""

import os
import platform
import subprocess
import sys

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled import loops
from fvkit.backends.compiled.llvm import block
from fvkit.backends.compiled.pieces import pieces
from fvkit.pointwise.tracing import Graph


def state(model, riemann, sources, cells):
    x = (np.arange(cells) + 0.5) / cells
    bottom = 0.1 * np.cos(2.0 * np.pi * x)
    h = np.where(x < 0.7, 1.0 + 0.4 * np.exp(-100.0 * (x - 0.4) ** 2) - bottom, 0.0)
    problem = fv.Problem(model, fv.Grid(0.0, 1.0, cells), model.conserved_from(h, 0.5 + 0.2 * np.sin(2.0 * np.pi * x), 0.1, -0.1), 1e9,
                         aux={"b": bottom}, boundary=fv.Wall(), sources=sources)
    stepper = fv.Stepper(problem, fv.WavePropagation(riemann), backend="numba", nonhyperbolic="ignore")
    stepper.run(1e9, 12)
    return stepper.q


@pytest.mark.parametrize(("model", "riemann", "sources"), [
    (gr.ShallowWater(), fv.HLL(), (gr.Manning(0.03),)), (gr.ShallowWater(), gr.Relaxation(), (gr.CoulombFriction(0.1),)),
    (gr.TwoPhase(), fv.Roe(), ())], ids=["manning", "coulomb", "two-phase"])
def test_cut_loops_have_the_bits_of_whole_ones(model, riemann, sources, monkeypatch):
    cut = []

    def counted(whole, number):
        cut.append(len(pieces(whole, number)))
        return pieces(whole, number)

    monkeypatch.setattr(loops, "pieces", counted)
    found = [state(model, riemann, sources, cells) for cells in (37, loops.TILE + 1)]
    assert max(cut) > 1, "no loop of this kernel is long enough: the test says nothing"
    monkeypatch.setattr(loops, "pieces", lambda whole, number: [whole])
    for one in found:
        np.testing.assert_array_equal(one, state(model, riemann, sources, one.shape[1]))


def test_each_piece_needs_what_earlier_ones_leave_and_all_outputs_are_left_once():
    graph = Graph()
    x, y = (graph.node("load", f"buf[{k} + j]") for k in range(2))
    first = second = x
    for _ in range(40):
        first, second = np.sqrt(first * y + second), second - x * first
    outputs = [first, second, first > second, x]
    whole = block("block_7", outputs, lambda node: node.operation == "load")
    parts = pieces(whole, 7)
    assert len(parts) > 1
    assert [part.name for part in parts] == [f"block_{7 + k}" for k in range(len(parts))]
    left = {x.index, y.index}
    for part in parts:
        assert {item.index for item in part.inputs} <= left
        left |= {item.index for item in part.outputs if item.operation != ">"}
        assert all(part.fused[key] == whole.fused[key] for key in part.fused)
    for item in outputs:
        assert sum(item.index in [one.index for one in part.outputs] for part in parts) == 1


def test_a_short_body_is_one_loop_and_so_is_one_of_numbers_or_copies():
    graph = Graph()
    x = graph.node("load", "buf[j]")
    for outputs in ([x * x + 1.0], [x], []):
        whole = block("block_0", outputs, lambda node: node.operation == "load")
        assert pieces(whole, 0) == [whole]


SCRIPT = """
import re
import numpy as np
import fvkit as fv
import fvkit_granular as gr
from fvkit.backends import NumbaKernel

model, scheme = gr.ShallowWater(), fv.WavePropagation(fv.Roe())
problem = fv.Problem(model, fv.Grid(0.0, 1.0, 20), np.ones((2, 20)), 1.0, boundary=fv.Wall())
made = NumbaKernel(problem, scheme, scheme.parts(model, ())).module.advance
code = "\\n".join(made.inspect_asm().values())
print(*[len(re.findall(rf"v(?:div|sqrt)pd\\s.*{name}", code)) for name in ("xmm", "ymm", "zmm")])
if OTHER:
    import llvmlite.binding as llvm
    text = "\\n".join(made.inspect_llvm().values())
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    machine = llvm.Target.from_triple("aarch64-unknown-linux-gnu").create_target_machine(cpu="neoverse-v1", opt=3)
    text = re.sub(r'target (triple|datalayout) = .*', '', re.sub(r'"target-(cpu|features)"="[^"]*"', '', text))
    text = re.sub(r'= .*call i8 @llvm.x86.atomic.sub.cc.i64.*', '= add i8 0, 0', text)  # numba counts references so, outside of loops
    found = llvm.parse_assembly(text)
    found.triple, found.data_layout = machine.triple, str(machine.target_data)
    print(len(re.findall(r"fdiv\\s+(?:v\\d+.2d|z\\d+.d)", machine.emit_assembly(found))))
"""


def compiled_for(cpu, folder, other=False):
    """Numbers of quotients and roots in vectors of 128, 256 and 512 bits in a kernel for a processor, which need not be this one."""
    environment = os.environ | {"NUMBA_CPU_NAME": cpu, "NUMBA_CPU_FEATURES": "+sse2", "FVKIT_CACHE": str(folder)}
    done = subprocess.run([sys.executable, "-c", f"OTHER = {other}\n{SCRIPT}"], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.strip().split("\n")
    return [[int(number) for number in line.split()] for line in lines]


on_x86 = pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="cross-compiles for x86-64 processors")


@on_x86
@pytest.mark.parametrize(("cpu", "bits"), [("haswell", 256), ("znver3", 256), ("znver4", 512), ("sapphirerapids", 512)])
def test_loops_use_the_widest_vectors_of_the_processor(cpu, bits, tmp_path):
    (counts,) = compiled_for(cpu, tmp_path)
    widest = {256: 1, 512: 2}[bits]
    assert counts[widest] >= 4
    assert sum(counts) == counts[widest]


@on_x86
def test_a_kernel_compiles_for_other_architectures(tmp_path):
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    try:
        llvm.Target.from_triple("aarch64-unknown-linux-gnu")
    except RuntimeError:
        pytest.skip("this build of llvmlite has no code generator for aarch64")
    assert compiled_for("haswell", tmp_path, other=True)[1][0] >= 4
