"""Mass balance of each phase through each side, by outlets, hydrographs and drains, with first contacts."""

import attrs
import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from tests.terrain.test_mountain import SHAPE, rectangle, release, terrain

#: Turns and mirror images of a map (ny, nx), and the sides that take the place of west, east, south, north.
TURNS = {"as it is": (lambda b: b, ("west", "east", "south", "north")),
         "west and east exchanged": (lambda b: b[:, ::-1], ("east", "west", "south", "north")),
         "south and north exchanged": (lambda b: b[::-1], ("west", "east", "north", "south")),
         "x and y exchanged": (lambda b: b.T, ("south", "north", "west", "east"))}


def hydrograph(folder, name, discharge, area, ground, until=3.0):
    path = folder / name
    path.write_text(f"t [s],discharge [m3/s],phi [-]\n0,{discharge},0.5\n{until:g},{discharge},0.5\n")
    return gr.read_hydrograph(path, area, ground)


@pytest.mark.parametrize("model", [gr.TwoPhase, gr.Reduced])
def test_everything_at_once_closes_and_stands_where_it_belongs(model, backend, tmp_path):
    ground = terrain()
    leak = np.zeros(SHAPE)
    leak[:, :4] = 0.05
    sources = (hydrograph(tmp_path, "one.csv", 20.0, rectangle(15.0, 25.0, 35.0, 45.0), ground), gr.Drain(leak), gr.ConstantDrag(5.0),
               gr.CoulombFriction(0.1), hydrograph(tmp_path, "two.csv", 50.0, rectangle(90.0, 110.0, 5.0, 15.0), ground), gr.Rain(1e-4))
    scene = gr.Scene(terrain=ground, release=release(ground), phi=0.6, t_end=6.0, sources=sources)
    hazard = gr.HazardMaps(threshold=0.05)
    solution = fv.solve(scene.problem(model), observers=hazard, backend=backend, nonhyperbolic="ignore")
    balance = gr.mass_balance(scene, solution, hazard)
    assert all(abs(error) < 1e-12 for error in balance.error.values())
    assert set(balance.entered) == {"west", "east", "south", "north", "cells without data", "hydrograph", "hydrograph 2", "rain", "drain"}
    together = {place: sum(row.values()) for place, row in balance.entered.items()}
    assert together["hydrograph"] == pytest.approx(60.0, rel=1e-12)
    assert together["hydrograph 2"] == pytest.approx(150.0, rel=1e-12)
    assert together["rain"] == pytest.approx(1e-4 * 6.0 * ground.grid.size * ground.grid.cell_volume, rel=1e-12)
    assert max(together[place] for place in ("drain", "cells without data", "east")) < -1.0
    assert balance.entered["hydrograph"] == pytest.approx({"hs": 30.0, "hf": 30.0}, rel=1e-12)
    assert balance.entered["rain"]["hs"] == pytest.approx(0.0, abs=1e-12)
    assert balance.first["hs"] == pytest.approx(0.6 * 30.0 * 35.0, rel=1e-12)
    for mass, brought in solution.stats.entered_by_sources.items():
        sources = [row[mass] for place, row in solution.stats.entered.items() if place[0].isupper()]
        assert sum(sources) == pytest.approx(brought, rel=1e-12)
    beside = hazard.maps["arrival"][6:12, 11]  # west of the hole, where the flow comes from
    assert balance.contact["cells without data"] == pytest.approx(beside.min())
    assert balance.contact["east"] == hazard.maps["arrival"][:, -1].min() < 6.0
    shown = str(balance)
    assert "in by cells without data" in shown
    assert "in through the east" in shown
    kept = solution.save(tmp_path / "run.npz")
    assert fv.load(kept).stats.entered == solution.stats.entered


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("model", [gr.ShallowWater(), gr.TwoPhase()])
def test_what_leaves_is_booked_at_its_side(turn, model, backend):
    change, sides = TURNS[turn]
    h = np.zeros((20, 20))
    h[5:12, 10:17] = 1.0  # nearest to the east, then to the south, the north and the west

    def run(h):
        grid = fv.Grid((0.0, 0.0), (20.0, 20.0), (20, 20))
        q = np.zeros((3 * len(model.phases), *grid.shape))
        for row in range(0, len(q), 3):
            q[row] = h
        return fv.solve(fv.Problem(model, grid, q, 1.8, aux={"b": 0.0}, boundary=fv.Outflow()), backend=backend, nonhyperbolic="ignore")

    upright, turned = run(h).stats.entered, run(np.ascontiguousarray(change(h))).stats.entered
    mass = "h" if len(model.phases) == 1 else "hs"
    assert upright["east"][mass] < upright["south"][mass] < upright["north"][mass] < upright["west"][mass] <= 0.0
    place = dict(zip(("west", "east", "south", "north"), sides, strict=True))
    gone = [turned[place[side]][mass] for side in ("east", "south", "north", "west")]
    assert gone == sorted(gone)
    if turn != "x and y exchanged":  # steps begin along x
        assert gone == pytest.approx([upright[side][mass] for side in ("east", "south", "north", "west")], rel=1e-9)


def test_uniform_flow_enters_and_leaves_at_its_discharge(backend):
    grid = fv.Grid((0.0, 0.0), (12.0, 6.0), (12, 6))
    problem = fv.Problem(gr.ShallowWater(), grid, lambda x, y: [0.5 + 0.0 * x, 1.0 + 0.0 * x, 0.0 * x], 3.0, aux={"b": 0.0},
                         boundary={"west": fv.Outflow(), "east": fv.Outflow(), "south": fv.Wall(), "north": fv.Wall()})
    entered = fv.solve(problem, backend=backend).stats.entered
    assert entered["west"]["h"] == pytest.approx(1.0 * 6.0 * 3.0, rel=1e-12)
    assert entered["east"]["h"] == pytest.approx(-1.0 * 6.0 * 3.0, rel=1e-12)
    assert entered["south"]["h"] == entered["north"]["h"] == 0.0


def test_with_one_axis_ends_and_sources(backend):
    problem = fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 10.0, 40), lambda x: [1.0 + 0.0 * x, 0.5 + 0.0 * x], 2.0, aux={"b": 0.0},
                         sources=gr.Rain(0.01))
    stats = fv.solve(problem, backend=backend).stats
    assert set(stats.entered) == {"left", "right", "sources"}
    assert stats.entered["left"]["h"] > 0.9 > -0.9 > stats.entered["right"]["h"]
    assert stats.entered["sources"]["h"] == stats.entered_by_sources["h"] == pytest.approx(0.2, rel=1e-12)


def test_a_continued_run_keeps_its_books_and_other_books_are_refused(tmp_path):
    ground, path = terrain(), tmp_path / "run.npz"
    scene = gr.Scene(terrain=ground, release=release(ground), phi=0.6, t_end=3.0, sources=gr.CoulombFriction(0.1))
    whole = fv.solve(scene.problem(gr.Reduced))
    fv.solve(scene.problem(gr.Reduced), limits=fv.Limits(steps=7), checkpoint=fv.Checkpoint(path), throw=False)
    assert fv.resume(path, problem=scene.problem(gr.Reduced)).stats.entered == whole.stats.entered
    fv.solve(scene.problem(gr.Reduced), limits=fv.Limits(steps=7), checkpoint=fv.Checkpoint(path), throw=False)
    leaking = attrs.evolve(scene, sources=(gr.CoulombFriction(0.1), gr.Drain(0.1)))
    with pytest.raises(ValueError, match=r"sources is \(CoulombFriction, Drain, Drain\), but \(CoulombFriction, Drain\) in the run of .*run\.npz"):
        fv.resume(path, problem=leaking.problem(gr.Reduced))


def test_a_balance_of_one_axis_is_refused():
    scene = gr.Scene((0.0, 10.0), 0.1, lambda x: {"h": 1.0 + 0.0 * x, "phi": 0.5})
    with pytest.raises(ValueError, match="run with two axes"):
        gr.mass_balance(scene, fv.solve(scene.problem(gr.TwoPhase, 20)))


@pytest.mark.parametrize("wrong", ["scene", "solution", "hazard"])
def test_other_things_are_refused_by_name(wrong):
    scene = gr.Scene(((0.0, 0.0), (10.0, 4.0)), 0.1, lambda x, y: {"h": 1.0 + 0.0 * x, "phi": 0.5})
    given = {"scene": scene, "solution": fv.solve(scene.problem(gr.ShallowWater, (10, 4)))}
    with pytest.raises(TypeError, match=f"`{wrong}` must be"):
        gr.mass_balance(**given | {wrong: "torrent"})
