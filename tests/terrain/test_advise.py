"""Advice for scenes on a terrain: what is exact is measured, and nothing is predicted that was not validated."""

import re

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import main
from tests.terrain.test_command import change, folder  # noqa: F401
from tests.terrain.test_mass_balance import hydrograph
from tests.terrain.test_mountain import rectangle, release, terrain


def scene(**more):
    ground = terrain()
    return gr.Scene(**{"terrain": ground, "release": release(ground), "phi": 0.6, "t_end": 4.0, "sources": ()} | more)


class Idle(fv.Source):
    """A source of one's own that does nothing, and does not say so."""

    def step(self, model, q, aux, dt):
        return q

    def rate(self, model, q, aux):
        return tuple(0.0 * row for row in q)


@pytest.mark.parametrize("sources", ["none", "drag", "curvature", "hydrograph"])
def test_where_shallow_water_is_said_to_suffice_it_is_the_same_flow(sources, tmp_path):
    ground = terrain()
    brought = hydrograph(tmp_path, "in.csv", 30.0, rectangle(15.0, 25.0, 30.0, 40.0), ground)
    given = {"none": (), "drag": gr.ConstantDrag(5.0), "curvature": gr.Curvature(), "hydrograph": brought}[sources]
    found = scene(terrain=ground, release=release(ground), sources=given, phi=0.5)
    advice = gr.advise(found)
    assert (advice.same, advice.model, advice.reasons) == (True, "shallow-water", ())
    maps = []
    for model in (gr.TwoPhase, gr.Reduced, gr.ShallowWater):
        maps.append(gr.HazardMaps())
        fv.solve(found.problem(model), fv.WavePropagation(fv.Rusanov(), order=1), observers=maps[-1])
    for name in ("depth", "speed"):  # with Rusanov's solver the schemes are the same too, but for films that the models damp
        for other in maps[:2]:
            np.testing.assert_allclose(other.maps[name], maps[2].maps[name], rtol=0.0, atol=1e-6 * maps[2].maps[name].max())


@pytest.mark.parametrize(("change", "words"), [
    ({"sources": gr.CoulombFriction(0.2)}, "friction at the bed"), ({"sources": gr.Voellmy(0.1, 500.0)}, "friction at the bed"),
    ({"sources": gr.Rain(-1e-5, phi=0.6)}, "infiltration"), ({"sources": gr.Rain(1e-5)}, "solid fraction varies from 0 to 0.6"),
    ({"sources": gr.Rain(lambda x, y: -1e-5 * x, phi=0.6)}, "infiltration"),
    ({"sources": gr.Rain(1e-5, phi=lambda x, y: 0.3 + 0.0 * x)}, "solid fraction varies from 0.3 to 0.6"),
    ({"sources": gr.Drain(0.1)}, "not known here"), ({"sources": Idle()}, "not known here")])
def test_what_makes_the_models_differ_is_named_and_no_error_is_predicted(change, words):
    advice = gr.advise(scene(**change))
    assert (advice.same, advice.model) == (False, "two-phase")
    assert any(words in reason for reason in advice.reasons)
    text = str(advice)
    assert "whether a cheaper model would do is not known" in text
    assert "no model error is predicted" in text
    assert "no grid error is predicted" in text
    assert not re.search(r"error of [0-9]|error [0-9]", text)


def test_numbers_are_those_of_the_scene():
    ground = terrain(gaps=False)
    found = gr.Scene(terrain=ground, release=release(ground, 2.0), phi=0.6, t_end=4.0, sources=gr.ConstantDrag(3.0))
    advice = gr.advise(found)
    assert advice.phi == (0.6, 0.6)
    rho = 0.6 + found.gamma * 0.4
    assert advice.damping == pytest.approx(4.0 * 3.0 * rho / (0.6 * 0.4), rel=1e-12)
    assert advice.thickness == 2.0
    assert advice.across == pytest.approx(np.sqrt(30.0 * 35.0) / 5.0)
    cells, moved, time = advice.grounds[2]
    blocks = ground.bottom.reshape(9, 2, 12, 2)
    assert cells == 9 * 12
    assert moved == pytest.approx(np.std(blocks - blocks.mean(axis=(1, 3), keepdims=True)))
    assert time == pytest.approx(advice.effort.seconds(0.1) / 8.0)
    assert gr.advise(attrs.evolve(found, sources=())).damping == 0.0


def test_a_scene_without_flow_is_refused():
    ground = terrain()
    nothing = gr.Scene(terrain=ground, t_end=1.0, sources=gr.CoulombFriction(0.2))
    with pytest.raises(ValueError, match="dry everywhere"):
        gr.advise(nothing)


def test_the_command_advises_and_refuses_to_check(folder, capsys):  # noqa: F811
    assert main(["advise", "scene.toml"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("scene: take two phases")
    assert "cells of 5 m" in said
    assert main(["advise", "scene.toml", "--check"]) == 2
    assert "--check runs the models along one axis" in capsys.readouterr().err
    change(folder, "scene.toml", '[friction]\ntype = "coulomb"\nnu = 0.2\n', "")
    assert main(["advise", "scene.toml"]) == 0
    assert "shallow water suffices" in capsys.readouterr().out
