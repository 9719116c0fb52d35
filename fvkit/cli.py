"""The command ``fvkit``: parsing, exit codes, error messages. Commands come from plug-ins."""

import argparse
import os
import re
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from importlib.metadata import entry_points
from io import TextIOWrapper
from typing import Any, TextIO

from fvkit import __version__
from fvkit.backends.compiled import disk_cache
from fvkit.output.citation import bibtex
from fvkit.output.status import SolveError

#: Exit codes.
SUCCESS, FAILED, MISTAKE, INTERRUPTED = 0, 1, 2, 130

#: Characters of a message.
LONGEST = 1200

#: Arguments of the library that an option of another name gives.
ALIASES = {"cells": ("num_cells",), "out": ("folder",), "stop_at_rest": ("speed",)}

Command = Callable[[argparse.Namespace], int]


class Parser(argparse.ArgumentParser):
    """Argument parser whose errors are one line on stderr; ``spelled`` has each option by the name that Python code gives it."""

    def __init__(self, **given: Any) -> None:
        self.spelled: dict[str, str] = {}
        super().__init__(**given)

    def add_argument(self, *names: Any, **given: Any) -> argparse.Action:
        """Add an argument, and note how an option is spelled."""
        action = super().add_argument(*names, **given)
        if action.option_strings:
            self.spelled |= dict.fromkeys((action.dest, *ALIASES.get(action.dest, ())), action.option_strings[-1])
        return action

    def error(self, message: str) -> Any:
        _say(re.sub(r"^argument (\S+): `value`", r"`\1`", message), f" (see {self.prog} --help)")
        self.exit(MISTAKE)


def add_command(commands: Any, name: str, run: Command, summary: str, example: str) -> Parser:
    """Add a command with an example in its help; ``run`` returns the exit code."""
    parser = commands.add_parser(name, help=summary, description=summary, epilog=f"example:\n  {example}",
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(run=run, parser=parser)
    return parser


def build_parser() -> Parser:
    """Return the parser with the commands of all installed plug-ins (entry points ``fvkit.commands``)."""
    parser = Parser(prog="fvkit", description="Finite volumes for hyperbolic systems: run scenes, compare models and solvers.",
                    epilog="example:\n  fvkit compare riemann", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"fvkit {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True, parser_class=Parser)
    for plugin in sorted(entry_points(group="fvkit.commands"), key=lambda point: point.name):
        plugin.load()(commands)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")  # a name that the console cannot spell must not cost the result
    spelled: dict[str, str] = {}
    try:
        options, unknown = build_parser().parse_known_args(arguments)
        spelled = options.parser.spelled
        if unknown:
            options.parser.error(f"unrecognized arguments: {' '.join(unknown)}")
        with warnings.catch_warnings(), _termination_as_interrupt():
            warnings.showwarning = _warn
            return int(options.run(options))
    except SystemExit as end:
        return int(end.code or 0)
    except KeyboardInterrupt:
        _say("interrupted")
        return INTERRUPTED
    except SolveError as error:
        _say(str(error))
        return FAILED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except MemoryError as error:
        _say(f"not enough memory: {str(error) or 'take fewer cells or outputs'}")
        return MISTAKE
    except FileNotFoundError as error:
        _say(str(error) if error.filename is None else f"there is no file {error.filename}")
        return MISTAKE
    except (ValueError, TypeError, OSError) as error:
        _say("; ".join([_as_typed(str(error), spelled), *getattr(error, "__notes__", ())]))
        return MISTAKE


def _say(message: str, end: str = "") -> None:
    """Write one line on stderr, cut where a value in it is too long to be read."""
    line = " ".join(message.split())
    print(f"fvkit: {line if len(line) <= LONGEST else line[:LONGEST] + '...'}{end}", file=sys.stderr)


def _as_typed(message: str, spelled: Mapping[str, str]) -> str:
    """Return a message with the names of options in place of those of arguments: `--cells` for `num_cells`."""
    first = re.match(r"`(\w+)(\[\d+\])?`", message)  # messages about a file begin with its name: what they name are keys
    if first is None or first[1] not in spelled:
        return message
    return re.sub(r"`(\w+)", lambda found: f"`{spelled.get(found[1], found[1])}", message)


def progress_line() -> Callable[[str], None] | None:
    """A function that shows one changing line on a terminal; None where stderr is none."""
    if not sys.stderr.isatty():
        return None
    return lambda line: print(f"\r\033[K{line}", end="", file=sys.stderr, flush=True)


def done_so_far(study: Callable[..., Any], tell: Callable[[str], None] | None = None) -> tuple[Any, bool]:
    """Return the result of a study, and whether Ctrl-C ended it: then the result is what was done so far.

    Where there is a `progress_line`, the study gets it as ``progress``, and the line is empty at the end.
    """
    try:
        return study() if tell is None else study(progress=tell), False
    except KeyboardInterrupt as error:
        found = getattr(error, "result", None)
        if found is None:
            raise
        _say("interrupted: what follows is what was done so far")
        return found, True
    finally:
        if tell is not None:
            tell("")


@contextmanager
def _termination_as_interrupt() -> Iterator[None]:
    """Let SIGTERM, which batch systems send before they kill, do what Ctrl-C does: checkpoint, partial result, exit code 130."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _warn(message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
          line: str | None = None) -> None:
    """Show a warning as one line, as mistakes are."""
    _say(f"warning: {message}")


def register(commands: Any) -> None:
    """Add the commands to the parser of ``fvkit``."""
    parser = add_command(commands, "cache", _cache, "show or clear the cache of compiled kernels",
                         "fvkit cache --clear")
    parser.add_argument("--clear", action="store_true", help="remove all compiled kernels")
    add_command(commands, "cite", _cite, "print what to cite for results, as BibTeX", "fvkit cite >> references.bib")


def _cache(options: argparse.Namespace) -> int:
    found = disk_cache.clear() if options.clear else disk_cache.contents()
    print(f"{found.folder}: {found.kernels} kernels, {found.size / 1e6:.1f} MB{' removed' if options.clear else ''}"
          f" (set {disk_cache.VARIABLE} for another folder)")
    return SUCCESS


def _cite(options: argparse.Namespace) -> int:
    print(bibtex(__version__))
    return SUCCESS


if __name__ == "__main__":
    sys.exit(main())
