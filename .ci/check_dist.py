"""Check what is handed out: `python .ci/check_dist.py DIST TREE`.

DIST holds an sdist and the wheel built from it, TREE a wheel built from the checkout. Both wheels hold the same files, of the
same content: the sources of both packages and the start of the command, a sample, py.typed, LICENSE, no more.
"""

import re
import sys
import tarfile
import zipfile
from pathlib import Path

TOP = Path(__file__).parents[1]
METADATA = {"METADATA", "RECORD", "WHEEL", "entry_points.txt", "licenses/LICENSE", "top_level.txt"}
EGG_INFO = {"PKG-INFO", "SOURCES.txt", "dependency_links.txt", "entry_points.txt", "requires.txt", "top_level.txt"}
SAMPLE = {f"fvkit_granular/scenes/samples/torrent/{name}" for name in ("release.geojson", "scene.toml", "terrain.asc")}
TOP_LEVEL = {"LICENSE", "MANIFEST.in", "PKG-INFO", "README.md", "pyproject.toml", "setup.cfg"}


def only(folder, pattern):
    """Return the one file of a folder that fits."""
    found = list(Path(folder).glob(pattern))
    if len(found) != 1:
        raise SystemExit(f"{folder} holds {len(found)} files {pattern}, one is wanted")
    return found[0]


def same(what, have, want):
    """Stop unless two sets of names are equal."""
    if have != want:
        raise SystemExit(f"{what}: too much {sorted(have - want)}, missing {sorted(want - have)}")


def main(dist, tree):
    """Compare the names in both wheels and the sdist with those of the checkout."""
    sources = {path.relative_to(TOP).as_posix() for package in ("fvkit", "fvkit_granular") for path in (TOP / package).rglob("*")
               if path.is_file() and path.parent.name != "__pycache__"} | {"fvkit_command.py"}
    same("packages", {name for name in sources if not name.endswith(".py")},
         {"fvkit/py.typed", "fvkit_granular/py.typed", *SAMPLE})

    records = []
    for wheel in (only(dist, "*.whl"), only(tree, "*.whl")):
        if not wheel.name.endswith("-py3-none-any.whl"):
            raise SystemExit(f"{wheel.name}: there is no native code in it, so it must be -py3-none-any")
        with zipfile.ZipFile(wheel) as archive:
            info = "-".join(wheel.name.split("-")[:2]) + ".dist-info"
            same(wheel.name, set(archive.namelist()), sources | {f"{info}/{name}" for name in METADATA})
            records.append(sorted(archive.read(f"{info}/RECORD").splitlines()))  # in the order of the disk
    if records[0] != records[1]:
        differ = sorted({line.decode() for line in set(records[0]) ^ set(records[1])})
        raise SystemExit(f"the wheel built from the sdist differs from the one built from the checkout: {differ}")

    sdist = only(dist, "*.tar.gz")
    root = re.sub(r"\.tar\.gz$", "", sdist.name)
    with tarfile.open(sdist) as archive:
        names = {member.name.removeprefix(f"{root}/") for member in archive.getmembers() if member.isfile()}
    same(sdist.name, names, sources | TOP_LEVEL | {f"fvkit.egg-info/{name}" for name in EGG_INFO})
    print(f"wheel and sdist hold the {len(sources)} files of the packages, their metadata, no more; both wheels are the same")


if __name__ == "__main__":
    main(*sys.argv[1:])
