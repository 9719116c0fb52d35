"""The options of commands that choose schemes: method, Riemann solver, limiter, order, reconstruction, integrator."""

import argparse
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from fvkit import MethodOfLines, Scheme, WavePropagation, validation
from fvkit.backends import BACKENDS
from fvkit.output.figures import FORMATS
from fvkit.schemes.registry import METHODS
from fvkit_granular.studies.scene_run import NAMED

#: The methods by their names.
WAVES, LINES = METHODS

#: The options that belong to a method, and the parts where an option names none.
BELONGS = {"limiter": WAVES, "order": WAVES, "reconstruction": LINES, "integrator": LINES}
DEFAULTS = {"riemann": "relaxation", "limiter": "mc", "reconstruction": "mp5", "integrator": "ssprk104"}

_RIEMANN_ALL = "all for the first model, relaxation for the others; relaxation alone beside method-of-lines"


def checked(kind: type, check: Callable[..., Any], **rules: Any) -> Callable[[str], Any]:
    """Return a ``type`` of argparse: a text as an int, a float or a str, then through a check of `fvkit.validation`."""
    def parse(text: str) -> Any:
        value = kind(text)
        try:
            return check(value, "value", **rules)
        except (ValueError, TypeError) as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    parse.__name__ = kind.__name__  # argparse shows this name in its message
    return parse


def named(known: Iterable[str]) -> Callable[[str], Any]:
    """Return a ``type`` of argparse: one of the names, or its value in a mapping."""
    check = checked(str, validation.choice, known=known)
    return (lambda text: known[check(text)]) if isinstance(known, Mapping) else check


def one_of(parser: argparse.ArgumentParser, option: str, known: Iterable[str], default: str, what: str = "") -> None:
    """Add an option that takes one of the names; ``what`` precedes them in its help."""
    parser.add_argument(option, type=named(known), default=default, help=f"{what}one of {', '.join(known)} (default {default})")


#: Whole numbers from 1 on, as a ``type`` of argparse.
COUNT = checked(int, validation.whole, at_least=1)


def cells_of(text: str) -> Any:
    """Return a number of cells, or a pair, from "80" or "80x40", as a ``type`` of argparse."""
    try:
        counts = [int(part) for part in text.split("x")]
    except ValueError:
        counts = []
    if len(counts) not in (1, 2):
        raise argparse.ArgumentTypeError("`value` must be a whole number, or NXxNY for a scene with two axes, such as 80x40, got "
                                         f"{validation.shown(text)}")
    return counts[0] if len(counts) == 1 else tuple(counts)


def place_of(text: str) -> Any:
    """Return a place x, or a pair, from "12.5" or "12.5,40", as a ``type`` of argparse."""
    try:
        places = tuple(validation.real(float(part), "value") for part in text.split(","))
    except ValueError:
        places = ()
    if len(places) not in (1, 2):
        raise argparse.ArgumentTypeError("`value` must be places x, or X,Y in a scene with two axes, such as 12.5,40, got "
                                         f"{validation.shown(text)}")
    return places[0] if len(places) == 1 else places


def add_scheme_options(parser: argparse.ArgumentParser, several: bool) -> None:
    """Add the options; ``several`` lets each take more than one name."""
    many: dict[str, Any] = {"nargs": "+"} if several else {}
    said = "any of" if several else "one of"
    parser.add_argument("--method", metavar="S", **many,
                        help=f"{said} {', '.join(METHODS)} (default {WAVES}; {LINES} where --reconstruction or --integrator is "
                             "given)")
    parser.add_argument("--riemann", metavar="R", **many,
                        help=f"{said} {', '.join(NAMED['riemann'])} (default: {_RIEMANN_ALL if several else 'relaxation'})")
    parser.add_argument("--limiter", metavar="L", **many, help=f"of {WAVES}: {said} {', '.join(NAMED['limiter'])} (default mc)")
    parser.add_argument("--order", type=int, metavar="P", **many,
                        help=f"of {WAVES}: 1{', 2 or both' if several else ' or 2'} (default 2)")
    for name, letter in (("reconstruction", "C"), ("integrator", "T")):
        parser.add_argument(f"--{name}", metavar=letter, **many,
                            help=f"of {LINES}: {said} {', '.join(NAMED[name])} (default {DEFAULTS[name]})")
    parser.add_argument("--cfl", type=float, help=f"target Courant number (default 0.9, {LINES}: that of the integrator)")


def parts_of(options: argparse.Namespace, name: str) -> list[Any]:
    """Return the parts of schemes that an option names, or raise with the list and the nearest match."""
    given = _names(getattr(options, name)) or [DEFAULTS[name]]
    return [NAMED[name][validation.choice(one, f"--{name}", NAMED[name])]() for one in given]


def methods_of(options: argparse.Namespace) -> list[str]:
    """Return the names of the requested methods; options of other methods are an error."""
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
    solvers, limiters, reconstructions, integrators = (parts_of(options, name) for name in DEFAULTS)
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
    """Add the options of the backend, of the format of pictures and of the folder for the results."""
    one_of(parser, "--backend", BACKENDS, "auto")
    one_of(parser, "--format", FORMATS, FORMATS[0], "format of pictures, ")
    parser.add_argument("--out", type=Path, help=f"folder for the results (default {folder})")


def results_folder(options: argparse.Namespace, command: str, name: str) -> Path:
    """The folder of the results."""
    return options.out or Path(f"fvkit-{command}-{name}")
