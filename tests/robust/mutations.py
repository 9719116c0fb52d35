"""Valid files of every kind that is read, readers of them, and mutations: what a disk, a network or an attacker makes of a file."""

import io
import pickle
import random
import re
import struct
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit_granular.cli.sweep import read as read_sweep
from fvkit_granular.csv_table import read_columns

SCENE_TOML = b"""name = "mine"
interval = [0.0, 4.0]
t_end = 0.1
[initial]
h = {shape = "step", at = 1.0, left = 1.0, right = 0.5}
phi = 0.5
[boundary]
both = "wall"
[[sources]]
type = "constant-drag"
D = 1.0
[outputs]
times = [0.05, 0.1]
"""
SWEEP_TOML = b"""scene = "riemann"
members = 3
cells = 10
backend = "numpy"
outputs = ["max.h"]
[parameters]
gamma = [0.3, 0.6]
"""
DEM_ASC = b"ncols 3\nnrows 2\nxllcorner 100\nyllcorner 200\ncellsize 5\nNODATA_value -9999\n4 5.5 -9999\n1 2e0 3\n"
RELEASE_JSON = (b'{"type": "FeatureCollection", "crs": {"type": "name", "properties": {"name": "EPSG:31287"}}, "features": [{"type": "Feature", '
                b'"properties": {"name": "upper", "thickness": 1.5, "phi": 0.6}, "geometry": {"type": "Polygon", "coordinates": '
                b'[[[101, 201], [112, 202], [108, 209], [101, 201]], [[105, 203], [106, 203], [106, 204], [105, 203]]]}}]}')
COLUMNS_CSV = b"x [m], b [m], phi [%]\n# a remark\n0, 1.5, 50\n1, 2.5e-1, 60\n2.0, 0.0, 70\n"


def _state(solution):
    return solution.t.tobytes(), solution.q.tobytes(), solution.grid, solution.model, solution.status


def _scene(path):
    return gr.scene_text(gr.load_scene(path))


def _sweep(path):
    run, keep, samples = read_sweep(Path(path))
    return run.cells, run.backend, keep, len(samples), samples[0]


def _columns(path):
    table = read_columns(path)
    table.column("x", "length")
    return table.units, {name: values.tolist() for name, values in table.values.items()}, table.lines


def _terrain(path):
    terrain = gr.read_terrain(path)
    return terrain.grid, terrain.bottom.tobytes(), terrain.crs


def _release(path):
    release = gr.read_release(path, TERRAIN)
    return release.thickness.tobytes(), release.phi if release.phi is None else release.phi.tobytes(), release.parts


TERRAIN = gr.Terrain(fv.Grid((100.0, 200.0), (115.0, 210.0), (6, 4)), np.zeros((4, 6)))

#: {kind: (ending, function of a path that returns what was read, comparable)}. A resumed run makes no step.
READERS = {
    "npz": (".npz", lambda path: _state(fv.load(path))),
    "checkpoint": (".npz", lambda path: _state(fv.resume(path, limits=fv.Limits(steps=0), throw=False, checkpoint=None))),
    "netcdf": (".nc", lambda path: _state(fv.load(path))),
    "scene": (".toml", _scene),
    "sweep": (".toml", _sweep),
    "csv": (".csv", _columns),
    "raster": (".asc", _terrain),
    "polygons": (".geojson", _release),
}


def seeds(folder):
    """Write a valid file of each kind and return {kind: its bytes}."""
    folder = Path(folder)
    problem = gr.scene("riemann").problem(gr.TwoPhase, 12)
    solution = fv.solve(problem, backend="numpy", limits=fv.Limits(steps=3), throw=False, checkpoint=fv.Checkpoint(folder / "checkpoint.npz"))
    found = {"npz": solution.save(folder / "npz.npz").read_bytes(), "checkpoint": (folder / "checkpoint.npz").read_bytes(),
             "scene": SCENE_TOML, "sweep": SWEEP_TOML, "csv": COLUMNS_CSV, "raster": DEM_ASC, "polygons": RELEASE_JSON}
    with suppress(ImportError):  # without the extra io there is nothing to read
        found["netcdf"] = solution.save(folder / "netcdf.nc").read_bytes()
    return found


class Canary:
    """What must never run: unpickling it makes a file."""

    def __init__(self, path):
        self.path = str(path)

    def __reduce__(self):
        return open, (self.path, "w")


INTEGERS = [0, 1, 0x7F, 0x80, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF, 2**63 - 1, 2**64 - 1]
WORDS = [b"nan", b"inf", b"-1", b"1e400", b"9" * 400, b"9" * 5000, b"[" * 3000, b"{", b"}", b"]", b"'", b'"""', b"\0", b"\xff", b"\n", b"=", b".", b",",
         b"true", b"1979-05-27", b"../../etc/passwd", b"/dev/zero", b"import os", b"!!python/object", b"0x", b"\xef\xbb\xbf", b"\r", b"x [m]", b"#",
         b"__class__", b"<f8", b"|O", b"(99999999999,)", b"CONSTANT", b"gamma = 1\n", b"[initial]\n", b"\xe2\x80\xa8", b'"sources.D" = [1, 2]\n']


def mutate(data, chance, times=1):
    """Return the bytes after some random changes; ``chance`` is a random.Random."""
    result = bytearray(data)
    for _ in range(times):
        at, kind = chance.randrange(len(result) + 1), chance.randrange(8)
        if kind == 0 and result:
            result[at % len(result)] ^= 1 << chance.randrange(8)
        elif kind == 1:
            del result[at:]
        elif kind == 2:
            result[at:at] = chance.choice(WORDS)
        elif kind == 3:
            end = at + chance.randrange(1, 200)
            result[at:at] = result[at:end]
        elif kind == 4:
            del result[at:at + chance.randrange(1, 50)]
        elif kind == 5:
            packed = struct.pack(chance.choice("<>") + "Q", chance.choice(INTEGERS))
            size = chance.choice((1, 2, 4, 8))
            result[at:at + size] = packed[:size]
        elif kind == 6:
            word = chance.choice(WORDS)
            result[at:at + len(word)] = word
        else:
            lines = bytes(result).splitlines(keepends=True)
            chance.shuffle(lines)
            result = bytearray(b"".join(lines))
    return bytes(result)


def entries(data):
    """The entries of an archive, {name: bytes}."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def archive(content, compression=zipfile.ZIP_STORED):
    """An archive of entries: its checksums are right, whatever the entries are."""
    result = io.BytesIO()
    with zipfile.ZipFile(result, "w", compression) as file:
        for name, data in content.items():
            file.writestr(name, data)
    return result.getvalue()


def inside(data, chance, times=1):
    """Mutate one entry of an archive, whose checksums are made right again."""
    content = entries(data)
    name = chance.choice(list(content))
    content[name] = mutate(content[name], chance, times)
    return archive(content)


def crafted(data, canary):
    """Archives that somebody made on purpose, {what: bytes}."""
    content = entries(data)
    objects = io.BytesIO()
    np.lib.format.write_array(objects, np.array([Canary(canary)], dtype=object), allow_pickle=True)
    huge = io.BytesIO()
    np.lib.format.write_array_header_1_0(huge, {"descr": "<f8", "fortran_order": False, "shape": (2**40, 2**20)})
    negative = io.BytesIO()
    np.lib.format.write_array_header_1_0(negative, {"descr": "<f8", "fortran_order": False, "shape": (-1, -8)})
    code = re.sub(rb"\(\d+,\)", lambda shape: b"(open(r'%s', 'w'),)" % str(canary).encode(), content["t.npy"])
    return {
        "a pickle": archive(content | {"t.npy": pickle.dumps(Canary(canary))}),
        "an array of objects": archive(content | {"t.npy": objects.getvalue()}),
        "a bomb": archive(content | {"t.npy": content["t.npy"] + bytes(300_000_000)}, zipfile.ZIP_DEFLATED),
        "a shape beyond memory": archive(content | {"q.npy": huge.getvalue()}),
        "a negative shape": archive(content | {"q.npy": negative.getvalue()}),
        "code in a header": archive(content | {"t.npy": code}),
        "nothing in it": archive({}),
        "a text too long": archive(content | {"format.npy": content["format.npy"].replace(b"<U", b"<U9999999999")}),
        "an archive in it": archive(content | {"t.npy": data}),
        "a million names": archive({f"{k}.npy": b"" for k in range(2000)}),
        "a name outside": archive(content | {"../../outside.npy": content["t.npy"]}),
        "encrypted": data.replace(b"PK\x01\x02\x14\x03\x14\x00\x00\x00", b"PK\x01\x02\x14\x03\x14\x00\x01\x00"),
    }


def texts(kind):
    """TOML and CSV that somebody made on purpose, {what: bytes}."""
    if kind == "csv":
        return {"a million columns": b",".join(b"x [m]" for _ in range(200_000)) + b"\n1\n", "one long line": b"x [m], b [m]\n" + b"1" * 5_000_000,
                "too large": b"x [m]\n" + b"1\n" * 5_000_001, "quotes": b'x [m], b [m]\n"1,2', "a field too long": b'x [m]\n"' + b"1" * 200_000 + b'"\n',
                "nul": b"x [m]\n\0\n", "semicolons": b"x [m]; b [m]\n1; 2\n", "other units": b"x [ft], b [m]\n1, 2\n", "utf-16": "x [m]\n1\n2\n".encode("utf-16")}
    head = SCENE_TOML if kind == "scene" else SWEEP_TOML
    return {"lists in lists": b"a = " + b"[" * 100_000, "tables in tables": b"a" + b".a" * 100_000 + b" = 1\n", "tables in braces": b"a = " + b"{a = " * 50_000,
            "twice": head + head, "a digit too many": head.replace(b"0.1\n", b"1" * 10_000 + b"\n").replace(b"= 3\n", b"= " + b"1" * 10_000 + b"\n"),
            "too large": b"#" * 10_000_001, "utf-16": head.decode().encode("utf-16"), "yaml": b"!!python/object/apply:os.system ['true']\n",
            "headers": b"[a]\n" * 100_000, "a long key": b"k" * 5_000_000 + b" = 1\n", "nothing": b"", **({"itself": head.replace(b'"riemann"', b'"mutated.toml"')} if kind == "sweep" else {})}


def generator(seed):
    """Random numbers that are the same everywhere."""
    return random.Random(seed)
