"""The compiled backend: generated kernels under numba, cached on disk by their content."""

import os
import sys
import threading
import time
import types
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from fvkit.backends.compiled import calls, cube_roots, disk_cache, llvm, quotients, tile_bounds
from fvkit.backends.compiled.calls import Call, Move, address
from fvkit.backends.compiled.generator import generate
from fvkit.backends.compiled.loops import SPARE, TILE
from fvkit.backends.compiled.time_loop import ADDRESSES, LOOP
from fvkit.backends.kernel import Kernel
from fvkit.backends.layout import aligned
from fvkit.backends.march import March, Outcome
from fvkit.backends.step_length import EQUALISED, NEARLY_ONE, SHORTEST, step_length
from fvkit.problem.problem import Problem
from fvkit.schemes.program import STATE, TRANSPORT, Program
from fvkit.schemes.scheme import Parts, Scheme

#: Compiler options of every kernel. No fast-math: NaN and infinity keep their meaning, and `emit` decides what is contracted. No
#: reference counts: compiled code allocates no arrays.
OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "_nrt": False}

#: Seconds after which a compilation is announced.
ANNOUNCE_AFTER = 1.0

#: Environment variable by which debuggers and measures of coverage switch numba's compiler off.
SWITCH = "NUMBA_DISABLE_JIT"


def switched_off() -> bool:
    """Whether numba's compiler is switched off; does not import it."""
    loaded = sys.modules.get("numba")
    return bool(os.environ.get(SWITCH, "").strip(" 0")) or (loaded is not None and bool(loaded.config.DISABLE_JIT))


def available() -> bool:
    """Whether numba is installed and compiles; does not import it."""
    return find_spec("numba") is not None and not switched_off()


class Scratch(NamedTuple):
    """Working arrays of one thread.

    Parameters
    ----------
    buffer : rows of the fields of a tile.
    speeds : largest speeds.
    ends, fluxes : (3, masses) mass fluxes through both ends of a tile and of the grid; behind them what sources bring of each
        mass, summed over the cells.
    found : (2, 4) faces that lost hyperbolicity: their number, the first, those in films, and the depth of the deepest; of the
        first sweep, and of a later one.
    """

    buffer: np.ndarray
    speeds: np.ndarray
    ends: np.ndarray
    fluxes: np.ndarray
    found: np.ndarray


class NumbaKernel(Kernel):
    """Runs steps in compiled code; new parameter values never recompile."""

    name: ClassVar[str] = "numba"

    def __init__(self, problem: Problem, scheme: Scheme, parts: Parts) -> None:
        super().__init__(problem, scheme, parts)
        source = generate(problem, scheme, parts, self.plan, self.source_plan, self._varies())
        started = time.perf_counter()
        import numba

        kinds, arguments = signatures(numba)
        self.module = module_of("kernel", source.text, source.blocks, {name: kind for name, kind in kinds.items()
                                                                       if f"def {name}(" in source.text})
        self.at = np.array([address(getattr(self.module, name, self.module.tile)) for name in ADDRESSES])
        self.loop = loop_of(scheme.program, kinds, arguments)
        self.compile_seconds = time.perf_counter() - started
        self._rows = source.rows
        self._prepare(problem, parts)

    def _varies(self) -> list[bool]:
        """Which given functions are not zero everywhere, at all times."""
        first = len(self.problem.model.aux)
        moving = [False] * first + [not field.steady for field in self.problem.fields for _ in range(field.size)]
        moving += [False] * (len(self.aux) - len(moving))
        return [bool(moves or row.any() or edges.any())
                for moves, row, edges in zip(moving, self.aux, self.aux_edges, strict=True)]

    def _prepare(self, problem: Problem, parts: Parts) -> None:
        """Lay out the numbers that compiled code takes."""
        every = (*parts.every, *problem.ends)
        self.parameters = np.array([value for part in every for value in part.parameters()] + [parts.dx], dtype=float)
        program, self._scratch = self.scheme.program, self.scratch()
        self.registers = np.zeros((program.registers, *self.padded(problem.q0).shape))
        self.sweeps, self.weights = _tables(program)
        self._steady = self.boundary_values(*[problem.t_start] * len(program.sweeps))

    def scratch(self) -> Scratch:
        """Return the working arrays of one thread."""
        row, ends = TILE + SPARE, (3, max(len(self.mass_rows), 1))
        return Scratch(aligned(self._rows * row), aligned(row), np.zeros(ends), np.zeros(ends),
                       np.zeros((2, 4), dtype=np.int64))

    def boundary_values(self, *times: float) -> np.ndarray:
        """What the boundaries give to their ghosts, (times, sides, values)."""
        given = [values for t in times for values in self.ghost_values(t)]
        result = np.zeros((len(given), max(1, *(len(values) for values in given))))
        for row, values in zip(result, given, strict=True):
            row[:len(values)] = values
        return result.reshape(len(times), -1, result.shape[1])

    def advance(self, march: March, target: float, max_steps: int) -> Outcome:
        if self.steady:
            return self._advance(march, target, max_steps, march.retries, self._steady)
        for _ in range(max_steps):
            outcome = self._step(march, target)
            if outcome is not Outcome.PAUSED:
                return outcome
        return Outcome.PAUSED

    def _step(self, march: March, target: float) -> Outcome:
        """One accepted step; boundaries and fields of sources are evaluated again for each length that is tried."""
        outcome = Outcome.NO_STEP
        for _ in range(march.retries):
            dt, _ = step_length(march.t, march.dt, target)
            if not self.steady_fields:
                self.set_fields(march.t + 0.5 * dt)
            outcome = self._advance(march, target, 1, 1, self.boundary_values(*self.times(march.t, dt)))
            if outcome is not Outcome.NO_STEP:
                break
        return outcome

    def times(self, t: float, dt: float) -> list[float]:
        """Times at which boundary values are evaluated in a step of length dt from t."""
        return [t + share * dt for share in self.scheme.program.times]

    def _advance(self, march: March, target: float, max_steps: int, retries: int, values: np.ndarray) -> Outcome:
        scheme, splitting = self.scheme, self.scheme.splitting
        outcome = self.loop.advance(
            self.at, march.now, march.next, self.aux, self.aux_edges, self.cells, self.problem.grid.dx, target, max_steps,
            retries, *march.bounds, scheme.cfl, scheme.cfl_max, splitting.before, splitting.after, march.stop_when_lost,
            self.parameters, values, self.registers, self.sweeps, self.weights, scheme.program.last, *self._scratch,
            march.masses, march.real, march.count)
        return Outcome(outcome)


def _tables(steps: Program) -> tuple[np.ndarray, np.ndarray]:
    """A program as the arrays that the time loop reads."""
    longest = max(len(sweep.terms) for sweep in steps.sweeps)
    sweeps = np.zeros((len(steps.sweeps), 5 + 2 * longest), dtype=np.int64)
    weights = np.zeros((len(steps.sweeps), 2 + longest))
    for row, numbers, sweep in zip(sweeps, weights, steps.sweeps, strict=True):
        target = -1 if sweep.target is None else sweep.target
        row[:5] = sweep.implicit, sweep.state, sweep.rate, target, len(sweep.terms)
        numbers[:2] = sweep.share, sweep.flux
        for k, term in enumerate(sweep.terms):
            row[5 + 2 * k:7 + 2 * k] = term.register, term.kind
            numbers[2 + k] = term.weight
    return sweeps, weights


def loop_of(program: Program, kinds: dict[str, Any], arguments: Any) -> Any:
    """Return the compiled module of the time loop, with or without registers."""
    constants = {"TILE": TILE, "SPARE": SPARE, "EQUALISED": EQUALISED, "SHORTEST": SHORTEST, "NEARLY_ONE": NEARLY_ONE,
                 "STATE": STATE, "TRANSPORT": TRANSPORT, "REGISTERS": program.registers > 0,
                 **{item.name: int(item) for item in Outcome}}
    lines = "\n".join(f"{name} = {value}" for name, value in constants.items())
    calls = tuple(Call(name, kind) for name, kind in kinds.items())
    return module_of("loop", f"from math import ceil, inf\n\n{lines}\n\n\n{LOOP}", calls, {"advance": arguments})


#: Modules of this process, by the name that their content gives them; one thread at a time makes one.
_loaded: dict[str, Any] = {}
_making = threading.Lock()


def module_of(prefix: str, text: str, blocks: tuple[Any, ...], entries: dict[str, Any]) -> Any:
    """Return the compiled module of a text and its blocks, from memory, disk or the compiler.

    ``entries`` are the types of each function that is compiled at once.
    """
    import numba

    writers = (llvm, calls, quotients, cube_roots, tile_bounds)
    compiler = [Path(str(module.__file__)).read_text(encoding="utf-8") for module in writers]
    content = (text, *[block.text() for block in blocks], *compiler, repr(sorted(map(str, OPTIONS.items()))))
    name = f"{prefix}_{disk_cache.key(*content, numba.__version__, np.__version__, sys.version)}"
    with _making:
        if name not in _loaded:
            _loaded[name] = _made(name, text, blocks, numba, entries)
    return _loaded[name]


def _made(name: str, text: str, blocks: tuple[Any, ...], numba: Any, entries: dict[str, Any]) -> Any:
    """Make a module."""
    path, lasting = disk_cache.place(name, text)
    module = types.ModuleType(f"fvkit_{name}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    space = module.__dict__
    exec(compile(text, str(path), "exec"), space)
    space |= {block.name: block.compiled() for block in (llvm.wide(), Move(), *tile_bounds.RUNNING, *blocks)}
    said = f"fvkit: compiling a kernel for this combination of parts, once; kept in {path.parent}"
    timer = threading.Timer(ANNOUNCE_AFTER, print, (said,), {"file": sys.stderr, "flush": True})
    timer.daemon = True
    timer.start()
    try:
        _compile(module, numba, lasting, entries)
    finally:
        timer.cancel()
    return module


def signatures(numba: Any) -> tuple[dict[str, Any], tuple[Any, ...]]:
    """Return the types of the functions of a kernel, and those of the arguments of ``advance``."""
    real, whole = numba.float64, numba.int64
    cubes, rows, row, counts = real[:, :, ::1], real[:, ::1], real[::1], whole[::1]
    tile = whole(rows, rows, rows, rows, *(4 * [whole]), real, real, real, row, rows, row, row, rows, counts)
    end = whole(rows, rows, whole, whole, real, real, row, rows)
    kinds = {"tile": tile, "source_tile": tile, "ghosts": numba.void(rows, rows, whole, real, row, rows),
             "extend": numba.void(rows, whole), "opening": end, "finish": end}

    return kinds, (counts, rows, rows, rows, rows, whole, real, real, whole, whole, *(6 * [real]), numba.boolean, row, cubes,
                   cubes, whole[:, ::1], rows, whole, row, row, rows, rows, whole[:, ::1], rows, row, counts)


def _compile(module: Any, numba: Any, lasting: bool, entries: dict[str, Any]) -> None:
    """Compile the functions that are called, or load them; without the disk where that fails for the disk's sake."""
    try:
        _decorate(module, numba, lasting)
        for name, signature in entries.items():
            getattr(module, name).compile(signature)
    except Exception as error:  # a full disk, or a damaged file, of which unpickling may say anything
        if not lasting:
            raise
        _decorate(module, numba, lasting=False)
        for name, signature in entries.items():
            getattr(module, name).compile(signature)
        path = Path(module.__file__)
        if isinstance(error, OSError):
            cause = f"could not be kept on disk ({error}): it is compiled again in every process"
        else:
            cause = f"could not be read from {path.parent} ({type(error).__name__}: {error}): its files were removed"
            disk_cache.forget(path.stem)
        warnings.warn(f"a compiled kernel {cause}.", RuntimeWarning, stacklevel=6)


def _decorate(module: Any, numba: Any, lasting: bool) -> None:
    """Let numba take the functions of a module, and keep them on disk. What is called by address has no wrapper for Python."""
    space, direct = module.__dict__, Path(module.__file__).name.startswith("kernel")
    for name, item in list(space.items()):
        function = getattr(item, "py_func", item)
        if getattr(function, "__module__", None) == module.__name__ and isinstance(function, types.FunctionType):
            space[name] = numba.njit(cache=lasting, no_cfunc_wrapper=True, no_cpython_wrapper=direct, **OPTIONS)(function)
