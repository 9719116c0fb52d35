"""Mutation testing of the numerical core: ``python -m tests.mutation`` from the top of a checkout, with cosmic-ray installed.

Mutants are drawn at random from each group (`groups.py`), each is written into a copy of the tree, and the tests of its module are
run until one fails. A mutant that no test can even import says nothing and is counted apart.
"""

import argparse
import difflib
import json
import sys
import tempfile
import time
from pathlib import Path

from tests.mutation.faults import FAULTS
from tests.mutation.groups import GROUPS
from tests.mutation.mutants import Mutant, mutated, sample
from tests.mutation.running import FAILED, PASSED, STOPPED, copy_of, prepared, run

TOP = Path(__file__).parents[2]


def baseline(root: Path, groups: list[str]) -> dict[str, float]:
    """Return the seconds of each test of the groups that is short, all of which must pass as long as nothing is changed."""
    files = tuple(dict.fromkeys(file for group in groups for tests in GROUPS[group].values() for file in tests))
    seconds: dict[str, float] = {}
    for file in files:
        code, durations, failed = run(root, (file,), patience=900.0)
        if code != PASSED:
            raise SystemExit(f"{file}: without any change these tests fail: {', '.join(failed) or code}")
        seconds |= durations
        print(f"  {file}: {len(durations)} short tests, {sum(durations.values()):.1f} s", flush=True)
    return seconds


def verdict(root: Path, module: str, changed: str, tests: tuple[str, ...], known: dict[str, float]) -> tuple[str, str]:
    """Run tests with a changed module; return what became of it and, of the first test that failed, the name."""
    path = root / module
    source = path.read_text(encoding="utf-8")
    path.write_text(changed, encoding="utf-8")
    try:
        code, _, failed = run(root, tests, known)
    finally:
        path.write_text(source, encoding="utf-8")
    return {PASSED: "survived", FAILED: "killed", STOPPED: "stopped"}.get(code, "broken"), failed[0] if failed else ""


def tests_of(module: str) -> tuple[str, ...]:
    """Return the test files of a module."""
    return next(modules[module] for modules in GROUPS.values() if module in modules)


def faults(root: Path) -> int:
    """Run every fault of `FAULTS` against its tests, which pass without it; return the exit code."""
    files = sorted({fault.tests for fault in FAULTS})
    known: dict[str, float] = {}
    for file in files:
        code, durations, failed = run(root, (file,))
        if code != PASSED:
            raise SystemExit(f"{file}: without any change these tests fail: {', '.join(failed) or code}")
        known |= durations
    missed = 0
    for fault in FAULTS:
        source = (root / fault.module).read_text(encoding="utf-8")
        if source.count(fault.old) != 1:
            raise SystemExit(f"tests/mutation/faults.py: `{fault.old}` stands {source.count(fault.old)} times in {fault.module}, once is wanted")
        outcome, test = verdict(root, fault.module, source.replace(fault.old, fault.new), (fault.tests,), known)
        print(f"{outcome:9s}{fault.module}: {fault.old} -> {fault.new}  {test}", flush=True)
        missed += outcome != "killed"
    print(f"{len(FAULTS) - missed} of {len(FAULTS)} mutants killed")
    return int(missed > 0)


def difference(root: Path, mutant: Mutant) -> str:
    """Return the changed lines, and their numbers."""
    old = (root / mutant.module).read_text(encoding="utf-8").splitlines()
    new = (mutated(root, mutant) or "").splitlines()
    return "\n".join(line for line in difflib.unified_diff(old, new, lineterm="", n=0) if not line.startswith(("---", "+++")))


def table(results: list[dict[str, str]], total: dict[str, int]) -> str:
    """Return the shares by group as a table; a mutant that was stopped is not killed, one that is broken says nothing."""
    lines = ["| group | mutants | drawn | killed | survived | stopped | killed share | broken |", "|---|---|---|---|---|---|---|---|"]
    for group, count in [*total.items(), ("all", sum(total.values()))]:
        mine = [item["verdict"] for item in results if group in (item["group"], "all")]
        broken, survived, stopped = (mine.count(word) for word in ("broken", "survived", "stopped"))
        counted, killed = len(mine) - broken, mine.count("killed")
        share = f"{100 * killed / counted:.0f} %" if counted else "none"
        lines.append(f"| {group} | {count} | {len(mine)} | {killed} | {survived} | {stopped} | {share} | {broken} |")
    return "\n".join(lines)


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m tests.mutation", description="Mutation testing of the numerical core.")
    parser.add_argument("--group", action="append", choices=GROUPS, help="only this group (may be repeated)")
    parser.add_argument("--count", type=int, default=40, help="mutants drawn from each group (default 40)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    parser.add_argument("--again", type=Path, help="results of an earlier run: only its survivors, and what was stopped")
    parser.add_argument("--out", type=Path, help="file for the results, JSON lines")
    parser.add_argument("--small", action="store_true", help="only the faults of tests/mutation/faults.py: needs no cosmic-ray")
    parser.add_argument("--durations", type=Path, help="file that keeps the seconds of each test between runs")
    given = parser.parse_args()
    groups = given.group or list(GROUPS)
    start, results, total = time.monotonic(), [], {}
    with tempfile.TemporaryDirectory() as name, prepared(Path(name)):
        root = Path(name).resolve() / "tree"
        copy_of(TOP, root)
        if given.small:
            return faults(root)
        if given.durations and given.durations.exists():
            known = json.loads(given.durations.read_text())
        else:
            print("the tests, nothing changed:", flush=True)
            known = baseline(root, groups)
            if given.durations:
                given.durations.write_text(json.dumps(known))
        drawn: list[tuple[str, Mutant]] = []
        if given.again:
            earlier = [json.loads(line) for line in given.again.read_text().splitlines()]
            drawn = [(item["group"], Mutant(item["module"], item["operator"], item["place"]))
                     for item in earlier if item["verdict"] in ("survived", "stopped") and item["group"] in groups]
            total = {group: sum(item["group"] == group for item in earlier) for group in groups}
        else:
            for group in groups:
                chosen, total[group] = sample(root, list(GROUPS[group]), given.count, given.seed)
                drawn += [(group, mutant) for mutant in chosen]
        for group, mutant in drawn:
            began = time.monotonic()
            changed = mutated(root, mutant)
            if changed is None:
                raise SystemExit(f"{mutant}: there is no such place any more, or it changes nothing that runs")
            outcome, test = verdict(root, mutant.module, changed, tests_of(mutant.module), known)
            results.append({"group": group, **mutant._asdict(), "verdict": outcome, "test": test})
            print(f"{outcome:9s}{time.monotonic() - began:5.1f} s  {mutant}  {test}", flush=True)
            if outcome == "survived":
                print(difference(root, mutant), flush=True)
            if given.out:
                with given.out.open("a") as file:
                    file.write(json.dumps(results[-1]) + "\n")
    print(table(results, total))
    print(f"{len(results)} mutants in {time.monotonic() - start:.0f} s")
    return int(any(item["verdict"] in ("survived", "stopped") for item in results))


if __name__ == "__main__":
    sys.exit(main())
