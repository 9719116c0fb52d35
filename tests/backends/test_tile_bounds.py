"""Where bounds over a tile say that a condition holds nowhere, it holds nowhere; and no bit depends on who is asked."""

import operator

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.per_cell import PerCell
from fvkit.backends.compiled.tile_bounds import TileBounds
from fvkit.pointwise.tracing import KEEPS_NAN, Expr, Graph, needed
from fvkit.problem.directions import in_plane
from fvkit.schemes.scheme import Parts
from fvkit.schemes.stages.dry_fallback import needs_fallback
from fvkit.schemes.stages.faces import transonic
from fvkit.schemes.stages.positivity import may_overdraw

DOES = {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "neg": operator.neg, "abs": np.abs,
        "sqrt": np.sqrt, "where": np.where, "maximum": np.maximum, "minimum": np.minimum, "sign": np.sign, "<": operator.lt,
        "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq, "!=": operator.ne, "&": operator.and_,
        "|": operator.or_, "not": np.logical_not, "isfinite": np.isfinite}


def number(item, known):
    """The values of a node on all faces, or of a bound; ``known`` has those of loads, by their text."""
    values = {}
    for node in needed([item]):
        if node.operation in ("load", "uniform"):
            values[node.index] = known[node.arguments[0]]
        else:
            with np.errstate(all="ignore"):
                values[node.index] = DOES[node.operation.removesuffix(KEEPS_NAN)](*(
                    values[part.index] if isinstance(part, Expr) else part for part in node.arguments))
    return values[item.index] if isinstance(item, Expr) else item


class Tile:
    """Symbols of the cells on both sides of a face, and their values from rows of cells."""

    def __init__(self, q, b):
        self.graph, self.rows, self.known = Graph(), [*q, b], {}
        self.percell = PerCell(self.graph)
        self.left, self.right = (self.loads(place) for place in (0, 1))

    def loads(self, place):
        result = []
        for k, row in enumerate(self.rows):
            node = self.graph.node("load", f"{k}@{place}")
            self.percell.loads[node.index] = k, place
            self.known[f"{k}@{place}"] = row[place:len(row) - 1 + place]
            result.append(node)
        return tuple(result)

    def own(self, name, values):
        """A value that a loop has computed at the faces."""
        self.known[name] = values
        return self.graph.node("load", name)

    def bound(self, condition):
        """What the bounds over the tile say of a condition."""
        bounds = TileBounds(self.graph, self.percell)
        found, faces = bounds.may_hold([condition], set())
        known = dict(self.known)
        for terms, both in ((bounds.cells.values(), True), (faces, False)):
            for term in terms:
                places = [self.percell.at(term.node, place, lambda row, at: self.loads(at)[row]) for place in (0, 1)] if both else [term.node]
                values = np.concatenate([number(node, self.known) for node in places])
                known |= {f"low{term.node.index}": values.min(), f"high{term.node.index}": values.max()}
        return bool(number(found, known))


def cells(model, seed, calm):
    """A random state: nearly uniform, or with shores, steps and slip."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-3, 3)
    spread = 0.05 if calm else rng.choice([0.05, 0.5, 3.0])
    masses = size * 10.0 ** (rng.normal(size=(2, 40)) * spread) * (rng.random((2, 40)) < (1.0 if calm else rng.choice([1.0, 0.8])))
    speeds = np.sqrt(9.81 * size) * rng.normal() * (1.0 + spread * rng.normal(size=(2, 40)))
    b = size * spread * rng.normal(size=40)
    if isinstance(model, gr.ShallowWater):
        return np.array([masses[0], masses[0] * speeds[0]]), b
    return np.array([masses[0], masses[0] * speeds[0], masses[1], masses[1] * speeds[1]]), b


@pytest.mark.parametrize("model", [gr.ShallowWater(dry=1e-9), gr.TwoPhase(dry=1e-9), gr.TwoLayer(dry=1e-9)],
                         ids=["shallow", "two-phase", "two-layer"])
@pytest.mark.parametrize("calm", [True, False])
def test_a_condition_that_the_bounds_exclude_holds_at_no_face(model, calm):
    said, held = 0, 0
    for seed in range(60):
        q, b = cells(model, seed, calm)
        tile, ratio = Tile(q, b), 0.3 / np.sqrt(9.81 * max(q[0].max(), 1e-3))
        rng = np.random.default_rng(seed)
        parts = Parts(model, fv.Roe(), (fv.MC(),), ())
        (*ql, bl), (*qr, br) = tile.left, tile.right
        face = {"ql": tuple(ql), "qr": tuple(qr)}
        sides = {"auxl": (bl,), "auxr": (br,)}
        fluxes = tuple(tile.own(f"flux{k}", 0.5 * (row[1:] + row[:-1])) for k, row in enumerate(q))
        speeds = tuple(tile.own(f"speed{k}", side * rng.uniform(0.5, 1.5, 39) / ratio) for k, side in enumerate((-1.0, 1.0)))
        mass = tuple(fluxes[row + 1] for row in model.mass_rows())
        asked = [needs_fallback(parts, ratio, **face, **sides, left_going=fluxes), transonic(parts, ratio, **face, **sides, speeds=speeds),
                 may_overdraw(parts, ratio, **face, mass_flux=mass, correction=fluxes)]
        if model.defines("may_lose_hyperbolicity"):
            asked.append(model.may_lose_hyperbolicity(tuple(ql), tuple(qr)))
        for condition in asked:
            holds, may = bool(np.any(number(condition, tile.known))), tile.bound(condition)
            assert may or not holds
            said, held = said + (not may), held + holds
    assert said > (60 if calm else 5), "bounds that exclude nothing"
    assert calm or held > 5


def test_what_a_loop_writes_is_bounded_as_it_is_and_not_what_is_made_of_it():
    tile = Tile(np.array([[1.0, 2.0, 3.0]]), np.zeros(3))
    bounds, written = TileBounds(tile.graph, tile.percell), tile.graph.node("load", "buf[528 + j]")
    assert next(term.node for term in bounds.may_hold([2.0 * written > 3.0], {written.index})[1]) is written
    assert bounds.may_hold([np.sign(written) > 0.0], {written.index}) == (True, [])
    assert [term.node.operation for term in bounds.may_hold([np.sign(written) > 0.0], set())[1]] == ["sign"]


def test_not_a_number_is_asked_for():
    tile = Tile(np.array([[1.0, 2.0, 3.0]]), np.zeros(3))
    bounds = TileBounds(tile.graph, tile.percell)
    tile.known |= {"cells": 1.0, "faces": np.nan}
    assert number(bounds.beyond_bounds("cells", "faces"), tile.known)
    assert not number(bounds.beyond_bounds("cells"), tile.known)


def run(model, riemann, cells, plane, sources=()):
    x = (np.arange(cells) + 0.5) / cells
    bottom = np.where(x < 0.2, 0.3, 0.1 * np.cos(2.0 * np.pi * x))
    h = np.where(x < 0.7, 1.0 + 0.4 * np.exp(-100.0 * (x - 0.4) ** 2) - bottom, 0.0)
    share = np.where((x > 0.3) & (x < 0.5), 0.0, 0.5 + 0.2 * np.sin(2.0 * np.pi * x))
    grid = fv.Grid(0.0, 1.0, cells)
    if plane:
        grid = fv.Grid((0.0, 0.0), (1.0, 0.3), (cells, 20))
        h, share, bottom = (np.tile(row, (20, 1)) for row in (h, share, bottom))
    q = model.conserved_from(h, share, 0.6, -0.6)
    if plane:
        q = in_plane(model, q, 0.2 * q)
    stepper = fv.Stepper(fv.Problem(model, grid, q, 1e9, aux={"b": bottom}, boundary=fv.Wall(), sources=sources),
                         fv.WavePropagation(riemann), backend="numba", nonhyperbolic="ignore")
    stepper.run(1e9, 12)
    return stepper.q


@pytest.mark.parametrize(("model", "riemann", "sources"), [
    (gr.ShallowWater(), fv.Roe(), ()), (gr.ShallowWater(), gr.Relaxation(), (gr.Manning(0.03),)), (gr.TwoPhase(), fv.Roe(), ()),
    (gr.TwoPhase(), fv.HLL(), ()), (gr.TwoLayer(), fv.Rusanov(), ())], ids=["roe", "friction", "two-phase", "hll", "layers"])
@pytest.mark.parametrize("plane", [False, True], ids=["line", "plane"])
def test_the_bits_of_a_run_in_which_every_face_is_asked(model, riemann, sources, plane, monkeypatch):
    found = [run(model, riemann, cells, plane, sources) for cells in (37, 513)]
    monkeypatch.setattr(TileBounds, "may_hold", lambda self, conditions, own: (True, []))
    for one in found:
        np.testing.assert_array_equal(one, run(model, riemann, one.shape[-1], plane, sources))
