"""Fuzz a reader: ``python -m tests.robust.fuzz_readers npz --seconds 60``, by random mutations, or with ``--engine atheris``
by those that coverage chooses.

Prints the number of executions and every finding: an exception that is neither ValueError nor OSError, or that does not name
the file, or a reading of more than 2 s. Exit code 1 where there is one. atheris ends the process by itself: its last line
"Done ... runs" has the number, and findings stand above it.
"""

import argparse
import sys
import tempfile
import time
import warnings
from pathlib import Path

from tests.robust.mutations import READERS, generator, inside, mutate, seeds

SLOW = 2.0


class Target:
    """One reader, its file and what was found."""

    def __init__(self, kind, folder):
        ending, self.reader = READERS[kind]
        self.path, self.executions, self.findings = Path(folder) / f"fuzzed{ending}", 0, []

    def __call__(self, data):
        self.path.write_bytes(data)
        self.executions += 1
        start = time.process_time()
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                self.reader(self.path)
        except (ValueError, OSError) as error:
            if self.path.name not in str(error) or "\n" in str(error):
                self.note(error)
        except Exception as error:  # the finding that is looked for
            self.note(error)
        if time.process_time() - start > SLOW:
            self.note("slow")

    def note(self, what):
        print(f"finding: {type(what).__name__}: {what}"[:300], flush=True)  # at once: atheris ends the process
        self.findings.append((f"{type(what).__name__}: {what}"[:200], self.path.read_bytes()))


def random_mutations(target, kind, data, seconds):
    """Mutate the valid file until the time is over."""
    end, seed = time.monotonic() + seconds, 0
    while time.monotonic() < end:
        chance = generator(seed)
        target((inside if kind in ("npz", "checkpoint") and seed % 2 else mutate)(data, chance, 1 + seed % 6))
        seed += 1


def with_atheris(target, folder, data, seconds):
    """Let atheris, which measures coverage, choose the mutations; it ends the process."""
    import atheris

    corpus = Path(folder) / "corpus"
    corpus.mkdir()
    (corpus / "valid").write_bytes(data)
    atheris.instrument_all()
    atheris.Setup([sys.argv[0], str(corpus), f"-max_total_time={seconds}", f"-max_len={2 * len(data)}"], target)
    atheris.Fuzz()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=READERS)
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--engine", choices=("random", "atheris"), default="random")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        data, target = seeds(folder)[options.kind], Target(options.kind, folder)
        if options.engine == "atheris":
            with_atheris(target, folder, data, options.seconds)
        else:
            random_mutations(target, options.kind, data, options.seconds)
        print(f"{options.kind}: {target.executions} random mutations, {len(target.findings)} findings")
        for what in sorted({text for text, _ in target.findings}):
            print(f"  {what}")
    return 1 if target.findings else 0


if __name__ == "__main__":
    sys.exit(main())
