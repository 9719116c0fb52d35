"""Solutions on grids with two axes in files: bit-exact round trips, and what other tools read."""

import subprocess
import sys
from importlib.util import find_spec

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.files import Unreadable
from fvkit.output.configuration import build, describe
from tests.cases import solve
from tests.plane.scenes import pool, same_bits

HAS_IO = all(find_spec(name) for name in ("xarray", "h5netcdf", "h5py"))
NEEDS_IO = pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
ENDINGS = (".npz", pytest.param(".nc", marks=NEEDS_IO))


@pytest.fixture(scope="module")
def solution():
    return solve(pool(), times=[0.1, 0.2, 0.4])


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("model", [gr.TwoPhase, gr.ShallowWater])
def test_a_solution_comes_back_bit_for_bit(model, ending, tmp_path):
    kept = solve(pool(model()), times=[0.1, 0.4], limits=fv.Limits(steps=4), throw=False)
    assert kept.q.shape[2:] == (7, 12)
    read = fv.load(kept.save(tmp_path / f"run{ending}"))
    assert same_bits(read.t, kept.t)
    assert same_bits(read.q, kept.q)
    assert same_bits(read.aux["b"], kept.aux["b"])
    for name in ("grid", "model", "status", "stats", "message", "configuration"):
        assert getattr(read, name) == getattr(kept, name), name
    for name, values in kept.observables().items():
        assert same_bits(read.observables()[name], values), name


@pytest.mark.parametrize("ending", ENDINGS)
def test_special_numbers_and_other_orders_in_memory_survive(solution, ending, tmp_path):
    q = np.asfortranarray(solution.q)
    q[1, 1, 2, :5] = [np.nan, np.inf, -0.0, 5e-324, -np.inf]
    assert same_bits(fv.load(attrs.evolve(solution, q=q).save(tmp_path / f"run{ending}")).q, q)


def test_an_archive_holds_the_axes(solution, tmp_path):
    with np.load(solution.save(tmp_path / "run.npz")) as file:
        assert np.array_equal(file["x"], solution.grid.axes[0].centers)
        assert np.array_equal(file["y"], solution.grid.axes[1].centers)
        assert [len(file[f"edges_{name}"]) for name in "xy"] == [13, 8]


@pytest.mark.parametrize("name", ["q", "aux_b"])
def test_an_archive_with_exchanged_axes_is_refused(solution, name, tmp_path):
    with np.load(solution.save(tmp_path / "run.npz")) as file:
        arrays = dict(file)
    arrays[name] = arrays[name].swapaxes(-1, -2)
    np.savez(tmp_path / "other.npz", **arrays)
    with pytest.raises(Unreadable, match=rf"'{name}' must have shape \(.*7, 12\)"):
        fv.load(tmp_path / "other.npz")


def test_parts_of_sides_are_described_and_built():
    east = pool().boundary[1]
    assert isinstance(east, fv.Along)
    assert build(describe(east)) == east
    assert build(describe(pool().grid)) == pool().grid


@NEEDS_IO
@pytest.mark.parametrize(("model", "names"), [
    (gr.ShallowWater(), ["h", "h_v_x", "h_v_y", "v_x", "v_y", "speed", "surface", "b"]),
    (gr.TwoPhase(), ["hs", "hs_vs_x", "hs_vs_y", "hf", "hf_vf_x", "hf_vf_y", "h", "phi", "vs_x", "vs_y", "speed_s", "vf_x",
                     "vf_y", "speed_f", "v_x", "v_y", "speed", "surface", "b"])])
def test_a_dataset_has_components_observables_and_cf_coordinates(model, names):
    kept = solve(pool(model), times=[0.1])
    data = kept.to_xarray()
    assert list(data.data_vars) == names
    assert data["speed"].dims == ("time", "y", "x")
    assert data["b"].dims == ("y", "x")
    for name, axis in zip("xy", kept.grid.axes, strict=True):
        assert data[name].attrs == {"units": "m", "axis": name.upper(), "long_name": "centre of the cell",
                                    "bounds": f"{name}_bounds"}
        assert np.array_equal(data[name], axis.centers)
        assert np.array_equal(data[f"{name}_bounds"], np.stack([axis.edges[:-1], axis.edges[1:]], axis=1))
    for name, values in kept.observables().items():
        assert np.array_equal(data[name][-1], values), name
    assert all(data[name].attrs["units"] == "m s-1" for name in ("v_x", "v_y", "speed"))
    assert data["speed"].attrs["long_name"].startswith("size of the velocity")
    assert data["v_y"].attrs["long_name"].endswith(" along y")
    assert data.attrs["title"].endswith("on 12 x 7 cells")


@NEEDS_IO
def test_components_of_a_model_without_phases_are_not_written_twice():
    problem = fv.Problem(fv.Acoustics(), fv.Grid((0.0, 0.0), (1.0, 1.0), (6, 5)),
                         lambda x, y: [np.exp(-((x - 0.5) ** 2)), 0.0 * x, y], 0.1)
    data = solve(problem).to_xarray()
    assert list(data.data_vars) == ["p", "u_x", "u_y", "speed"]
    assert data["u_y"].attrs["long_name"] == "velocity along y"
    assert np.array_equal(data["speed"], np.hypot(data["u_x"], data["u_y"]))


@NEEDS_IO
def test_other_tools_read_what_a_file_holds(solution, tmp_path):
    import xarray

    with xarray.open_dataset(solution.save(tmp_path / "run.nc"), engine="h5netcdf") as file:
        assert file.reset_coords().equals(solution.to_xarray().reset_coords())
        assert dict(file.sizes) == {"time": 4, "y": 7, "x": 12, "bounds": 2}


@NEEDS_IO
def test_time_is_marked_in_texts_of_fixed_length(solution, tmp_path):
    """VTK's reader takes no others: without them the outputs lie one above the other."""
    import h5py

    with h5py.File(solution.save(tmp_path / "run.nc")) as file:
        assert {name: (file["time"].attrs.get_id(name).dtype.kind, file["time"].attrs[name]) for name in ("units", "axis")} == {
            "units": ("S", b"s"), "axis": ("S", b"T")}


@NEEDS_IO
def test_a_streamed_run_is_the_run_in_memory(solution, tmp_path):
    ends = solve(pool(), times=[0.1, 0.2, 0.4], record=fv.Stream(tmp_path / "run.nc"))
    read = fv.load(tmp_path / "run.nc")
    assert same_bits(read.q, solution.q)
    assert same_bits(ends.q, solution.q[[0, -1]])


@NEEDS_IO
def test_a_killed_stream_leaves_its_outputs(solution, tmp_path):
    code = ("import os, fvkit as fv\nfrom tests.cases import solve\nfrom tests.plane.scenes import pool\n"
            "def end(stepper):\n    if stepper.t > 0.25:\n        os._exit(9)\n"
            f"solve(pool(), times=[0.1, 0.2, 0.4], record=fv.Stream({str(tmp_path / 'run.nc')!r}), observers=end)\n")
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 9
    assert same_bits(fv.load(tmp_path / "run.part.nc").q, solution.q[:3])
