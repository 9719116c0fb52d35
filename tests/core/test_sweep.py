"""Sweeps: samples, results, what fails, what dies, what goes on, whichever the executor."""

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from threading import Timer

import numpy as np
import pytest
from scipy import stats

import fvkit as fv
from tests import sweep_members as members


class Failing(ThreadPoolExecutor):
    """Fails the first ``times`` tasks, as a cluster that loses its workers does."""

    def __init__(self, times):
        super().__init__(2)
        self.times, self.tasks = times, 0

    def submit(self, function, *arguments):
        self.tasks += 1
        if self.tasks <= self.times:
            future = Future()
            future.set_exception(ConnectionError("worker gone"))
            return future
        return super().submit(function, *arguments)


def test_a_latin_hypercube_has_one_sample_in_every_slice():
    samples = fv.Samples.latin_hypercube({"a": (1.0, 3.0), "b": (1e-2, 1e2, "log"), "c": stats.norm(5.0, 2.0)}, 50, seed=3)
    shares = [(samples.values["a"] - 1.0) / 2.0, (np.log10(samples.values["b"]) + 2.0) / 4.0,
              stats.norm(5.0, 2.0).cdf(samples.values["c"])]
    for share in shares:
        np.testing.assert_array_equal(np.sort(np.floor(50 * share)), np.arange(50))
    again = fv.Samples.latin_hypercube({"a": (1.0, 3.0), "b": (1e-2, 1e2, "log"), "c": stats.norm(5.0, 2.0)}, 50, seed=3)
    np.testing.assert_array_equal(samples.values["b"], again.values["b"])


def test_a_grid_is_every_combination_and_keeps_kinds_of_values():
    samples = fv.Samples.grid({"n": [1, 2], "name": ["a", "b", "c"]})
    assert [samples[i] for i in (0, 2, 3)] == [{"n": 1, "name": "a"}, {"n": 1, "name": "c"}, {"n": 2, "name": "a"}]
    assert len(samples) == 6
    assert type(samples[0]["n"]) is int


@pytest.mark.parametrize(("make", "kind", "word"), [
    (lambda: fv.Samples.given({"a": [1.0], "b": [1.0, 2.0]}), ValueError, "1 of a, 2 of b"),
    (lambda: fv.Samples.given({}), TypeError, "non-empty mapping"),
    (lambda: fv.Samples.given({"a": [None]}), TypeError, "`a`"),
    (lambda: fv.Samples.latin_hypercube({"a": (2.0, 1.0)}, 4), ValueError, "a[1]"),
    (lambda: fv.Samples.latin_hypercube({"a": (0.0, 1.0, "log")}, 4), ValueError, "a[0]"),
    (lambda: fv.Samples.latin_hypercube({"a": 3.0}, 4), ValueError, "ppf"),
    (lambda: fv.Keep(["largest.h"]), ValueError, "max"),
    (lambda: fv.sweep(None, {"x": [1]}), TypeError, "`function`"),
    (lambda: fv.sweep(members.square, {"x": [1]}, "dask"), TypeError, "`executor`"),
    (lambda: fv.sweep(members.square, {"x": [1]}, workers=0), ValueError, "`workers`"),
    (lambda: fv.sweep(members.square, {"x": [1]}, workers=1, progress="yes"), TypeError, "`progress`"),
    (lambda: fv.sweep(lambda x: {"x": x}, {"x": [1]}, workers=2), ValueError, "top level"),
])
def test_mistakes_are_sentences(make, kind, word):
    with pytest.raises(kind) as raised:
        make()
    assert word in str(raised.value)


def test_processes_threads_and_no_executor_give_the_same():
    samples = fv.Samples.grid({"x": [1.0, 2.0, 3.0], "y": [0.0, 0.5]})
    serial = fv.sweep(members.square, samples, workers=1)
    processes = fv.sweep(members.square, samples, workers=2)
    with ThreadPoolExecutor(2) as pool:
        threads = fv.sweep(members.square, samples, pool, workers=2)
        assert pool.submit(int).result() == 0  # a given executor is left open
    np.testing.assert_array_equal(serial.outputs["value"], [1.0, 1.5, 4.0, 4.5, 9.0, 9.5])
    for other in (processes, threads):
        assert other.success
        assert other.outputs.keys() == serial.outputs.keys()
        for name, values in serial.outputs.items():
            np.testing.assert_array_equal(other.outputs[name], values)


def test_processes_are_other_processes():
    assert os.getpid() not in fv.sweep(members.pid, {"x": range(4)}, workers=2).outputs["pid"]


def test_what_fails_is_a_row_and_the_others_go_on():
    result = fv.sweep(members.troubled, {"x": range(4)}, workers=1)
    assert result.status.tolist() == ["finished", "error", "non_finite", "finished"]
    assert result.message[1] == "ZeroDivisionError: one is too much"
    assert "in cell 3 (x = 1.5): u = inf" in result.message[2]
    np.testing.assert_array_equal(result.outputs["value"], [0.0, np.nan, np.nan, 3.0])
    assert not result.success
    assert result.to_csv().splitlines()[3].startswith("2,2,nan,nan,non_finite,")


def test_a_member_that_kills_its_process_is_lost_alone():
    result = fv.sweep(members.deadly, {"x": range(12)}, workers=2, retries=1, batch=2)
    assert np.flatnonzero(~result.finished).tolist() == [5]
    assert result.status[5] == "lost"
    np.testing.assert_array_equal(np.delete(result.outputs["value"], 5), np.delete(np.arange(12.0), 5))


def test_a_process_that_dies_once_loses_nothing(tmp_path):
    result = fv.sweep(members.deadly_once, {"x": range(8), "folder": [str(tmp_path)] * 8}, workers=2)
    assert (tmp_path / "died").exists()
    np.testing.assert_array_equal(result.outputs["value"], 2.0 * np.arange(8))


def test_members_whose_executor_fails_are_run_again_up_to_retries():
    with Failing(3) as pool:
        assert fv.sweep(members.square, {"x": [1.0, 2.0]}, pool, retries=2).success
    with Failing(100) as pool:
        lost = fv.sweep(members.square, {"x": [1.0, 2.0]}, pool, retries=2)
    assert pool.tasks == 6
    assert lost.status.tolist() == ["lost", "lost"]
    assert lost.message[0] == "ConnectionError: worker gone"


def test_a_sweep_goes_on_where_it_stopped(tmp_path):
    marks, folder = tmp_path / "marks", tmp_path / "sweep"
    marks.mkdir()

    def stop(share):
        if share >= 0.5:
            raise KeyboardInterrupt

    given = {"x": range(10), "folder": [str(marks)] * 10}
    with pytest.raises(KeyboardInterrupt):
        fv.sweep(members.counted, given, workers=1, folder=folder, progress=stop)
    assert len(list(marks.iterdir())) == 5
    first = fv.sweep(members.counted, given, workers=1, folder=folder)
    assert first.status[7] == "error"
    assert len(list(marks.iterdir())) == 10
    (marks / "mended").touch()
    (folder / "member-000004.npz").write_bytes(b"half a fi")
    shares = []
    second = fv.sweep(members.counted, given, workers=1, folder=folder, progress=shares.append)
    assert shares == [0.8, 0.9, 1.0]
    assert len(list(marks.iterdir())) == 13  # the mark of mending, and members 4 and 7 again
    np.testing.assert_array_equal(second.outputs["value"], 10.0 * np.arange(10))
    with pytest.raises(ValueError, match="holds another sweep, of other parameters"):
        fv.sweep(members.counted, {"x": range(9), "folder": [str(marks)] * 9}, workers=1, folder=folder)


def test_solutions_are_reduced_where_they_are_made():
    result = fv.sweep(members.burgers, {"amplitude": [0.5, 1.0], "cells": [20, 20]}, workers=1,
                      keep=["u", "max.u", "mean.u", "front.u", "steps"])
    one = members.burgers(1.0, 20)
    np.testing.assert_array_equal(result.outputs["u"][1], one.q[-1, 0])
    np.testing.assert_array_equal(result.outputs["x"][0], one.grid.centers)
    assert result.outputs["max.u"][1] == one.q[-1, 0].max()
    assert result.outputs["steps"][1] == one.stats.steps
    assert result.outputs["front.u"][1] == 1.0
    assert abs(result.outputs["mean.u"][1]) < 1e-15
    with pytest.raises(ValueError, match="must be one of u"):
        fv.Keep("max.h")(one)


def test_a_partial_solution_is_no_output():
    result = fv.sweep(members.blows_up, {"cells": [10, 200]}, workers=1, keep=lambda solution: {"end": solution.t[-1]})
    assert result.status.tolist() == ["max_steps", "max_steps"]
    assert result.outputs == {}


def test_arrays_of_different_shapes_stay_apart():
    result = fv.sweep(members.burgers, {"amplitude": [1.0, 1.0], "cells": [20, 30]}, workers=1)
    assert [values.shape for values in result.outputs["u"]] == [(20,), (30,)]
    assert "u" not in result.table


def test_datasets_have_a_dimension_per_parameter_or_one_of_members(tmp_path):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    grid = fv.sweep(members.burgers, fv.Samples.grid({"amplitude": [0.5, 1.0, 2.0], "cells": [20]}), workers=1)
    data = grid.to_xarray()
    assert data["u"].dims == ("amplitude", "cells", "x")
    np.testing.assert_array_equal(data["u"].sel(amplitude=1.0, cells=20), grid.outputs["u"][1])
    flat = fv.sweep(members.troubled, {"x": range(4)}, workers=1).to_xarray()
    assert flat["value"].dims == ("member",)
    np.testing.assert_array_equal(flat["value"].swap_dims(member="x").sel(x=3), 3.0)
    with xarray.open_dataset(grid.save(tmp_path / "sweep.nc"), engine="h5netcdf") as read:
        np.testing.assert_array_equal(read["u"], data["u"])
        assert read["status"].values.ravel().tolist() == ["finished"] * 3
    ragged = fv.sweep(members.burgers, {"amplitude": [1.0, 1.0], "cells": [20, 30]}, workers=1)
    with pytest.raises(ValueError, match="different shapes"):
        ragged.to_xarray()


@pytest.mark.filterwarnings("ignore::DeprecationWarning", "ignore::ResourceWarning", "ignore::UserWarning",
                            "ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_dask_cluster_that_loses_a_worker_half_way_loses_no_member(tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, local_directory=str(tmp_path)) as cluster, \
            distributed.Client(cluster) as client:
        doomed = next(iter(client.run(os.getpid).values()))
        timer = Timer(0.5, partial(os.kill, doomed, signal.SIGKILL))
        timer.start()
        result = fv.sweep(members.slow, {"x": np.arange(60.0)}, client.get_executor())
        timer.join()
    assert result.success
    np.testing.assert_array_equal(result.outputs["value"], np.arange(60.0) + 0.5)
    assert len(set(result.outputs["pid"])) > 1


def test_processes_that_never_get_to_work_stop_the_sweep():
    with pytest.raises(RuntimeError, match="__main__"):
        fv.sweep(members.deadly, {"x": [5] * 30}, workers=2, batch=1)


def test_without_the_extras_everything_but_datasets_works(monkeypatch, capsys):
    for name in ("tqdm", "tqdm.auto", "xarray"):
        monkeypatch.setitem(sys.modules, name, None)
    result = fv.sweep(members.square, {"x": [1.0, 2.0]}, workers=1, progress=True)
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "100.0 %" in shown.err
    assert result.table["value"].tolist() == [1.0, 4.0]
    with pytest.raises(ImportError, match=r"fvkit\[io\]"):
        result.to_xarray()


def test_tqdm_shows_members_where_it_is_installed(capsys):
    pytest.importorskip("tqdm")
    fv.sweep(members.square, {"x": [1.0, 2.0]}, workers=1, progress=True)
    assert "2/2" in capsys.readouterr().err


def test_workers_import_no_pictures_and_no_extras():
    code = ("import sys, fvkit, fvkit_granular; print([name for name in ('matplotlib', 'scipy.stats', 'xarray', 'tqdm', 'distributed') "
            "if name in sys.modules])")
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_an_interrupted_run_stops_the_sweep_and_is_not_kept(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        fv.sweep(members.interrupted, {"x": [1.0, 2.0]}, workers=1, folder=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["sweep.json"]


@pytest.mark.skipif(sys.platform == "win32", reason="signals of a terminal")
def test_ctrl_c_ends_processes_at_once_and_keeps_what_had_finished(tmp_path):
    code = ("import sys, fvkit as fv\nfrom tests import sweep_members as members\n"
            "fv.sweep(members.sleeps, {'x': [0.0, 0.1, 100.0, 101.0]}, workers=2, folder=sys.argv[1], batch=1)\n")
    process = subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stderr=subprocess.PIPE, text=True, start_new_session=True)
    limit = time.monotonic() + 20.0
    while len(list(tmp_path.glob("member-*"))) < 2 and time.monotonic() < limit:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    _, error = process.communicate(timeout=10)
    assert process.returncode != 0
    assert error.strip().splitlines()[-1] == "KeyboardInterrupt"
    assert error.count("Traceback") == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["member-000000.npz", "member-000001.npz", "sweep.json"]
