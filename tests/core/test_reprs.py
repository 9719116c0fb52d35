"""What a person sees who types a name: one line that says what it is, however much data it holds."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr


@pytest.fixture(scope="module")
def problem():
    return gr.scene("dam-break-phi").problem(gr.TwoPhase, 20)


@pytest.fixture(scope="module")
def things(problem):
    study = fv.sweep(lambda x: {"y": x}, fv.Samples.latin_hypercube({"x": (0.0, 1.0)}, 40), ThreadPoolExecutor(2))
    return {
        "solution": fv.solve(problem, times=np.linspace(0.01, 0.5, 50), backend="numpy"),
        "stepper": fv.Stepper(problem, backend="numpy"), "problem": problem, "scene": gr.scene("riemann"),
        "sweep": study, "samples": study.samples, "named": fv.Samples.grid({"model": ["reduced", "two-phase"], "gamma": [0.3, 0.6]}),
        "riemann": gr.exact.two_phase_riemann((3.0, 0.7, 0.0, 0.0), (2.0, 0.4, 0.0, 0.0)),
        "report": gr.compare(gr.scene("dam-break"), models=[gr.ShallowWater], cells=[10, 20], repeats=1, backend="numpy"),
        "advice": gr.advise(gr.scene("dam-break-phi")),
    }


@pytest.mark.parametrize(("name", "words"), [
    ("solution", ["TwoPhase(slope='mild', g=9.81", "20 cells on [-5, 5] m", "51 outputs", "FINISHED", "numpy"]),
    ("stepper", ["TwoPhase", "WavePropagation", "t = 0 of 0.5 s", "0 steps"]),
    ("problem", ["TwoPhase", "num_cells=20", "t_end=0.5"]),
    ("scene", ["name='riemann'", "interval"]),
    ("sweep", ["40 of 40 members finished", "parameters x", "outputs y"]),
    ("samples", ["40 members", "x 0.0"]),
    ("named", ["4 members of a grid", "model reduced, two-phase", "gamma 0.3 .. 0.6"]),
    ("riemann", ["h 3 phi 0.7", "1-R", "path depths"]),
    ("report", ["scene='dam-break'", "exact", "runs>"]),
])
def test_one_line_says_what_it_is(things, name, words):
    text = repr(things[name])
    assert "\n" not in text
    assert len(text) < 450
    assert [word for word in words if word not in text] == []


def test_advice_prints_itself(things):
    assert str(things["advice"]).startswith("dam-break-phi: ")


@pytest.mark.parametrize(("name", "start"), [("solution", "<table><tr><th>model"), ("report", "<pre>scene dam-break")])
def test_notebooks_show_a_table(things, name, start):
    assert things[name]._repr_html_().startswith(start)
