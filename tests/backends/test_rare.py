"""`fvkit.rarely`: a loop in two versions computes what NumPy does, wherever in a tile a rare face stands."""

from typing import Any, NamedTuple

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.backends.compiled.loops import TILE

#: The last tile has one cell.
CELLS = 2 * TILE + 1

#: Faces with a cliff of a ring: its seam, both ends of a tile and their neighbours, both faces of the tile of one cell.
FACES = (0, 1, TILE // 2, TILE - 1, TILE, TILE + 1, 2 * TILE - 1, 2 * TILE)


class Cliff(NamedTuple):
    push: Any
    slide: Any


@attrs.frozen
class Cascade(fv.Model):
    """Shallow water that loses momentum where the depths of two neighbours are far apart."""

    conserved, phases = ("h", "h v"), (fv.Phase((0,), 1),)

    def flux(self, q):
        return q[1], q[1] * q[1] / q[0] + 5.0 * q[0] * q[0]

    def wave_speeds(self, q):
        v, c = q[1] / q[0], np.sqrt(10.0 * q[0])
        return v - c, v + c

    def jump(self, ql, qr, auxl, auxr):
        (one, other), dh = zip(self.flux(ql), self.flux(qr), strict=True), qr[0] - ql[0]
        cliff = fv.rarely(np.abs(dh) > 0.3, lambda: Cliff(np.sqrt(ql[0] * qr[0]) * dh, 0.1 * np.sign(dh)), Cliff(0.0, 0.0))
        return one[1] - one[0], other[1] - other[0] + 2.0 * cliff.push + cliff.slide


def sawtooth(height: float, *faces: int) -> np.ndarray:
    """Cell values of a ring that rise by a height over each of these faces, and fall gently everywhere."""
    steps = np.full(CELLS, -height * len(faces) / CELLS)
    np.add.at(steps, list(faces), height)
    levels = np.cumsum(steps)
    return levels - levels.min()


def cascade(*faces: int) -> fv.Problem:
    q = np.stack([1.0 + sawtooth(0.5, *faces), 0.1 * np.cos(2.0 * np.pi * np.arange(CELLS) / CELLS)])
    return fv.Problem(Cascade(), fv.Grid(0.0, 1.0, CELLS), q, 1.0, boundary=fv.Periodic())


def shore(*faces: int) -> fv.Problem:
    b = sawtooth(0.5, *faces)
    h = np.where(b > 0.45, 0.0, 1.0)  # dry above the cliff
    return fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, CELLS), gr.ShallowWater().conserved_from(h, 0.0, 0.3), 1.0, aux={"b": b},
                      boundary=fv.Periodic(drop=0.0))


def end(problem: fv.Problem, scheme: fv.Scheme, backend: str, steps: int = 3) -> np.ndarray:
    stepper = fv.Stepper(problem, scheme, backend=backend)
    stepper.run(problem.t_end, steps)
    return stepper.q


CASES = [(cascade, fv.WavePropagation(fv.HLL())), (cascade, fv.MethodOfLines(fv.Rusanov())), (shore, fv.WavePropagation(fv.Roe(), order=1)),
         (shore, fv.WavePropagation(gr.Relaxation()))]


@pytest.mark.parametrize(("build", "scheme"), CASES, ids=["cascade", "lines", "roe", "relaxation"])
def test_a_rare_face_anywhere_in_a_tile_is_that_of_numpy(build, scheme):
    for faces in ((), *((face,) for face in FACES), (0, TILE, 2 * TILE)):
        problem = build(*faces)
        plain = end(problem, scheme, "numpy")
        np.testing.assert_allclose(end(problem, scheme, "numba"), plain, rtol=0.0, atol=1e-12 * np.abs(plain).max(), err_msg=f"{faces}")


@pytest.mark.parametrize(("build", "scheme"), CASES, ids=["cascade", "lines", "roe", "relaxation"])
def test_a_face_is_the_same_to_the_bit_in_both_versions(build, scheme):
    problem, turned = build(TILE // 2), []
    q, aux = problem.q0, problem.aux_averages
    for face in FACES:
        shift = face - TILE // 2
        other = attrs.evolve(problem, initial=np.roll(q, shift, axis=1), aux={name: np.roll(row, shift) for name, row in aux.items()})
        turned.append(np.roll(end(other, scheme, "numba"), -shift, axis=1))
    for found in turned[1:]:
        np.testing.assert_array_equal(found, turned[0])


@pytest.mark.parametrize("cells", [2, TILE, TILE + 1])
@pytest.mark.parametrize("rare", [(True, False), (False, True), (True, True), (False, False)])
def test_a_rare_face_at_an_end_is_that_of_numpy(cells, rare):
    ends = tuple(fv.Inflow((1.6 if high else 1.1, 0.2)) for high in rare)
    problem = fv.Problem(Cascade(), fv.Grid(0.0, 1.0, cells), np.stack([np.ones(cells), np.zeros(cells)]), 1.0, boundary=ends)
    plain = end(problem, fv.WavePropagation(fv.HLL()), "numpy")
    np.testing.assert_allclose(end(problem, fv.WavePropagation(fv.HLL()), "numba"), plain, rtol=0.0, atol=1e-12)


def test_numpy_computes_what_is_rare_only_where_it_occurs():
    calls, depth = [], np.array([4.0, 9.0])

    def roots():
        calls.append(1)
        return Cliff(np.sqrt(depth), [depth, {"twice": (2.0 * depth, None)}])

    usual = Cliff(0.0, [1.0, {"twice": (3.0, None)}])
    assert fv.rarely(depth > 10.0, roots, usual) is usual
    assert fv.rarely(depth > np.nan, roots, usual) is usual
    assert not calls
    found = fv.rarely(depth > 5.0, roots, usual)
    assert isinstance(found, Cliff)
    assert found.push.tolist() == [0.0, 3.0]
    assert found.slide[0].tolist() == [1.0, 9.0]
    assert found.slide[1]["twice"][0].tolist() == [3.0, 18.0]
    assert found.slide[1]["twice"][1] is None
