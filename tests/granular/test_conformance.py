"""The conformance suites on the granular models, the relaxation solver, drag and friction."""

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.testing import ModelConformance, RiemannConformance, SourceConformance


class Granular(ModelConformance):
    """What the granular models share: little slip, so that speeds are real."""

    def states(self, rng, count):
        return self.model.conserved_from(rng.uniform(0.5, 2.0, count), rng.uniform(0.3, 0.7, count),
                                         rng.uniform(-0.2, 0.2, count), rng.uniform(-0.2, 0.2, count))

    def rest(self, aux):
        return self.model.conserved_from(np.maximum(1.0 - aux["b"], 0.0), 0.6)


class TestTwoPhase(Granular):
    model = gr.TwoPhase(gamma=0.4)


class TestPitmanLe(Granular):
    model = gr.PitmanLe()


class TestReduced(Granular):
    model = gr.Reduced(gamma=0.3)


class TestShallowWater(Granular):
    model = gr.ShallowWater(g=1.62)


class TestTwoLayer(Granular):
    model = gr.TwoLayer(gamma=0.9)

    def rest(self, aux):
        interface, surface = (np.maximum(level - aux["b"], 0.0) for level in (0.6, 1.0))
        return np.array([interface, 0.0 * interface, surface - interface, 0.0 * interface])


class OnTwoPhase(RiemannConformance):
    model, states = gr.TwoPhase(), Granular.states


class TestRelaxation(OnTwoPhase):
    riemann = gr.Relaxation()


class TestRoe(OnTwoPhase):
    riemann = fv.Roe()


class TestHLL(OnTwoPhase):
    riemann = fv.HLL()


class TestRusanov(OnTwoPhase):
    riemann = fv.Rusanov()


class Drag(SourceConformance):
    model, states = gr.TwoPhase(), Granular.states


class TestConstantDrag(Drag):
    source, accuracy = gr.ConstantDrag(5.0), 1e-8


class TestVelocityDrag(Drag):
    source, accuracy = gr.VelocityDrag(1.0, 20.0), 1e-8


class TestPitmanLeDrag(Drag):
    source, accuracy = gr.PitmanLeDrag(0.1, 3.0), 1e-8


class TestManning(SourceConformance):
    """Its law is stepped implicitly, so the step follows the rate at first order."""

    model, states, source, dt, accuracy = gr.ShallowWater(), Granular.states, gr.Manning(0.03), 1e-3, 1e-5


@pytest.mark.parametrize("suite", [TestTwoPhase, TestShallowWater])
def test_a_suite_has_about_twenty_checks(suite):
    assert 18 <= sum(name.startswith("test_") for name in dir(suite)) <= 30
