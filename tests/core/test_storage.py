"""Solutions in files: bit-exact round trips, files that other tools open, and files that nobody should trust."""

import contextlib
import io
import json
import pickle
import subprocess
import sys
import time
import tracemalloc
import zipfile
from importlib.util import find_spec

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.files import Unreadable
from fvkit.output import configuration, netcdf
from fvkit.output.configuration import build, describe
from tests.cases import Traffic, solve

HAS_IO = all(find_spec(name) for name in ("xarray", "h5netcdf", "h5py"))
ENDINGS = (".npz", pytest.param(".nc", marks=pytest.mark.skipif(not HAS_IO, reason="needs the extra io")))


def avalanche(model=gr.TwoPhase, cells=40, **options):
    scene = gr.Scene((-1.0, 2.0), 0.3, lambda x: {"h": np.where(x < 0, 1.0, 0.3), "phi": 0.6 - 0.1 * np.tanh(x), "vs": 0.2},
                     bottom=lambda x: 0.1 * np.exp(-(x**2)), sources=gr.VelocityDrag(2.0, 1.0), **options)
    return scene.problem(model, cells)


@pytest.fixture(scope="module")
def solution():
    return solve(avalanche(), times=[0.1, 0.2, 0.3])


@pytest.fixture
def file(solution, tmp_path):
    return solution.save(tmp_path / "run.npz")


def same_bits(one, other):
    return one.shape == other.shape and one.tobytes() == other.tobytes()


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("model", [gr.TwoPhase, gr.Reduced, gr.ShallowWater, gr.PitmanLe, gr.TwoLayer])
def test_a_solution_comes_back_bit_for_bit(model, ending, tmp_path):
    kept = solve(avalanche(model), times=[0.1, 0.3], limits=fv.Limits(steps=8), throw=False)
    assert not kept.success
    read = fv.load(kept.save(tmp_path / f"run{ending}"))
    assert same_bits(read.t, kept.t)
    assert same_bits(read.q, kept.q)
    assert same_bits(read.aux["b"], kept.aux["b"])
    for name in ("grid", "model", "status", "stats", "message", "configuration"):
        assert getattr(read, name) == getattr(kept, name), name
    assert set(read.observables()) == set(kept.observables())


def test_the_order_of_an_array_in_memory_does_not_matter(solution, tmp_path):
    turned = attrs.evolve(solution, q=np.asfortranarray(solution.q))
    assert np.array_equal(fv.load(turned.save(tmp_path / "run.npz")).q, solution.q)


@pytest.mark.parametrize("ending", ENDINGS)
def test_special_numbers_survive(solution, ending, tmp_path):
    q = solution.q.copy()
    q[1, 1, :5] = [np.nan, np.inf, -0.0, 5e-324, -np.inf]
    odd = attrs.evolve(solution, q=q, stats=attrs.evolve(solution.stats, max_cfl=np.inf))
    read = fv.load(odd.save(tmp_path / f"run{ending}"))
    assert same_bits(read.q, q)
    assert read.stats.max_cfl == np.inf


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_solution_made_by_hand_and_saved_again_stays_the_same(solution, ending, tmp_path):
    bare = attrs.evolve(solution, configuration={})
    once = fv.load(bare.save(tmp_path / f"one{ending}"))
    again = fv.load(once.save(tmp_path / f"two{ending}"))
    assert again.configuration == once.configuration
    assert again.model == solution.model


def test_other_endings_are_refused(solution, tmp_path):
    with pytest.raises(ValueError, match=r"must end in .npz or .nc, got 'run.h5'"):
        solution.save(tmp_path / "run.h5")


# ---- configuration ------------------------------------------------------------------------------------------------------


PARTS = [fv.WavePropagation(fv.Roe(), limiter=(fv.MC(), fv.VanLeer()), order=1, cfl=0.4, splitting=fv.Godunov(), entropy_fix=False),
         fv.MethodOfLines(gr.Relaxation(), fv.WENO5(), fv.DP5(), cfl=0.7), fv.Inflow([1.0, 2.5e-17]), fv.Grid(-1, 1 / 3, 7),
         gr.TwoPhase(g=9.80665, gamma=1 / 3), gr.Voellmy(0.1, 500.0), gr.PitmanLeDrag(0.3, 1.5), Traffic(0.1), fv.Strang(), fv.ARK4(),
         (fv.Wall(), fv.Periodic()), (), fv.Advection(-1e300)]


@pytest.mark.parametrize("part", PARTS, ids=lambda part: type(part).__name__)
def test_every_part_goes_through_json_and_back(part):
    assert build(json.loads(json.dumps(describe(part), allow_nan=False))) == part


def test_the_configuration_is_complete(solution):
    kept = json.loads(json.dumps(solution.configuration, allow_nan=False))
    assert kept["model"]["class"] == "TwoPhase"
    assert kept["model"]["dry"] == solution.model.dry
    assert build(kept["scheme"]) == fv.WavePropagation(gr.Relaxation())
    assert build(kept["sources"]) == (gr.VelocityDrag(2.0, 1.0),)
    assert build(kept["boundary"]) == (fv.Outflow(), fv.Outflow())
    assert (kept["t_start"], kept["t_end"], kept["backend"], kept["status"]) == (0.0, 0.3, "numpy", "FINISHED")
    assert kept["versions"].keys() == {"fvkit", "numpy", "python"}
    assert build(kept["statistics"]) == build(kept["statistics"] | {"repaired_cells": 0}) == solution.stats
    assert "M2AN 42 (2008) 851-885" in kept["citation"]


def test_a_function_is_named_but_never_restored():
    described = describe((fv.Outflow(), fv.Inflow(np.cos)))
    assert described[1]["state"]["callable"].endswith("cos")
    with pytest.raises(ValueError, match=r"data\[1\].state is .*cos, which no file can hold"):
        build(described)


@pytest.mark.parametrize(("data", "words"), [
    ({"class": "Nowhere", "from": "os"}, "a Nowhere of os, which is not loaded: import the module that defines it first"),
    ({"class": "system", "from": "os"}, "import the module that defines it first"),
    ({"class": "Path", "from": "pathlib"}, "import the module that defines it first"),
    ({"class": ["x"], "from": {}}, "import the module that defines it first"),
    ({"class": "Roe", "from": "fvkit.schemes.riemann", "colour": 1}, "a Roe, cannot be made from its fields"),
    ({"class": "Grid", "from": "fvkit.problem.grid", "lower": 1.0, "upper": 0.0, "num_cells": 3}, "`lower` must be < `upper`"),
    ({"class": "Model", "from": "fvkit.problem.model"}, "cannot be made from its fields"),
    ({"number": "3"}, "is not what a configuration holds"), ({"list": 3, "array": 2}, "is not what a configuration holds")])
def test_plain_data_that_makes_no_part_is_refused(data, words):
    with pytest.raises(ValueError, match=words):
        build(data)


def test_a_class_of_the_same_name_elsewhere_is_not_taken_for_the_right_one():
    class Burgers(fv.Model):
        conserved = ("u",)

        def flux(self, q):
            return q

        def wave_speeds(self, q):
            return 1.0, 1.0

    assert build(describe(fv.Burgers())) == fv.Burgers()
    assert type(build(describe(Burgers()))) is Burgers
    with pytest.raises(ValueError, match="import the module that defines it first"):
        build({"class": "Burgers", "from": "gone"})


class TrafficThatMoved(Traffic):
    """Its name is that of no other class, whatever other tests have defined."""


def test_a_class_that_moved_is_found_by_its_name():
    assert build({"class": "TrafficThatMoved", "from": "__main__", "limit": 2.0}) == TrafficThatMoved(2.0)


# ---- files that are not what they should be -----------------------------------------------------------------------------


def rewrite(file, change, compression=zipfile.ZIP_STORED):
    """Write the entries of an archive again after ``change`` of the dict of their bytes."""
    with zipfile.ZipFile(file) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    change(entries)
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)


def npy(array, **options):
    content = io.BytesIO()
    np.lib.format.write_array(content, np.asanyarray(array), **options)
    return content.getvalue()


class Bomb:
    def __reduce__(self):
        return print, ("this must never be printed",)


def test_objects_are_never_unpickled(file, capsys):
    rewrite(file, lambda entries: entries.update({"t.npy": npy(np.array([Bomb()], dtype=object), allow_pickle=True)}))
    with pytest.raises(ValueError, match=r"run.npz cannot be read: its entry 't.npy' holds object"):
        fv.load(file)
    rewrite(file, lambda entries: entries.update({"t.npy": pickle.dumps(Bomb())}))
    with pytest.raises(ValueError, match=r"run.npz cannot be read: its entry 't.npy' is no array"):
        fv.load(file)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("share", [0.0, 0.01, 0.3, 0.9, 0.999])
def test_a_truncated_file_is_refused(file, share):
    content = file.read_bytes()
    file.write_bytes(content[:int(share * len(content))])
    with pytest.raises(ValueError, match=r"run.npz cannot be read: it is damaged or no .npz file"):
        fv.load(file)


def test_damage_is_noticed_wherever_it_is(file):
    content = file.read_bytes()
    for place in np.random.default_rng(1).integers(0, len(content), 60):
        changed = bytearray(content)
        changed[place] ^= 0xFF
        file.write_bytes(bytes(changed))
        with contextlib.suppress(Unreadable):
            fv.load(file)


@pytest.mark.parametrize("header", ["{'descr': '<f8', 'fortran_order': False, 'shape': (), \x82", "{'descr': (", "{'descr': '<f8'\n  ]}", "\0"])
def test_a_header_that_is_no_literal_is_damage(header, file):
    text = header.ljust(117).encode("latin1") + b"\n"
    rewrite(file, lambda entries: entries.update({"q.npy": b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text}))
    with pytest.raises(Unreadable, match=r"run.npz cannot be read: its entry 'q.npy' is no array"):
        fv.load(file)


def test_a_missing_file_is_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"nothing.npz"):
        fv.load(tmp_path / "nothing.npz")


@pytest.mark.parametrize("name", ["format", "t", "q", "aux_b", "configuration"])
def test_a_missing_entry_is_named(file, name):
    rewrite(file, lambda entries: entries.pop(f"{name}.npy"))
    with pytest.raises(ValueError, match=f"run.npz cannot be read: it has no '{name}', only"):
        fv.load(file)


@pytest.mark.parametrize(("name", "array", "words"), [
    ("q", np.zeros((4, 4, 39)), r"'q' must have shape \(4, 4, 40\), got \(4, 4, 39\)"),
    ("t", np.zeros(3), r"'q' must have shape \(3, 4, 40\), got \(4, 4, 40\)"),
    ("t", np.zeros((2, 2)), r"'t' must have shape \(any\), got \(2, 2\)"),
    ("aux_b", np.zeros(40, dtype="f4"), "'aux_b' must be of type f8, got float32"),
    ("configuration", np.array("{"), "its configuration is no JSON"), ("configuration", np.array("[" * 100_000), "its configuration is no JSON"),
    ("configuration", np.array("[1]"), "its configuration is no mapping"), ("configuration", np.array("{}"), "its configuration has no 'model'"),
    ("format", np.array("something"), "it is no 'fvkit solution 1' but 'something'")])
def test_a_wrong_entry_is_named(file, name, array, words):
    rewrite(file, lambda entries: entries.update({f"{name}.npy": npy(array)}))
    with pytest.raises(ValueError, match=f"run.npz cannot be read: {words}"):
        fv.load(file)


def test_what_declares_more_than_it_holds_is_refused_before_it_is_read(file):
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (4, 4, 10**12)})
    rewrite(file, lambda entries: entries.update({"q.npy": header.getvalue() + bytes(800)}))
    with pytest.raises(ValueError, match=r"declares shape \(4, 4, 1000000000000\) of float64, but has 800 bytes"):
        fv.load(file)


def test_a_zip_bomb_is_not_opened(file):
    rewrite(file, lambda entries: entries.update({"q.npy": bytes(200_000_000)}), zipfile.ZIP_DEFLATED)
    assert file.stat().st_size < 1_000_000
    tracemalloc.start()
    with pytest.raises(ValueError, match="is compressed, which fvkit never writes"):
        fv.load(file)
    assert tracemalloc.get_traced_memory()[1] < 5_000_000
    tracemalloc.stop()


def test_a_model_that_is_not_loaded_says_what_to_import(file):
    def change(entries):
        kept = json.loads(str(np.load(io.BytesIO(entries["configuration.npy"]))))
        kept["model"] |= {"class": "Avalanche", "from": "my.models"}
        entries["configuration.npy"] = npy(np.array(json.dumps(kept)))

    rewrite(file, change)
    with pytest.raises(ValueError, match=r"a Avalanche of my.models, which is not loaded: import the module that defines it first"):
        fv.load(file)


def test_an_existing_file_survives_a_failure(solution, file, monkeypatch):
    before = file.read_bytes()
    monkeypatch.setattr("fvkit.output.npz.fill", lambda handle, arrays: handle.write(b"half") and 1 / 0)
    with pytest.raises(ZeroDivisionError):
        solution.save(file)
    assert file.read_bytes() == before
    assert [path.name for path in file.parent.iterdir()] == ["run.npz"]


# ---- netCDF and xarray --------------------------------------------------------------------------------------------------


def test_a_missing_extra_is_a_sentence(solution, tmp_path, monkeypatch):
    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr("fvkit.validation.import_module", missing)
    with pytest.raises(ImportError, match=r"^to_xarray needs xarray: pip install 'fvkit\[io\]'$"):
        solution.to_xarray()
    with pytest.raises(ImportError, match=r"^netCDF needs h5netcdf: pip install 'fvkit\[io\]'$"):
        solution.save(tmp_path / "run.nc")
    assert not list(tmp_path.iterdir())


def test_the_dataset_has_names_units_and_coordinates(solution):
    pytest.importorskip("xarray")
    data = solution.to_xarray()
    assert dict(data.sizes) == {"time": 4, "x": 40, "bounds": 2}
    assert set(data.data_vars) == {"hs", "hs_vs", "hf", "hf_vf", "h", "phi", "vs", "vf", "v", "surface", "b"}
    assert data.hs_vs.attrs == {"units": "m2 s-1", "long_name": "discharge of the solid", "original_name": "hs vs", "role": "conserved"}
    assert (data.phi.units, data.b.units, data.time.units, data.x.units, data.x.axis) == ("1", "m", "s", "m", "X")
    assert data.x.bounds == "x_bounds"
    assert np.array_equal(data.x_bounds[:, 1], solution.grid.edges[1:])
    assert data.Conventions == "CF-1.11"
    assert data.source == f"fvkit {fv.__version__}"
    assert json.loads(data.configuration) == solution.configuration
    for k in range(4):
        assert np.array_equal(data.surface[k], solution.observables(k)["surface"])
        assert np.array_equal(data.hf_vf[k], solution.q[k, 3])


@pytest.mark.parametrize("model", [gr.TwoPhase, gr.Reduced, gr.ShallowWater, gr.PitmanLe, gr.TwoLayer])
def test_every_variable_of_the_granular_models_has_a_unit(model):
    kept = solve(avalanche(model), times=[0.01])
    assert all("units" in field.attributes for field in netcdf.fields(kept.model, kept.grid, kept.q[0], kept.aux))


def test_the_file_opens_without_fvkit(solution, tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    with xarray.open_dataset(solution.save(tmp_path / "run.nc"), engine="h5netcdf", decode_coords="all") as data:
        expected = solution.to_xarray()
        assert len(data.attrs.pop("checksum")) == 64
        assert data.attrs == expected.attrs
        for name in expected.variables:
            assert data[name].equals(expected[name]), name
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_names_that_collide_stay_apart():
    @attrs.frozen
    class Odd(fv.Model):
        conserved = ("u v", "u_v", "time", "2nd", "°")

        def flux(self, q):
            return q

        def wave_speeds(self, q):
            return 1.0, 1.0

        def observables(self, q, aux=None):
            return {"u v": 2.0 * q[0]}

    names = [field.name for field in netcdf.fields(Odd(), fv.Grid(0.0, 1.0, 3), np.ones((5, 3)), {})]
    assert names == ["u_v", "u_v_2", "time_2", "q_2nd", "u", "u_v_3"]


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_damaged_netcdf_file_is_refused(solution, tmp_path):
    import h5netcdf

    file = solution.save(tmp_path / "run.nc")
    content = file.read_bytes()
    for changed in (b"", b"nothing", content[:len(content) // 2]):
        file.write_bytes(changed)
        with pytest.raises(ValueError, match=r"run.nc cannot be read"):
            fv.load(file)
    with h5netcdf.File(tmp_path / "other.nc", "w") as other:
        other.dimensions = {"x": 3}
    with pytest.raises(ValueError, match=r"other.nc cannot be read: it has no attribute 'configuration'"):
        fv.load(tmp_path / "other.nc")
    with pytest.raises(FileNotFoundError):
        fv.load(tmp_path / "nothing.nc")


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_netcdf_file_that_declares_more_than_it_holds_is_refused(solution, tmp_path):
    import h5netcdf

    file = solution.save(tmp_path / "run.nc")
    with h5netcdf.File(file, "a") as data:
        data.resize_dimension("time", 10**9)
    with pytest.raises(ValueError, match=r"run.nc cannot be read: it declares .* bytes of content, more than 100 times its size"):
        fv.load(file)


# ---- streams ------------------------------------------------------------------------------------------------------------


def wave(cells, t_end=1.0):
    return fv.Problem(fv.Advection(1.0), fv.Grid(0.0, 1.0, cells), lambda x: np.sin(2 * np.pi * x)[None], t_end, boundary=fv.Periodic())


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_stream_holds_what_the_solution_would(tmp_path):
    times = np.linspace(0.05, 0.3, 6)
    whole = solve(avalanche(), times=times)
    ends = solve(avalanche(), times=times, record=fv.Stream(tmp_path / "run.nc"))
    read = fv.load(tmp_path / "run.nc")
    assert same_bits(read.q, whole.q)
    assert same_bits(read.t, whole.t)
    assert same_bits(ends.q, whole.q[[0, -1]])
    assert (read.status, read.stats, read.configuration) == (ends.status, ends.stats, ends.configuration)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_stream_stays_within_memory(tmp_path):
    cells, frames = 20_000, 200
    problem, scheme = wave(cells, frames * 2.0 / cells), fv.WavePropagation(fv.Roe(), order=1)
    tracemalloc.start()
    solve(problem, scheme, np.linspace(0.0, problem.t_end, frames + 1), record=fv.Stream(tmp_path / "run.nc"))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 30 * 8 * cells
    assert fv.load(tmp_path / "run.nc").q.shape == (frames + 1, 1, cells)


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_stream_that_fails_is_closed_under_its_name_and_one_that_is_cut_off_can_be_read(tmp_path):
    stopped = solve(wave(50), times=[0.1, 0.2, 0.5], limits=fv.Limits(steps=10), throw=False, record=fv.Stream(tmp_path / "stopped.nc"))
    read = fv.load(tmp_path / "stopped.nc")
    assert read.status is fv.Status.MAX_STEPS
    assert read.t.tolist() == [0.0, 0.1, stopped.t[-1]]

    def broken(stepper):
        if stepper.t > 0.15:
            raise LookupError("a mistake of the observer")

    with pytest.raises(LookupError):
        solve(wave(50), times=[0.1, 0.2], record=fv.Stream(tmp_path / "cut.nc"), observers=[broken])
    assert not (tmp_path / "cut.nc").exists()
    read = fv.load(tmp_path / "cut.part.nc")
    assert (read.status, read.t.tolist()) == (fv.Status.INTERRUPTED, [0.0, 0.1])


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_killed_stream_leaves_a_file_that_can_be_read(tmp_path):
    code = f"""
import sys
sys.path[:0] = {[entry for entry in sys.path if entry]!r}
import numpy as np
import fvkit as fv
from tests.core.test_storage import solve, wave
print("ready", flush=True)
solve(wave(100, 100.0), times=np.linspace(0.01, 100.0, 10_000), record=fv.Stream({str(tmp_path / "run.nc")!r}))
"""
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    try:
        assert process.stdout.readline() == b"ready\n"
        part, patience = tmp_path / "run.part.nc", time.monotonic() + 60.0
        while (not part.exists() or part.stat().st_size < 100_000) and time.monotonic() < patience:
            time.sleep(0.01)
    finally:
        process.kill()
        process.wait()
        process.stdout.close()
    read = fv.load(tmp_path / "run.part.nc")
    assert (read.status, len(read.t) > 3) == (fv.Status.INTERRUPTED, True)
    expected = solve(wave(100, 100.0), times=read.t[1:])
    assert same_bits(read.q, expected.q)


@pytest.mark.skipif(not HAS_IO, reason="needs the extra io")
def test_a_frame_that_was_cut_off_is_left_out(solution, tmp_path):
    import h5netcdf

    file = solution.save(tmp_path / "run.nc")
    with h5netcdf.File(file, "a") as data:
        data.resize_dimension("time", 5)
        del data.attrs["checksum"]  # a run that was cut off has left none
    assert same_bits(fv.load(file).q, solution.q)


def test_a_stream_needs_its_ending_and_stands_alone(tmp_path):
    with pytest.raises(ValueError, match=r"`path` must end in .nc, got 'run.npz'"):
        solve(wave(10), record=fv.Stream(tmp_path / "run.npz"))
    with pytest.raises(ValueError, match="`checkpoint` and `record` cannot be combined"):
        solve(wave(10), record=fv.Stream(tmp_path / "run.nc"), checkpoint=fv.Checkpoint(tmp_path / "c.npz"))


def test_reading_imports_nothing_by_name(file, monkeypatch):
    def never(*args, **kwargs):
        raise AssertionError("something was imported by name")

    monkeypatch.setattr("importlib.import_module", never)
    monkeypatch.setattr(configuration, "entry_points", never)
    assert fv.load(file).success
