"""The commands that need no plug-in: ``fvkit cache``, ``fvkit cite``."""

import argparse
from typing import Any

from fvkit import __version__
from fvkit.backends import cache
from fvkit.citation import bibtex
from fvkit.cli import SUCCESS, add_command


def register(commands: Any) -> None:
    """Add the commands to the parser of ``fvkit``."""
    parser = add_command(commands, "cache", _cache, "show or clear the compiled kernels that are kept on disk",
                         "fvkit cache --clear")
    parser.add_argument("--clear", action="store_true", help="remove them")
    add_command(commands, "cite", _cite, "print what to cite for results, as BibTeX", "fvkit cite >> references.bib")


def _cache(options: argparse.Namespace) -> int:
    found = cache.clear() if options.clear else cache.contents()
    print(f"{found.folder}: {found.kernels} kernels, {found.size / 1e6:.1f} MB{' removed' if options.clear else ''}"
          f" (set {cache.VARIABLE} for another folder)")
    return SUCCESS


def _cite(options: argparse.Namespace) -> int:
    print(bibtex(__version__))
    return SUCCESS
