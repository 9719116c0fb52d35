"""The options of commands that choose schemes: method, Riemann solver, limiter, order, reconstruction, integrator."""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from fvkit import MethodOfLines, Scheme, WavePropagation, validation
from fvkit.backends import BACKENDS
from fvkit.schemes.registry import INTEGRATORS, LIMITERS, METHODS, RECONSTRUCTIONS
from fvkit_granular.models.registry import RIEMANN

#: The methods by their names.
WAVES, LINES = METHODS

#: The options that belong to a method.
BELONGS = {"limiter": WAVES, "order": WAVES, "reconstruction": LINES, "integrator": LINES}

_RIEMANN_ALL = "all for the first model, relaxation for the others; relaxation alone beside method-of-lines"


def add_scheme_options(parser: argparse.ArgumentParser, several: bool) -> None:
    """Add the options; ``several`` lets each take more than one name."""
    many: dict[str, Any] = {"nargs": "+"} if several else {}
    said = "any of" if several else "one of"
    parser.add_argument("--method", metavar="S", **many,
                        help=f"{said} {', '.join(METHODS)} (default {WAVES}; {LINES} where --reconstruction or --integrator is "
                             "given)")
    parser.add_argument("--riemann", metavar="R", **many,
                        help=f"{said} {', '.join(RIEMANN)} (default: {_RIEMANN_ALL if several else 'relaxation'})")
    parser.add_argument("--limiter", metavar="L", **many, help=f"of {WAVES}: {said} {', '.join(LIMITERS)} (default mc)")
    parser.add_argument("--order", type=int, metavar="P", **many,
                        help=f"of {WAVES}: 1{', 2 or both' if several else ' or 2'} (default 2)")
    parser.add_argument("--reconstruction", metavar="C", **many,
                        help=f"of {LINES}: {said} {', '.join(RECONSTRUCTIONS)} (default mp5)")
    parser.add_argument("--integrator", metavar="T", **many,
                        help=f"of {LINES}: {said} {', '.join(INTEGRATORS)} (default ssprk104)")
    parser.add_argument("--cfl", type=float, help=f"target Courant number (default 0.9, {LINES}: that of the integrator)")


def pick(names: Sequence[str], argument: str, known: Mapping[str, type]) -> list[Any]:
    """Return what the names of an argument stand for, or raise with the list and the nearest match."""
    return [known[validation.choice(name, argument, known)] for name in names]


def methods_of(options: argparse.Namespace) -> list[str]:
    """Return the names of the methods that are asked for; options of a method that is not are a mistake."""
    given = _names(options.method)
    for name in given:
        validation.choice(name, "--method", METHODS)
    for option, method in BELONGS.items():
        if given and getattr(options, option) and method not in given:
            raise ValueError(f"`--{option}` belongs to {method}: add it to --method, got {', '.join(given)}")
    if given:
        return given
    asked = [method for option, method in BELONGS.items() if getattr(options, option)]
    return [method for method in METHODS if method in asked] or [WAVES]


def schemes_of(options: argparse.Namespace) -> list[Scheme]:
    """Return every scheme that the options name, with Relaxation where they name no Riemann solver."""
    solvers = [kind() for kind in pick(_names(options.riemann) or ["relaxation"], "--riemann", RIEMANN)]
    limiters = [kind() for kind in pick(_names(options.limiter) or ["mc"], "--limiter", LIMITERS)]
    reconstructions = [kind() for kind in pick(_names(options.reconstruction) or ["mp5"], "--reconstruction", RECONSTRUCTIONS)]
    integrators = [kind() for kind in pick(_names(options.integrator) or ["ssprk104"], "--integrator", INTEGRATORS)]
    orders, cfl = _names(options.order) or [2], options.cfl
    result: list[Scheme] = []
    for solver in solvers:
        for method in methods_of(options):
            if method == WAVES:
                result += [WavePropagation(solver, limiter, order, 0.9 if cfl is None else cfl)
                           for limiter in limiters for order in orders]
            else:
                result += [MethodOfLines(solver, reconstruction, integrator, cfl)
                           for reconstruction in reconstructions for integrator in integrators]
    return result


def scheme_of(options: argparse.Namespace) -> Scheme:
    """Return the one scheme that the options name; options of both methods, or several names of one option, are a mistake."""
    if len(methods_of(options)) > 1 and not options.method:
        mine, other = (next(option for option, owner in BELONGS.items() if owner == method and getattr(options, option))
                       for method in (WAVES, LINES))
        raise ValueError(f"`--{mine}` belongs to {WAVES} and `--{other}` to {LINES}: a run has one method, leave one of them out")
    found = schemes_of(options)
    if len(found) > 1:
        raise ValueError(f"one scheme is needed, got names for {len(found)}: give one name for each option")
    return found[0]


def _names(value: Any) -> list[Any]:
    """The values of an option, in a list."""
    if value is None:
        return []
    return list(value) if isinstance(value, (list, tuple)) else [value]


def common_options(parser: argparse.ArgumentParser, folder: str) -> None:
    parser.add_argument("--backend", default="auto", help=f"one of {', '.join(BACKENDS)} (default auto)")
    parser.add_argument("--out", type=Path, help=f"folder for the results (default {folder})")


def results_folder(options: argparse.Namespace, command: str, name: str) -> Path:
    """The folder of the results."""
    return options.out or Path(f"fvkit-{command}-{name}")


def teller() -> Callable[[str], None] | None:
    """A function that shows one changing line on a terminal; None where stderr is none."""
    if not sys.stderr.isatty():
        return None
    return lambda line: print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)
