"""Mistakes on the command line: exit code 2, one line that starts with fvkit:, and every file as it was."""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest

import fvkit as fv
from fvkit.cli import build_parser, main
from tests.robust.cases_calls import PROBLEM, SOLUTION
from tests.robust.cases_commands import LINES, OPTIONS, PLACES

#: Characters of a line: a list of all scenes is the longest thing that is allowed.
LONGEST = 1500

CASES = [(*before, option, *((value,) if isinstance(value, str) else value)) for (_, option), (before, values) in OPTIONS.items() for value in values]
CASES += [(*before, value) for before, values in PLACES.values() for value in values]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with files of every kind that must stay as they are."""
    place = tmp_path_factory.mktemp("bad")
    (place / "FOLDER").mkdir()
    (place / "FOLDER.npz").mkdir()
    for name, content in {"FILE": b"precious", "binary.toml": b"\xff\xfe\x00\x01", "latin.toml": "name = 'é'".encode("latin-1"),
                          "broken.toml": b"name = ", "broken.npz": b"PK\x03\x04 no archive", "sweep.toml":
                          b'scene = "riemann"\nmembers = 2\ncells = 10\nbackend = "numpy"\n[parameters]\ngamma = [0.3, 0.6]\n'}.items():
        (place / name).write_bytes(content)
    fv.solve(PROBLEM, backend="numpy", checkpoint=fv.Checkpoint(place / "old.npz"))
    SOLUTION.save(place / "solution.npz")
    return place


def state(folder):
    """What is in a folder: {path: checksum}."""
    return {str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "folder"
            for path in sorted(folder.rglob("*"))}


def shorter(arguments):
    return " ".join(text if len(text) < 25 else f"{text[:10]}...{len(text)}" for text in arguments)


def check(code, out, err, words=()):
    assert code == 2, err
    assert out == ""
    assert len(err.splitlines()) == 1
    assert err.startswith("fvkit: ")
    assert len(err) < LONGEST
    for word in words:
        assert word in err


@pytest.mark.parametrize("arguments", CASES, ids=shorter)
def test_a_bad_value_is_one_line_and_nothing_changes(arguments, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before = state(folder)
    code = main(list(arguments))
    check(code, *capsys.readouterr())
    assert state(folder) == before


@pytest.mark.parametrize(("arguments", "words"), LINES, ids=lambda given: shorter(given))
def test_a_bad_line_names_what_is_wrong(arguments, words, folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    before = state(folder)
    code = main(list(arguments))
    check(code, *capsys.readouterr(), words)
    assert state(folder) == before


@pytest.mark.parametrize("arguments", [(), ("run", "rest", "--cells", "ten"), ("run", "rest", "--out", "FILE/x"), ("sweep", "latin.toml"),
                                       ("run", "--resume", "broken.npz"), ("compare", "riemannn")], ids=shorter)
def test_it_is_the_same_in_a_process_of_its_own(arguments, folder):
    before = state(folder)
    done = subprocess.run([sys.executable, "-m", "fvkit.cli", *arguments], cwd=folder, capture_output=True, text=True, timeout=120, check=False)
    check(done.returncode, done.stdout, done.stderr)
    assert "Traceback" not in done.stderr
    assert state(folder) == before


def test_every_option_of_every_command_is_in_the_table():
    (commands,) = (action for action in build_parser()._actions if isinstance(action, argparse._SubParsersAction))
    for command, parser in commands.choices.items():
        for action in parser._actions:
            if not isinstance(action, argparse._HelpAction):
                name = action.option_strings[0] if action.option_strings else str(action.metavar)
                assert (command, name) in {**OPTIONS, **PLACES}, f"{command} {name}"


# ---- a disk that is full ------------------------------------------------------------------------------------------------

LIMITED = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), int(sys.argv[1])))
sys.argv = sys.argv[1:]
"""
SAVE = LIMITED + """
import fvkit as fv
solution = fv.load("run.npz")
try:
    solution.save(sys.argv[1])
except (OSError, RuntimeError) as error:
    print(type(error).__name__)
"""


def limited(code, size, *arguments, cwd):
    return subprocess.run([sys.executable, "-c", code, str(size), *arguments], cwd=cwd, capture_output=True, text=True, timeout=120, check=False)


@pytest.fixture
def stored(tmp_path):
    """A folder with a solution of 2000 cells in files of both kinds."""
    fine = fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, 2000), lambda x: 1.0 + x[None], 0.001)
    solution = fv.solve(fine, backend="numpy")
    solution.save(tmp_path / "run.npz")
    if find_spec("h5netcdf"):
        solution.save(tmp_path / "run.nc")
    return tmp_path


@pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of files are for systems with fork")
@pytest.mark.parametrize("size", [0, 100, 20_000])
@pytest.mark.parametrize("name", ["run.npz", pytest.param("run.nc", marks=pytest.mark.skipif(not find_spec("h5netcdf"), reason="needs the extra io"))])
def test_a_full_disk_leaves_the_old_file_and_no_other(name, size, stored):
    before = state(stored)
    done = limited(SAVE, size, name, cwd=stored)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() in (["OSError"], ["RuntimeError"])
    assert state(stored) == before


@pytest.mark.skipif(not hasattr(os, "fork"), reason="limits of files are for systems with fork")
def test_a_command_on_a_full_disk_is_one_line_and_leaves_the_old_results(tmp_path):
    code = LIMITED + "from fvkit.cli import main\nsys.exit(main(sys.argv[1:]))"
    run = ("run", "rest", "--cells", "500", "--backend", "numpy", "--out", "here")
    first = limited(code, 10**9, *run, cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    before = state(tmp_path)
    done = limited(code, 5000, *run, cwd=tmp_path)
    check(done.returncode, done.stdout, done.stderr)
    assert state(tmp_path) == before


def test_the_device_that_is_always_full_is_refused(tmp_path):
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full")
    with open("/dev/full", "w") as full:
        done = subprocess.run([sys.executable, "-m", "fvkit.cli", "scenes"], stdout=full, stderr=subprocess.PIPE, text=True, timeout=120, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith("fvkit: ")
    assert "No space left" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_write_that_fails_half_way_leaves_the_old_file(stored, monkeypatch):
    before = state(stored)

    def half(file, arrays):
        file.write(b"half of it")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("fvkit.output.npz.fill", half)
    solution = fv.load(stored / "run.npz")
    with pytest.raises(OSError, match="No space left"):
        solution.save(stored / "run.npz")
    assert state(stored) == before


@pytest.mark.parametrize(("fails", "words"), [("fvkit.Solution.save", "its result is lost: with --checkpoint"),
                                              ("fvkit_granular.cli.run_results.save_all", "its result is kept in here/solution.npz")])
def test_a_run_says_what_of_it_stands_when_the_disk_is_full(fails, words, tmp_path, monkeypatch, capsys):
    def full(*arguments, **named):
        raise OSError(28, "No space left on device")

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(fails, full)
    assert main(["run", "rest", "--cells", "50", "--backend", "numpy", "--out", "here"]) == 2
    assert words in capsys.readouterr().err
    assert (tmp_path / "here" / "solution.npz").exists() == fails.endswith("_all")


def test_warnings_do_not_hide_mistakes(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check(main(["run", "rest", "--cells", "0"]), *capsys.readouterr(), ("`--cells`",))


def test_a_sweep_file_names_what_is_wrong_in_it(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    for text, words in SWEEPS:
        (folder / "mine.toml").write_text(text)
        check(main(["sweep", "mine.toml"]), *capsys.readouterr(), ("mine.toml", *words))
    (folder / "mine.toml").unlink()


HEAD, TAIL = 'scene = "riemann"\nbackend = "numpy"\ncells = 10\n', "[parameters]\ngamma = [0.3, 0.6]\n"
SWEEPS = [
    ("", ("scene",)), (HEAD, ("parameters",)), (TAIL, ("scene",)), (HEAD + "colour = 3\n" + TAIL, ("colour",)), ("scene = 3\n" + TAIL, ("scene", "3")),
    (HEAD + "model = 3\n" + TAIL, ("model", "3")), (HEAD.replace("10", '"ten"') + TAIL, ("cells", "'ten'")), (HEAD.replace("10", "0") + TAIL, ("cells", "0")),
    (HEAD.replace("10", "-5") + TAIL, ("cells", "-5")), (HEAD.replace("10", "nan") + TAIL, ("cells", "nan")), (HEAD + "members = 2.5\n" + TAIL, ("members", "2.5")),
    (HEAD + "members = 0\n" + TAIL, ("members", "0")), (HEAD + "seed = -1\n" + TAIL, ("seed", "-1")), (HEAD + "outputs = 3\n" + TAIL, ("3",)),
    (HEAD + 'outputs = ["max.g"]\n' + TAIL, ("max.g",)), (HEAD + "outputs = [3]\n" + TAIL, ("3",)), (HEAD + 'samples = "some"\n' + TAIL, ("samples", "some")),
    (HEAD + "scheme = 3\n" + TAIL, ("scheme", "3")), (HEAD + "scheme = {order = 5}\n" + TAIL, ("order", "5")), (HEAD + "scheme = {order = true}\n" + TAIL, ("order", "True")),
    (HEAD + 'scheme = {riemann = "roee"}\n' + TAIL, ("roee",)), (HEAD + "scheme = {riemann = 3}\n" + TAIL, ("riemann", "3")),
    (HEAD + "scheme = {limiter = {}}\n" + TAIL, ("limiter", "{}")), (HEAD + "scheme = {cfl = 0}\n" + TAIL, ("cfl", "0")), (HEAD + 'scheme = {cfl = "1"}\n' + TAIL, ("cfl", "'1'")),
    (HEAD + "parameters = 3\n", ("parameters", "3")), (HEAD + "[parameters]\n", ("parameters",)), (HEAD + "[parameters]\ngamma = 3\n", ("gamma", "3")),
    (HEAD + "[parameters]\ngamma = [0.6, 0.3]\n", ("gamma",)), (HEAD + '[parameters]\ngamma = ["a", "b"]\n', ("gamma", "'a'")), (HEAD + "[parameters]\ngamma = [nan, 1]\n", ("gamma", "nan")),
    (HEAD + "[parameters]\ngama = [0.3, 0.6]\n", ("gama", "gamma")), (HEAD + "[parameters]\ngamma = [3.0, 6.0]\n", ("gamma",)), (HEAD + "[parameters]\ngamma = []\n", ("gamma",)),
    (HEAD.replace('"numpy"', '"fortran"') + TAIL, ("backend", "fortran")), (HEAD.replace('"riemann"', '"nowhere.toml"') + TAIL, ("nowhere.toml",)),
    (HEAD + "members = 1" + 14 * "0" + "\n" + TAIL, ("members", "GB")), (HEAD + HEAD + TAIL, ("TOML",)), (HEAD + "x = " + 3000 * "[" + "\n" + TAIL, ("nested", )),
]


def test_the_number_of_cases():
    print(json.dumps({"command lines": len(CASES) + len(LINES), "sweep files": len(SWEEPS)}))
    assert len(CASES) + len(LINES) > 600
