"""Where fvkit runs: a compiler that is switched off, users without a home, consoles that cannot spell."""

import os
import subprocess
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest

from fvkit.backends.compiled import disk_cache, numba_kernel
from fvkit.cli import main

compiled = pytest.mark.skipif(find_spec("numba") is None, reason="needs the extra fast")
START = f"import sys; sys.path[:0] = {[entry for entry in sys.path if entry]!r}; "
SCENE = 'description = "ένα"\ninterval = [0.0, 1.0]\nt_end = 0.01\n[initial]\nh = 1.0\nphi = 0.5\n'


def python(code, *arguments, **environment):
    return subprocess.run([sys.executable, "-c", START + code, *arguments], capture_output=True, check=False,
                          env={**os.environ, **environment})


@compiled
@pytest.mark.parametrize(("switch", "backend"), [("1", "numpy"), (" 1", "numpy"), ("2", "numpy"), ("0", "numba"), ("", "numba")])
def test_auto_takes_numpy_where_the_compiler_is_switched_off(switch, backend):
    code = ("import fvkit as fv, fvkit_granular as gr\n"
            "print(fv.solve(gr.scene('dam-break').problem(gr.ShallowWater, 20)).stats.backend)")
    assert python(code, NUMBA_DISABLE_JIT=switch, FVKIT_BACKEND="auto").stdout.decode().strip() == backend


@compiled
def test_numba_and_threads_are_refused_where_the_compiler_is_switched_off():
    code = ("import fvkit as fv, fvkit_granular as gr\np = gr.scene('dam-break').problem(gr.ShallowWater, 20)\n"
            "for named in ({'backend': 'numba'}, {'threads': 2}):\n"
            "    try:\n        fv.solve(p, **named)\n    except ValueError as error:\n        print(error)\n")
    done = python(code, NUMBA_DISABLE_JIT="1", FVKIT_BACKEND="auto")
    first, second = done.stdout.decode().splitlines()
    assert first == ("`backend` is 'numba', which is switched off: unset NUMBA_DISABLE_JIT, or backend='numpy'")
    assert second.endswith("got 2 threads with NumPy: unset NUMBA_DISABLE_JIT")


@compiled
def test_a_compiler_that_a_file_switches_off_is_seen_once_numba_is_there(monkeypatch):
    import numba

    monkeypatch.setattr(numba.config, "DISABLE_JIT", 1)
    assert not numba_kernel.available()


def homeless(*_):
    raise RuntimeError("Could not determine home directory.")


@pytest.mark.parametrize(("platform", "chosen"), [("linux", None), ("darwin", None), ("win32", None), ("linux", "~nobody-there/x")])
def test_without_a_home_kernels_are_compiled_again_and_that_is_said(platform, chosen, monkeypatch, capsys):
    for name in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA", "FVKIT_CACHE"):
        monkeypatch.delenv(name, raising=False)
    if chosen is not None:
        monkeypatch.setenv("FVKIT_CACHE", chosen)
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr(Path, "home", homeless)
    with pytest.warns(RuntimeWarning, match="no home directory is known"):
        path, lasting = disk_cache.place("kernel_test", "x = 1\n")
    assert (path.parent.is_dir(), lasting) == (True, False)
    assert main(["cache"]) == 2
    assert "$FVKIT_CACHE is" in capsys.readouterr().err


@compiled
def test_a_run_without_a_home_is_a_run():
    code = ("import fvkit as fv, fvkit_granular as gr\n"
            "print(fv.solve(gr.scene('dam-break').problem(gr.ShallowWater, 20), backend='numba').status.name)")
    done = python(code, FVKIT_CACHE="~nobody-there/x")
    assert done.stdout.decode().strip() == "FINISHED", done.stderr
    assert b"RuntimeWarning: the cache of compiled kernels cannot be written" in done.stderr


def test_a_given_folder_needs_no_home(tmp_path, monkeypatch):
    monkeypatch.setattr(Path, "home", homeless)
    monkeypatch.setenv("FVKIT_CACHE", str(tmp_path))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert disk_cache.place("kernel_test", "x = 1\n")[1]
        monkeypatch.delenv("FVKIT_CACHE")
        monkeypatch.setattr(sys, "platform", "win32")
        monkeypatch.setenv("LOCALAPPDATA", str(tmp_path))
        assert disk_cache.folder() == tmp_path / "fvkit"


@pytest.mark.parametrize("command", [
    ["run", "λίμνη.toml", "--cells", "20"], ["run", "λίμνη.toml", "--cells", "20", "--out", "έξω", "--animate", "α.gif"],
    ["compare", "λίμνη.toml", "--models", "two-phase", "--riemann", "hll", "--cells", "10", "20", "--repeats", "1"],
    ["convergence", "λίμνη.toml", "--cells", "10", "20", "40"], ["advise", "λίμνη.toml"], ["scenes", "--show", "λίμνη.toml"],
    ["stress", "λίμνη.toml", "--backends", "numpy", "--workers", "1"], ["sweep", "σ.toml", "--workers", "1"]],
    ids=lambda command: " ".join(command[:1]))
@pytest.mark.parametrize("console", ["cp1252", "ascii"])
def test_a_console_that_cannot_spell_a_name_gets_a_question_mark(command, console, tmp_path):
    (tmp_path / "λίμνη.toml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "σ.toml").write_text('scene = "λίμνη.toml"\nmembers = 2\ncells = 20\n[parameters]\ng = [9.0, 10.0]\n', encoding="utf-8")
    done = python(f"import os; os.chdir({str(tmp_path)!r}); from fvkit.cli import main; sys.exit(main())", *command,
                  PYTHONIOENCODING=console)
    assert done.returncode == 0, done.stderr
    assert b"?" in done.stdout


@pytest.mark.parametrize("command", [["run", "όχι.toml"], ["run", "riemann", "--model", "νερό"], ["νερό"]])
def test_a_mistake_is_one_sentence_on_such_a_console_too(command):
    done = python("from fvkit.cli import main; sys.exit(main())", *command, PYTHONIOENCODING="ascii:strict")
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert done.stderr.startswith(b"fvkit: ")
