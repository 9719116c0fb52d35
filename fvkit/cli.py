"""The command ``fvkit``: parsing, exit codes and the sentences for mistakes. Commands come from plug-ins."""

import argparse
import errno
import os
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.metadata import entry_points
from typing import Any, TextIO

from fvkit import __version__
from fvkit.solution import SolveError

#: Exit codes.
SUCCESS, FAILED, MISTAKE, INTERRUPTED = 0, 1, 2, 130

#: What a full or broken disk says; that is no mistake in the input.
DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO)

Command = Callable[[argparse.Namespace], int]


class Parser(argparse.ArgumentParser):
    """Argument parser whose errors are one line on stderr."""

    def error(self, message: str) -> Any:
        self.exit(MISTAKE, f"{self.prog}: {message} (see {self.prog} --help)\n")


def add_command(commands: Any, name: str, run: Command, summary: str, example: str) -> Parser:
    """Add a command with an example in its help; ``run`` returns the exit code."""
    parser = commands.add_parser(name, help=summary, description=summary, epilog=f"example:\n  {example}",
                                 formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.set_defaults(run=run)
    return parser


def build_parser() -> Parser:
    """Return the parser with the commands of all installed plug-ins (entry points ``fvkit.commands``)."""
    parser = Parser(prog="fvkit", description="Finite volumes for hyperbolic systems: run scenes, compare solvers.",
                    epilog="example:\n  fvkit compare riemann", formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"fvkit {__version__}")
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True, parser_class=Parser)
    for plugin in sorted(entry_points(group="fvkit.commands"), key=lambda point: point.name):
        plugin.load()(commands)
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit code."""
    parser = build_parser()
    try:
        options = parser.parse_args(arguments)
    except SystemExit as end:
        return int(end.code or 0)
    try:
        with warnings.catch_warnings(), _termination_as_interrupt():
            warnings.showwarning = _warn
            return int(options.run(options))
    except KeyboardInterrupt:
        print("fvkit: interrupted", file=sys.stderr)
        return INTERRUPTED
    except SolveError as error:
        print(f"fvkit: {error}", file=sys.stderr)
        return FAILED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except (ValueError, TypeError, OSError) as error:
        said = "; ".join([str(error), *getattr(error, "__notes__", ())])
        print(f"fvkit: {' '.join(said.split())}", file=sys.stderr)
        return FAILED if getattr(error, "errno", None) in DISK else MISTAKE


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
    print(f"fvkit: warning: {' '.join(str(message).split())}", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
