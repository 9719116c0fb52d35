"""Print the lower bounds that pyproject.toml declares as pins for pip: `python .ci/lowest.py fast test > lowest.txt`."""

import re
import sys
import tomllib
from pathlib import Path

BOUND = re.compile(r"^([A-Za-z0-9_.-]+)>=([0-9.]+)$")


def pins(project, extras):
    """Requirements `name==bound` of the package and of the extras, those that an extra names of its own package followed."""
    found = []
    for requirement in project["dependencies"] + [r for extra in extras for r in project["optional-dependencies"][extra]]:
        own = re.match(rf"^{project['name']}\[(.+)\]$", requirement)
        if own:
            found += pins({**project, "dependencies": []}, own[1].split(","))
            continue
        bound = BOUND.match(requirement)
        if not bound:
            raise SystemExit(f"pyproject.toml: {requirement!r} has no lower bound: write name>=version, and test that version")
        found.append(f"{bound[1]}=={bound[2]}")
    return found


if __name__ == "__main__":
    read = tomllib.loads(Path(__file__).parents[1].joinpath("pyproject.toml").read_text(encoding="utf-8"))
    print("\n".join(pins(read["project"], sys.argv[1:])))
