"""Single cases of bad input: {name: (call, type of the error, words of the message)}."""

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.configuration import build
from fvkit_granular import exact, shapes
from tests.robust.cases_calls import GRID, PROBLEM, SCENE, bump, flow


def burgers(initial, **options):
    return fv.Problem(fv.Burgers(), GRID, initial, 1.0, **options)


def deep(depth):
    data = 1.0
    for _ in range(depth):
        data = [data]
    return data


def scene(initial, **options):
    return gr.Scene((0.0, 1.0), 0.1, initial, **options).problem(gr.TwoPhase, 5)


def result(value):
    """A function of x that returns the same at all x."""
    return lambda x: value


SINGLE = {
    # sizes
    "grid: more cells than floats": (lambda: fv.Grid(0.0, 1.0, 2**52 + 1), ValueError, ["`num_cells`", str(2**52 + 1), "fewer cells"]),
    "grid: an interval as wide as floats": (lambda: fv.Grid(-1e308, 1e308, 5), ValueError, ["`upper`", "`lower`", "1e+308"]),
    "grid: an interval of one rounding": (lambda: fv.Grid(1e16, 1e16 + 4, 100), ValueError, ["`num_cells`", "100"]),
    "grid: a subnormal interval": (lambda: fv.Grid(0.0, 5e-324, 2), ValueError, ["`num_cells`", "2"]),
    "problem: more than the memory": (lambda: fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 10**13), lambda x: x[None], 1.0), ValueError,
                                      ["`num_cells`", str(10**13), "GB", "this machine has"]),
    "scene: more than the memory": (lambda: SCENE.problem(gr.TwoPhase, 10**13), ValueError, ["`num_cells`", str(10**13), "GB"]),
    "scene run: more than the memory": (lambda: gr.SceneRun("riemann", cells=10**13)(), ValueError, ["`num_cells`", str(10**13)]),
    "members: more than the memory": (lambda: fv.Samples.latin_hypercube({"D": (0.0, 1.0)}, 10**14), ValueError, ["`members`", str(10**14)]),
    # what functions return
    "initial(x): a text": (lambda: burgers(result("sine")), TypeError, ["`initial(x)`", "'sine'"]),
    "initial(x): nothing": (lambda: burgers(result(None)), TypeError, ["`initial(x)`", "None"]),
    "initial(x): complex": (lambda: burgers(lambda x: 1j * x[None]), TypeError, ["`initial(x)`", "array of numbers", "0.00781835j"]),
    "initial(x): nan": (lambda: burgers(lambda x: np.nan * x[None]), ValueError, ["`initial`", "finite", "nan"]),
    "initial(x): inf": (lambda: burgers(lambda x: np.full_like(x, np.inf)[None]), ValueError, ["`initial`", "finite", "inf"]),
    "initial(x): masked": (lambda: burgers(lambda x: np.ma.masked_greater(x, 0.5)[None]), TypeError, ["`initial(x)`", "masked"]),
    "initial(x): flags": (lambda: burgers(lambda x: (x > 0.5)[None]), TypeError, ["`initial(x)`", "array of numbers"]),
    "initial(x): texts of digits": (lambda: burgers(lambda x: x.astype(str)[None]), TypeError, ["`initial(x)`", "array of numbers"]),
    "initial(x): a state for one point": (lambda: burgers(result(np.ones((1, 1)))), ValueError, ["`initial(x)`", "(1, 30)", "(1, 1)"]),
    "initial: masked": (lambda: burgers(np.ma.masked_equal(np.arange(6.0)[None], 3.0)), TypeError, ["`initial`", "masked"]),
    "initial: flags": (lambda: burgers(np.ones((1, 6), dtype=bool)), TypeError, ["`initial`", "array of numbers"]),
    "background(x): a text": (lambda: burgers(np.ones((1, 6)), background=result("rest")), TypeError, ["`background(x)`", "'rest'"]),
    "background(x): nan": (lambda: burgers(np.ones((1, 6)), background=lambda x: np.nan * x[None]), ValueError, ["`background`", "nan"]),
    "scene: a flow that is a number": (lambda: scene(result(3.0)), TypeError, ["`initial(x)`", "3.0", "mapping"]),
    "scene: a flow without phi": (lambda: scene(result({"h": 1.0})), ValueError, ["`initial(x)`", "phi", "got h"]),
    "scene: a flow with more": (lambda: scene(result({"h": 1.0, "phi": 0.5, "v": 1.0})), ValueError, ["`initial(x)`", "got h, phi, v"]),
    "scene: an empty flow": (lambda: scene(result({})), ValueError, ["`initial(x)`", "got nothing"]),
    "scene: a depth of text": (lambda: scene(result({"h": "deep", "phi": 0.5})), TypeError, ["`h`", "'deep'"]),
    "scene: a flag for phi": (lambda: scene(result({"h": 1.0, "phi": True})), TypeError, ["`phi`", "True"]),
    "scene: a depth of None": (lambda: scene(result({"h": None, "phi": 0.5})), TypeError, ["`h`", "None"]),
    "scene: a depth of another shape": (lambda: scene(result({"h": np.ones(3), "phi": 0.5})), ValueError, ["`h`", "(25,)", "(3,)"]),
    "scene: a negative depth": (lambda: scene(result({"h": -1.0, "phi": 0.5})), ValueError, ["`h`", ">= 0", "-1.0"]),
    "scene: phi above 1": (lambda: scene(result({"h": 1.0, "phi": 1.5})), ValueError, ["`phi`", "[0, 1]", "1.5"]),
    "scene: nan in vs": (lambda: scene(result({"h": 1.0, "phi": 0.5, "vs": np.nan})), ValueError, ["`vs`", "finite", "nan"]),
    "scene: inf in vf": (lambda: scene(result({"h": 1.0, "phi": 0.5, "vf": np.inf})), ValueError, ["`vf`", "finite", "inf"]),
    "scene: a complex velocity": (lambda: scene(result({"h": 1.0, "phi": 0.5, "vf": 1j})), TypeError, ["`vf`", "1j"]),
    "bottom(x): nan": (lambda: scene(flow, bottom=lambda x: np.nan * x), ValueError, ["aux['b']", "finite", "nan"]),
    "bottom(x): a text": (lambda: scene(flow, bottom=result("hill")), TypeError, ["aux['b'](x)", "'hill'"]),
    "bottom(x): two rows": (lambda: scene(flow, bottom=lambda x: np.ones((2, x.size))), ValueError, ["aux['b'](x)", "(25,)", "(2, 25)"]),
    "bottom: too many cells": (lambda: scene(flow, bottom=np.ones(7)), ValueError, ["aux['b']", "(5,)", "(7,)"]),
    "bottom: a text": (lambda: scene(flow, bottom="hill"), TypeError, ["aux['b']", "'hill'"]),
    "bottom: a flag": (lambda: scene(flow, bottom=True), TypeError, ["aux['b']", "True"]),
    "inflow(t): nan": (lambda: burgers(np.ones((1, 6)), boundary=fv.Inflow(lambda t: [np.nan])), ValueError, ["Inflow state at t = 0", "nan"]),
    "inflow(t): a text": (lambda: burgers(np.ones((1, 6)), boundary=fv.Inflow(result("high"))), TypeError, ["Inflow state at t = 0", "'high'"]),
    "inflow(t): nothing": (lambda: burgers(np.ones((1, 6)), boundary=fv.Inflow(result(None))), TypeError, ["Inflow state at t = 0", "None"]),
    "inflow: empty": (lambda: fv.Inflow([]), ValueError, ["`state`", "not empty", "[]"]),
    "steady: bottom(x) of another shape": (lambda: gr.steady(result(np.ones(3)), dict(h=1.0, phi=0.5), (0.0, 1.0)), ValueError, ["`bottom(x)`", "(3,)"]),
    "steady: bottom(x) a text": (lambda: gr.steady(result("hill"), dict(h=1.0, phi=0.5), (0.0, 1.0)), TypeError, ["`bottom(x)`", "'hill'"]),
    "steady: bottom(x) nan": (lambda: gr.steady(lambda x: x * np.nan, dict(h=1.0, phi=0.5), (0.0, 1.0)), ValueError, ["`bottom`", "nan"]),
    "steady: an inflow without phi": (lambda: gr.steady(bump, dict(h=1.0), (0.0, 1.0)), ValueError, ["`inflow`", "phi", "got h"]),
    "steady: phi of 1": (lambda: gr.steady(bump, dict(h=1.0, phi=1.0), (0.0, 1.0)), ValueError, ["`phi`", "< 1", "1.0"]),
    "steady: at outside": (lambda: gr.steady(bump, dict(h=1.0, phi=0.5), (0.0, 1.0), 2.0), ValueError, ["`at`", "<= 1", "2.0"]),
    "simple wave: h0(x) a text": (lambda: exact.simple_wave(result("hump")), TypeError, ["`h0(x)`", "'hump'"]),
    "simple wave: h0(x) dry": (lambda: exact.simple_wave(lambda x: 0.0 * x), ValueError, ["`h0`", "above 0"]),
    "simple wave: h0(x) one number": (lambda: exact.simple_wave(result(1.0)), ValueError, ["`h0`", "shape"]),
    "periodic flow: an empty state": (lambda: exact.periodic_flow(result({}), bump, 0.1), ValueError, ["`initial(x)`", "got nothing"]),
    "periodic flow: a text": (lambda: exact.periodic_flow(result("rest"), bump, 0.1), TypeError, ["`initial(x)`", "'rest'"]),
    "periodic flow: bottom(x) a text": (lambda: exact.periodic_flow(flow, result("hill"), 0.1), TypeError, ["`bottom(x)`", "'hill'"]),
    "convergence: no problem": (lambda: fv.convergence(result(None), cells=(5, 10, 20)), TypeError, ["problem_of(n)", "None"]),
    "convergence: other cells": (lambda: fv.convergence(result(PROBLEM), cells=(5, 10, 20)), ValueError, ["problem_of(5)", "5 cells", "got 6"]),
    "convergence: descending": (lambda: fv.convergence(result(PROBLEM), cells=(20, 10, 5)), ValueError, ["`cells`", "ascending", "(20, 10, 5)"]),
    "convergence: one": (lambda: fv.convergence(result(PROBLEM), cells=(20,)), ValueError, ["`cells`", "(20,)"]),
    "convergence: a count of text": (lambda: fv.convergence(result(PROBLEM), cells=("5", 10, 20)), TypeError, ["`cells`", "'5'"]),
    # pairs and combinations
    "solve: dt and dt_max": (lambda: fv.solve(PROBLEM, step=fv.Step(dt=0.1, dt_max=0.2)), ValueError, ["`dt`", "`dt_max`"]),
    "solve: checkpoint and stream": (lambda: fv.solve(PROBLEM, checkpoint=fv.Checkpoint("a.npz"), record=fv.Stream("a.nc")), ValueError, ["`checkpoint`", "`record`"]),
    "solve: stream of another ending": (lambda: fv.solve(PROBLEM, backend="numpy", record=fv.Stream("a.npz")), ValueError, ["`path`", ".nc", "a.npz"]),
    "solve: times beyond the end": (lambda: fv.solve(PROBLEM, times=[2.0]), ValueError, ["`times`", "[0, 1]", "2.0"]),
    "gauge: outside": (lambda: fv.solve(PROBLEM, backend="numpy", observers=fv.Gauge(2.0)), ValueError, ["`x`", "[0, 1]", "2"]),
    "front: no depth": (lambda: fv.solve(PROBLEM, backend="numpy", observers=gr.Front(0.1)), ValueError, ["Front", "Burgers", "depth"]),
    "checkpoint: another ending": (lambda: fv.Checkpoint("run.nc"), ValueError, ["`path`", ".npz", "run.nc"]),
    "checkpoint: no folder": (lambda: fv.Checkpoint("nowhere/run.npz"), ValueError, ["`path`", "nowhere/run.npz", "folder"]),
    "hydrograph: descending": (lambda: gr.Hydrograph([1.0, 0.0], [1.0, 1.0], 0.5), ValueError, ["`times`", "ascend", "[1.0, 0.0]"]),
    "hydrograph: lengths": (lambda: gr.Hydrograph([0.0, 1.0], [1.0, 1.0, 1.0], 0.5), ValueError, ["`discharge`", "2 times", "got 3"]),
    "hydrograph: negative": (lambda: gr.Hydrograph([0.0], [-1.0], 0.5), ValueError, ["`discharge`", ">= 0", "-1"]),
    "hydrograph: phi": (lambda: gr.Hydrograph([0.0], [1.0], 1.5), ValueError, ["`phi`", "[0, 1]", "1.5"]),
    "hydrograph: depth": (lambda: gr.Hydrograph([0.0, 1.0], [1.0, 1.0], 0.5, [0.5, 0.0]), ValueError, ["`depth`", "> 0", "[0.5, 0.0]"]),
    "stage: lengths": (lambda: gr.FixedLevel([1.0, 2.0]), ValueError, ["`level`", "1 times", "got 2"]),
    "inflow: slope": (lambda: fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 5), np.ones((1, 5)), 1.0, boundary=fv.Inflow([1.0], slope=0.1)),
                      ValueError, ["`slope` of Inflow", "`beyond`", "Burgers has none"]),
    "hydrograph: empty": (lambda: gr.Hydrograph([], [], []), ValueError, ["`times`", "not empty", "[]"]),
    "flow of shapes: neither": (lambda: gr.ShapedFlow(phi=0.5), ValueError, ["`h`", "`surface`"]),
    "flow of shapes: both": (lambda: gr.ShapedFlow(1.0, surface=1.0, phi=0.5), ValueError, ["`h`", "`surface`"]),
    "flow of shapes: no phi": (lambda: gr.ShapedFlow(1.0), ValueError, ["`phi`"]),
    "drag: missing": (lambda: gr.ConstantDrag(), TypeError, ["D"]),
    "problem: missing": (lambda: fv.Problem(fv.Burgers()), TypeError, ["grid", "initial", "t_end"]),
    "shapes: steps of lengths": (lambda: shapes.Steps([0.0], [1.0]), ValueError, ["`values`", "`at`", "1 and 1"]),
    "shapes: steps that descend": (lambda: shapes.Steps([1.0, 0.0], [1.0, 2.0, 3.0]), ValueError, ["`at`", "ascend", "1, 0"]),
    "shapes: points that descend": (lambda: shapes.PiecewiseLinear([(1.0, 0.0), (0.0, 1.0)]), ValueError, ["`points`", "ascend", "1, 0"]),
    "shapes: points of three": (lambda: shapes.PiecewiseLinear([(1.0, 0.0, 2.0)]), ValueError, ["`points`", "(1, 2)", "(1, 3)"]),
    "shapes: a sum with a text": (lambda: shapes.Block(0.0, 1.0, 1.0) + "hill", TypeError, ["`value`", "'hill'"]),
    # parameters of sweeps
    "samples: no list": (lambda: fv.Samples.grid({"D": {}}), TypeError, ["`D`", "{}"]),
    "samples: empty": (lambda: fv.Samples.grid({"D": []}), TypeError, ["`D`", "[]"]),
    "samples: nan": (lambda: fv.Samples.given({"D": [1.0, np.nan]}), ValueError, ["`D`", "nan"]),
    "samples: lengths": (lambda: fv.Samples.given({"D": [1.0], "g": [1.0, 2.0]}), ValueError, ["1 of D", "2 of g", "Samples.grid"]),
    "samples: a name that is none": (lambda: fv.Samples.given({5: [1.0]}), TypeError, ["`values`", "5"]),
    "samples: complex": (lambda: fv.Samples.given({"D": [1j]}), TypeError, ["`D`", "1j"]),
    "samples: mixed": (lambda: fv.Samples.given({"D": [None, 1.0]}), TypeError, ["`D`", "None"]),
    "samples: log of 0": (lambda: fv.Samples.latin_hypercube({"D": (0.0, 1.0, "log")}, 3), ValueError, ["D[0]", "> 0", "0.0"]),
    "samples: another scale": (lambda: fv.Samples.latin_hypercube({"D": (1.0, 2.0, "lin")}, 3), ValueError, ["`D`", "'log'", "'lin'"]),
    "samples: ragged": (lambda: fv.Samples.given({"D": [[1.0], [1.0, 2.0]]}), TypeError, ["`D`", "[[1.0], [1.0, 2.0]]"]),
    "scene run: unknown parameter": (lambda: gr.SceneRun("riemann").setup({"gama": 0.5}), ValueError, ["gama", "did you mean gamma?"]),
    "scene run: a parameter of text": (lambda: gr.SceneRun("riemann").setup({"gamma": "0.5"}), TypeError, ["`gamma`", "'0.5'"]),
    "scene run: a factor of text": (lambda: gr.SceneRun("riemann").setup({"initial.h": "2"}), TypeError, ["`initial.h`", "'2'"]),
    "scene run: a factor that is nan": (lambda: gr.SceneRun("riemann").setup({"initial.h": np.nan}), ValueError, ["`initial.h`", "nan"]),
    "scene run: cells of text": (lambda: gr.SceneRun("riemann").setup({"cells": "50"}), TypeError, ["`num_cells`", "'50'"]),
    "scene run: unknown model": (lambda: gr.SceneRun("riemann").setup({"model": "two-phases"}), ValueError, ["`model`", "two-phase"]),
    # data of configurations
    "build: a class that is not loaded": (lambda: build({"class": "system", "from": "os"}), ValueError, ["data", "system", "os", "not loaded"]),
    "build: a function": (lambda: build({"callable": "os.system"}), ValueError, ["data", "os.system", "no file can hold"]),
    "build: a field too many": (lambda: build({"class": "Roe", "from": "fvkit.schemes.riemann", "colour": 1}), ValueError, ["data", "Roe", "colour"]),
    "build: a list of lists of other lengths": (lambda: build({"array": [[1.0], [1.0, 2.0]]}), ValueError, ["data", "array"]),
    "build: nested too deeply": (lambda: build(deep(100_000)), ValueError, ["data", "nested too deeply"]),
    "build: another kind": (lambda: build({"class": "Roe", "from": "fvkit.schemes.riemann"}, fv.Grid), ValueError, ["data", "Grid", "Roe"]),
    "build: keys that are no names": (lambda: build({"class": "Roe", "from": "fvkit.schemes.riemann", 5: 1}), ValueError, ["data", "Roe"]),
    "build: a grid of text": (lambda: build({"class": "Grid", "from": "fvkit.problem.grid", "lower": "0", "upper": 1.0, "num_cells": 2}), ValueError,
                              ["data", "`lower`", "'0'"]),
    # readers
    "load: nothing there": (lambda: fv.load("nowhere.npz"), FileNotFoundError, ["nowhere.npz"]),
    "load: a folder": (lambda: fv.load("."), OSError, ["."]),
    "load: a path below a file": (lambda: fv.load("/etc/passwd/run.npz"), OSError, ["/etc/passwd/run.npz"]),
    "resume: nothing there": (lambda: fv.resume("nowhere.npz"), FileNotFoundError, ["nowhere.npz"]),
    "scene file: nothing there": (lambda: gr.load_scene("nowhere.toml"), FileNotFoundError, ["nowhere.toml"]),
    "scene file: a folder": (lambda: gr.load_scene("."), OSError, ["."]),
}
