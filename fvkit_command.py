"""Start of the command ``fvkit``, outside of the package: Ctrl-C ends it in a sentence while that is imported, too."""

import sys


def main() -> int:
    """Import and run the command line; return the exit code."""
    try:
        from fvkit.cli import main as run
    except KeyboardInterrupt:
        print("fvkit: interrupted", file=sys.stderr)
        return 130  # that of `fvkit.cli`, which is not there
    return run()
