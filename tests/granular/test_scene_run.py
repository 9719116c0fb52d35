"""`gr.SceneRun` and `fvkit sweep`: parameters by name reach scene, sources, model and scheme."""

from functools import partial

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.cli import FAILED, MISTAKE, SUCCESS, main

RUN = gr.SceneRun("debris-slope", cells=30, backend="numpy")


def two_drags(depth=1.0):
    return gr.Scene((0.0, 1.0), 0.01, lambda x: {"h": depth, "phi": 0.5, "vs": 1.0}, name="two drags",
                    sources=(gr.ConstantDrag(1.0), gr.ConstantDrag(2.0)))


def test_without_parameters_the_scene_runs_as_it_is():
    mine, plain = RUN(), fv.solve(gr.scene("debris-slope").problem(gr.TwoPhase, 30), backend="numpy", nonhyperbolic="ignore")
    np.testing.assert_array_equal(mine.q, plain.q)


def test_parameters_reach_scene_model_sources_and_scheme():
    problem, scheme = RUN.setup({"gamma": 0.3, "t_end": 1.5, "sources.nu": 0.4, "sources.1.v_T": 3.0, "initial.h": 2.0,
                                 "model.dry": 1e-5, "scheme.limiter": "minmod", "scheme.cfl": 0.5, "cells": 20})
    before, _ = RUN.setup({"cells": 20})
    assert (problem.model.gamma, problem.model.dry, problem.t_end, problem.grid.num_cells) == (0.3, 1e-5, 1.5, 20)
    assert problem.sources == (gr.CoulombFriction(0.4), gr.PitmanLeDrag(3.0, 0.0))
    assert scheme == fv.WavePropagation(gr.Relaxation(), fv.Minmod(), cfl=0.5)
    np.testing.assert_allclose(problem.q0, 2.0 * before.q0, rtol=1e-14)
    assert isinstance(RUN.setup({"model": "reduced"})[0].model, gr.Reduced)


def test_arguments_of_the_function_that_makes_a_scene_are_parameters():
    problem, _ = gr.SceneRun("perturbed-rest", cells=40, backend="numpy").setup({"eps": 0.2})
    np.testing.assert_allclose(problem.q0[0].max(), 0.6 * 1.2, rtol=1e-12)
    own, _ = gr.SceneRun(two_drags, cells=10).setup({"depth": 3.0, "sources.1.D": 5.0})
    assert [source.D for source in own.sources] == [1.0, 5.0]
    np.testing.assert_allclose(own.q0[0], 1.5)


@pytest.mark.parametrize(("run", "parameters", "word"), [
    (RUN, {"gama": 0.3}, "did you mean gamma"),
    (RUN, {"sources.mu": 0.3}, "did you mean sources.nu"),
    (RUN, {"scheme.order1": 1}, "scheme.order"),
    (RUN, {"scheme.limiter": "mcc"}, "did you mean mc"),
    (RUN, {"gamma": 1.3}, "`gamma` must be"),
    (gr.SceneRun(two_drags), {"sources.D": 1.0}, "sources.0.D, sources.1.D"),
    (gr.SceneRun("riemann"), {"sources.D": 1.0}, "no sources"),
])
def test_mistakes_in_parameters_are_sentences(run, parameters, word):
    with pytest.raises(ValueError, match=r".") as raised:
        run.setup(parameters)
    assert word in str(raised.value)


@pytest.mark.parametrize(("name", "flow"), [
    ("h", {"h": 0.0, "phi": 0.5}), ("vs", {"h": 1.0, "phi": 0.5}), ("phi", {"h": 1.0, "phi": 0.0}), ("vs_y", {"h": 1.0, "phi": 0.5, "vs_x": 1.0})])
def test_a_factor_on_what_is_zero_everywhere_is_refused(name, flow, tmp_path, capsys):
    corners = ((0.0, 0.0), (1.0, 1.0)) if "_" in name else (0.0, 1.0)
    run = gr.SceneRun(lambda: gr.Scene(corners, 0.01, lambda *places: flow), cells=5, backend="numpy")
    with pytest.raises(ValueError, match=f"`initial.{name}` is a factor on the initial {name} of the scene, which is 0 everywhere"):
        run.setup({f"initial.{name}": 2.0})
    assert not fv.sweep(run, {f"initial.{name}": [1.0, 2.0]}, workers=1).success
    assert run.setup({f"initial.{name}": 0.0})
    interval = "[[0, 0], [1, 1]]" if "_" in name else "[0, 1]"
    initial = ", ".join(f"{key} = {value}" for key, value in flow.items())
    (tmp_path / "dry.toml").write_text(f"interval = {interval}\nt_end = 0.01\ninitial = {{{initial}}}\n")
    (tmp_path / "sweep.toml").write_text(f'scene = "dry.toml"\n[parameters]\n"initial.{name}" = [1.0, 2.0]\n')
    assert main(["sweep", str(tmp_path / "sweep.toml"), "--out", str(tmp_path / "out")]) == MISTAKE
    assert "it changes nothing, leave it out" in capsys.readouterr().err


def test_four_times_the_depth_at_a_quarter_of_the_gravity_is_the_same_flow():
    run = gr.SceneRun("dam-break", cells=40, backend="numpy")
    deep, plain = run(**{"initial.h": 4.0, "g": 0.25 * 9.81}), run()
    np.testing.assert_array_equal(deep.observables()["h"], 4.0 * plain.observables()["h"])


def test_stronger_friction_shortens_the_runout():
    result = fv.sweep(attrs.evolve(RUN, cells=60), {"sources.nu": [0.1, 0.4, 0.8]}, workers=1,
                      keep=lambda solution: {"reach": float(solution.grid.centers @ solution.q[-1, 0])})
    assert (np.diff(result.outputs["reach"]) < 0.0).all()


def write(path, text):
    path.write_text(text, encoding="utf-8")
    return str(path)


FILE = """
scene = "dam-break"
cells = 40
samples = "grid"
outputs = ["h", "max.h", "steps"]
backend = "numpy"

[parameters]
initial.h = [1.0, 4.0]
"gamma" = [0.3, 0.5, 0.7]

[scheme]
riemann = "hll"
order = 1
"""


def test_the_command_runs_a_file_and_goes_on(tmp_path, capsys):
    pytest.importorskip("h5netcdf")
    xarray = pytest.importorskip("xarray")
    arguments = ["sweep", write(tmp_path / "grid.toml", FILE), "--workers", "1", "--out", str(tmp_path / "out")]
    assert main(arguments) == SUCCESS
    shown = capsys.readouterr()
    assert "6 of 6 members finished" in shown.out
    assert shown.err == ""
    with xarray.open_dataset(tmp_path / "out" / "sweep.nc", engine="h5netcdf") as data:
        assert data["h"].dims == ("initial.h", "gamma", "x")
        alone = gr.SceneRun("dam-break", scheme=fv.WavePropagation(fv.HLL(), order=1), cells=40, backend="numpy")
        solution = alone(**{"initial.h": 4.0, "gamma": 0.7})
        np.testing.assert_array_equal(data["h"].sel({"initial.h": 4.0, "gamma": 0.7}), solution.observables()["h"])
    before = (tmp_path / "out" / "members" / "member-000003.npz").stat().st_mtime_ns
    assert main(arguments) == SUCCESS
    assert (tmp_path / "out" / "members" / "member-000003.npz").stat().st_mtime_ns == before


def test_the_command_tells_of_members_that_failed(tmp_path, capsys):
    text = FILE.replace("[0.3, 0.5, 0.7]", "[0.3, 1.5]")
    assert main(["sweep", write(tmp_path / "bad.toml", text), "--workers", "1", "--out", str(tmp_path / "out")]) == FAILED
    assert "error: 2 members, the first is 1: ValueError: `gamma` must be" in capsys.readouterr().out


@pytest.mark.parametrize(("change", "word"), [
    (("scene = ", "scenes = "), "did you mean scene?"),
    (("scene = ", "# "), "the key `scene` is missing"),
    (('"dam-break"', '"dam-brake"'), "did you mean dam-break?"),
    (('"max.h"', '"max.hh"'), "output max.hh"),
    (("order", "oder"), "did you mean order?"),
    (('"grid"', '"random"'), "latin-hypercube, grid, given"),
    (('"gamma"', '"gamna"'), "did you mean gamma?"),
    (("[scheme]", "[scheme"), "is not TOML"),
])
def test_a_mistake_in_a_file_is_one_line(tmp_path, capsys, change, word):
    assert main(["sweep", write(tmp_path / "f.toml", FILE.replace(*change)), "--workers", "1", "--out", str(tmp_path / "o")]) == MISTAKE
    error = capsys.readouterr().err
    assert word in error
    assert error.count("\n") == 1
    assert not (tmp_path / "o").exists()


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning", "ignore::UserWarning",
                            "ignore::pytest.PytestUnraisableExceptionWarning")
def test_the_command_runs_on_a_dask_cluster(tmp_path, capsys):
    distributed = pytest.importorskip("distributed")
    file = write(tmp_path / "grid.toml", FILE)
    with distributed.LocalCluster(n_workers=1, threads_per_worker=2, processes=False, dashboard_address=None,
                                  local_directory=str(tmp_path)) as cluster:
        assert main(["sweep", file, "--dask", cluster.scheduler_address, "--out", str(tmp_path / "out")]) == SUCCESS
    assert "6 of 6 members finished" in capsys.readouterr().out


def zones(nu):
    """A scene whose friction is given along x."""
    return gr.Scene((0.0, 4.0), 0.1, lambda x: {"h": 1.0 + 0.0 * x, "phi": 0.5}, sources=gr.CoulombFriction(nu))


@pytest.mark.parametrize("nu", [[0.1, 0.2, 0.3, 0.4], 0.2])
def test_a_factor_on_a_source_keeps_how_it_varies(nu):
    scene = gr.SceneRun(partial(zones, nu), cells=4).scene_of({"sources.nu.factor": 1.5})
    assert np.array_equal(scene.sources[0].nu, 1.5 * np.array(nu))


@pytest.mark.parametrize(("nu", "name", "words"), [
    ([0.1, 0.2, 0.3, 0.4], "sources.nu", r"`sources.nu` varies over the grid, .* take `sources.nu.factor`"),
    ([0.1, 0.2, 0.3, 0.4], "sources.0.nu", "take `sources.0.nu.factor`"), (lambda x: 0.1 + 0.0 * x, "sources.nu", "give a function"),
    (lambda x: 0.1 + 0.0 * x, "sources.nu.factor", "give a function"), (0.3, "sources.mu.factor", "did you mean sources.nu"),
    (0.3, "sources.nu.factor", r"`sources.nu.factor` must be finite")])
def test_one_number_does_not_replace_zones_in_silence(nu, name, words):
    with pytest.raises(ValueError, match=words):
        gr.SceneRun(partial(zones, nu), cells=4).setup({name: float("nan") if "finite" in words else 1.0})
