"""Calls that are right, and what each of their arguments is: every value that its kind refuses is tried in its place."""

import attrs
import numpy as np

import fvkit as fv
import fvkit_granular as gr
from fvkit.output.configuration import build
from fvkit.schemes.wave_propagation import WavePropagation
from fvkit_granular import exact, shapes
from fvkit_granular.csv_table import read_columns

GRID = fv.Grid(0.0, 1.0, 6)
PLANE = fv.Grid((0.0, 0.0), (3.0, 2.0), (3, 2))
TERRAIN = gr.Terrain(PLANE, np.zeros((2, 3)))
SQUARE = {"type": "Polygon", "coordinates": [[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]]}
LEFT, RIGHT = (1.0, 0.5, 0.0, 0.0), (0.9, 0.5, 0.0, 0.0)


def flow(x):
    return {"h": 1.0 + 0.0 * x, "phi": 0.5 + 0.0 * x}


def bump(x):
    return 0.1 * np.exp(-(x**2))


def members(D):
    return {"h": D}


PROBLEM = fv.Problem(fv.Burgers(), GRID, np.ones((1, 6)), 1.0)
SCENE = gr.Scene((0.0, 1.0), 0.01, flow)


SOLUTION = fv.solve(PROBLEM, backend="numpy")


class LimiterSuite(fv.testing.LimiterConformance):
    limiter = fv.MC()


def small(n):
    return fv.Problem(fv.Burgers(), fv.Grid(0.0, 1.0, n), np.ones((1, n)), 0.01)


@attrs.frozen
class Call:
    """A callable, arguments with which it works, and {argument: its kind}; other names in a message than its own."""

    function: object
    given: dict
    kinds: dict
    named: dict = attrs.field(factory=dict)
    works: bool = True


#: Parameters of a run that `solve` and `Stepper` share.
RUN = {"problem": "part", "scheme": "part?", "backend": "name"}

CALLS = {
    "Grid": Call(fv.Grid, dict(lower=0.0, upper=1.0, num_cells=5), dict(lower="number", upper="number", num_cells="count")),
    "Problem": Call(fv.Problem, dict(model=fv.Burgers(), grid=GRID, initial=np.ones((1, 6)), t_end=1.0),
                    dict(model="part", grid="grid", initial="values?", t_end="positive", aux="mapping", boundary="side", sources="parts",
                         t_start="number", background="values?")),
    "solve": Call(fv.solve, dict(problem=PROBLEM, backend="numpy"),
                  {**RUN, "times": "times?", "progress": "flag", "throw": "flag", "step": "part?", "limits": "part?",
                   "observers": "functions", "nonhyperbolic": "name", "threads": "count", "checkpoint": "part?", "until": "part?",
                   "record": "part?"}),
    "Step": Call(fv.Step, {}, dict(dt="positive?", dt_max="positive?", dt_initial="positive?")),
    "Limits": Call(fv.Limits, {}, dict(steps="count from 0", seconds="positive?")),
    "Stream": Call(fv.Stream, dict(path="run.nc"), dict(path="file")),
    "Stepper": Call(fv.Stepper, dict(problem=PROBLEM, backend="numpy"),
                    {**RUN, "nonhyperbolic": "name", "threads": "count", "step": "part?"}),
    "Stepper.step": Call(lambda dt: fv.Stepper(PROBLEM, backend="numpy").step(dt), dict(dt=0.1), dict(dt="positive?")),
    "Stepper.advance": Call(lambda t: fv.Stepper(PROBLEM, backend="numpy").advance(t), dict(t=0.1), dict(t="not negative")),
    "rhs": Call(fv.rhs, dict(problem=PROBLEM), dict(problem="part", scheme="part?")),
    "rhs(t, q)": Call(lambda q: fv.rhs(PROBLEM)(0.0, q), dict(q=np.ones((1, 6))), dict(q="array")),
    "load": Call(fv.load, dict(path="nowhere.npz"), dict(path="file"), works=False),
    "resume": Call(fv.resume, dict(path="nowhere.npz"), dict(path="file"), works=False),
    "Along": Call(fv.Along, dict(lower=0.0, upper=1.0, condition=fv.Wall()), dict(lower="number", upper="number")),
    "Inflow": Call(fv.Inflow, dict(state=[1.0]), dict(state="array", slope="number?")),
    "Outflow": Call(fv.Outflow, {}, dict(slope="number?")),
    "Periodic": Call(fv.Periodic, {}, dict(drop="number?")),
    "Advection": Call(fv.Advection, dict(speed=1.0), dict(speed="number or pair")),
    "Acoustics": Call(fv.Acoustics, dict(rho=1.0, bulk=1.0), dict(rho="positive", bulk="positive")),
    "Checkpoint": Call(fv.Checkpoint, dict(path="run.npz"), dict(path="file", seconds="not negative?", interval="positive?")),
    "Gauge": Call(fv.Gauge, dict(x=[0.5]), dict(x="array", dt="positive?")),
    "CrossSection": Call(fv.CrossSection, dict(line=[(0.0, 0.0), (1.0, 1.0)]), dict(line="array")),
    "HazardMaps": Call(gr.HazardMaps, {}, dict(threshold="positive", density="positive", least="positive")),
    "RunOut": Call(gr.RunOut, dict(path=[(0.0, 0.0), (1.0, 1.0)]), dict(path="array", threshold="positive")),
    "read_path": Call(gr.read_path, dict(source={"type": "LineString", "coordinates": [[0.0, 0.0], [1.0, 1.0]]}, terrain=TERRAIN), dict(terrain="part")),
    "Watch": Call(gr.Watch, {}, dict(lines="mapping", threshold="positive?", density="positive", least="positive")),
    "Drain": Call(gr.Drain, dict(rate=1.0), dict(rate="field not negative")),
    "read_parameter": Call(gr.read_parameter, dict(source=np.ones((2, 3)), terrain=TERRAIN), dict(terrain="part", elsewhere="number?")),
    "read_hydrograph": Call(gr.read_hydrograph, dict(path="nowhere.csv", area=SQUARE, terrain=TERRAIN), dict(terrain="part"), works=False),
    "StopAtRest": Call(fv.StopAtRest, {}, dict(speed="positive", depth="not negative", after="number", every="count")),
    "Keep": Call(fv.Keep, dict(names=["h"]), dict(names="names")),
    "WavePropagation": Call(WavePropagation, dict(riemann=fv.Roe()),
                            dict(riemann="part", limiter="part", order="order", cfl="courant", splitting="part", entropy_fix="flag",
                                 cross_term="flag", in_cell_shocks="flag")),
    "MethodOfLines": Call(fv.MethodOfLines, dict(riemann=fv.Roe()),
                          dict(riemann="part", reconstruction="part", integrator="part", cfl="positive?")),
    "rarely": Call(fv.rarely, dict(condition=np.array([True]), value=lambda: 1.0, otherwise=0.0), dict(value="function")),
    "PyClawRiemann": Call(fv.PyClawRiemann, dict(function=members), dict(function="function", problem_data="mapping", fwave="flag")),
    "Samples": Call(fv.Samples, dict(values={"D": np.ones(2)}), dict(values="mapping", axes="mapping")),
    "Samples.latin_hypercube": Call(fv.Samples.latin_hypercube, dict(ranges={"D": (0.0, 1.0)}, members=3),
                                    dict(ranges="mapping", members="count", seed="count from 0")),
    "Samples.latin_hypercube of a range": Call(lambda D: fv.Samples.latin_hypercube({"D": D}, 3), dict(D=(0.0, 1.0)), dict(D="pair")),
    "Samples.grid": Call(fv.Samples.grid, dict(axes={"D": [1.0]}), dict(axes="mapping")),
    "Samples.given": Call(fv.Samples.given, dict(values={"D": [1.0]}), dict(values="mapping")),
    "sweep": Call(fv.sweep, dict(function=members, parameters={"D": [1.0]}, workers=1),
                  dict(function="function", parameters="mapping", executor="executor", workers="count?", keep="names?", folder="file?",
                       retries="count from 0", batch="count?", progress="flag"), dict(keep="`keep`")),
    "convergence": Call(fv.convergence, dict(problem_of=small, cells=(5, 10, 20), backend="numpy"),
                        dict(problem_of="function", scheme="part?", cells="list", reference="function?", expect="number?", norm="name",
                             backend="name", progress="function?")),
    "compare of any model": Call(fv.compare, dict(problems=small, schemes=[WavePropagation(fv.HLL())], cells=[4], repeats=1, backend="numpy"),
                                 dict(schemes="list", cells="list", reference="function?", repeats="count",
                                      backend="name", seconds="positive?", progress="function?")),
    "ConstantDrag": Call(gr.ConstantDrag, dict(D=1.0), dict(D="field not negative")),
    "VelocityDrag": Call(gr.VelocityDrag, dict(d0=1.0, d1=1.0), dict(d0="field not negative", d1="field not negative")),
    "PitmanLeDrag": Call(gr.PitmanLeDrag, dict(v_T=1.0, exponent=1.0), dict(v_T="positive field", exponent="field not negative")),
    "CoulombFriction": Call(gr.CoulombFriction, dict(nu=0.5), dict(nu="field not negative")),
    "Manning": Call(gr.Manning, dict(n=0.03), dict(n="field not negative")),
    "Voellmy": Call(gr.Voellmy, dict(mu=0.1, xi=500.0), dict(mu="field not negative", xi="positive field")),
    "Front": Call(gr.Front, dict(threshold=0.01), dict(threshold="positive", at_rest="positive")),
    "GivenFlow": Call(gr.GivenFlow, dict(h=1.0, phi=0.5), dict(h="not negative", phi="share", vs="number", vf="number",
                                                                   slope="number?")),
    "Hydrograph": Call(gr.Hydrograph, dict(times=[0.0, 1.0], discharge=[1.0, 2.0], phi=0.5),
                       dict(times="array", discharge="array", phi="array", depth="array?", slope="number?")),
    "FixedLevel": Call(gr.FixedLevel, dict(level=1.0), dict(level="array", phi="share", times="array", slope="number?")),
    "UniformSlope": Call(gr.UniformSlope, {}, dict(slope="number?")),
    "TwoPhase": Call(gr.TwoPhase, {}, dict(g="positive", gamma="open share", dry="positive?")),
    "PitmanLe": Call(gr.PitmanLe, {}, dict(g="positive", gamma="open share", dry="positive?")),
    "TwoLayer": Call(gr.TwoLayer, {}, dict(g="positive", gamma="open share", dry="positive?")),
    "Reduced": Call(gr.Reduced, {}, dict(g="positive", gamma="open share", dry="positive?")),
    "ShallowWater": Call(gr.ShallowWater, {}, dict(g="positive", dry="positive?")),
    "TwoPhase.conserved_from": Call(gr.TwoPhase().conserved_from, dict(h=1.0, phi=0.5, vs=0.0, vf=0.0),
                                    dict.fromkeys(("h", "phi", "vs", "vf"), "array")),
    "FunctionReference": Call(gr.FunctionReference, dict(kind="exact", detail="", at=flow),
                              dict(kind="name", detail="text", at="function", sensitivity="function?")),
    "SelfConverged": Call(gr.SelfConverged, dict(kind="self-converged", solution=SOLUTION), dict(kind="name", solution="part")),
    "Scene": Call(gr.Scene, dict(interval=(0.0, 1.0), t_end=1.0, initial=flow),
                  dict(interval="pair", t_end="positive", initial="function", g="positive", gamma="open share", name="text",
                       description="text", times="array?", boundary="side", sources="parts", reference="function?")),
    "Scene.problem": Call(SCENE.problem, dict(model=gr.TwoPhase, cells=5), dict(model="part", cells="count"), dict(cells="num_cells")),
    "Scene.problem over a bottom": Call(lambda bottom: gr.Scene((0.0, 1.0), 1.0, flow, bottom).problem(gr.TwoPhase, 2), dict(bottom=0.0),
                                        dict(bottom="values"), dict(bottom="aux['b']")),
    "SceneRun": Call(gr.SceneRun, dict(scene="riemann"),
                     dict(scene="scene", model="part", scheme="part?", cells="count?", times="ascending?", backend="name")),
    "ShapedFlow": Call(gr.ShapedFlow, dict(h=1.0, phi=0.5),
                       dict(h="number?", phi="number?", vs="number", vf="number", surface="number?", bottom="number?")),
    "advise": Call(gr.advise, dict(scene=SCENE), dict(scene="part", tol="open share")),
    "compare": Call(gr.compare, dict(scene=SCENE, models=[gr.ShallowWater], riemann=[fv.HLL()], cells=[4], repeats=1, backend="numpy"),
                    dict(scene="part", models="list", riemann="list", cells="list", limiter="part?", order="order", repeats="count",
                         reference="part?", schemes="list", cfl="courant", backend="name", seconds="positive?", progress="function?")),
    "load_scene": Call(gr.load_scene, dict(path="nowhere.toml"), dict(path="file"), works=False),
    "scene": Call(gr.scene, dict(name="riemann"), dict(name="name"), dict(name="scene")),
    "scene_text": Call(gr.scene_text, dict(scene=gr.scene("riemann")), dict(scene="part")),
    "steady": Call(gr.steady, dict(bottom=bump, inflow=dict(h=1.0, phi=0.5, vs=0.1, vf=0.1), interval=(-1.0, 1.0)),
                   dict(bottom="function", inflow="mapping", interval="pair", at="number?", model="part?", transcritical="flag")),
    "steady from h": Call(lambda h: gr.steady(bump, dict(h=h, phi=0.5), (-1.0, 1.0)), dict(h=1.0), dict(h="positive")),
    "read_columns": Call(read_columns, dict(path="nowhere.csv"), dict(path="file"), works=False),
    "Profile.read": Call(gr.Profile.read, dict(path="nowhere.csv", column="b", interpolation="linear"), dict(path="file"), works=False),
    "Hydrograph.read": Call(gr.Hydrograph.read, dict(path="nowhere.csv"), dict(path="file"), works=False),
    "Terrain": Call(gr.Terrain, dict(grid=PLANE, bottom=np.zeros((2, 3))), dict(grid="grid", name="text", crs="text?")),
    "Terrain.coarser": Call(TERRAIN.coarser, dict(cell=1.0), dict(cell="positive")),
    "Terrain.window": Call(TERRAIN.window, dict(lower=(0.0, 0.0), upper=(2.0, 2.0)), dict(lower="array", upper="array")),
    "read_terrain": Call(gr.read_terrain, dict(path="nowhere.asc"), dict(path="file"), works=False),
    "write_raster": Call(gr.write_raster, dict(path="nowhere/depth.asc", values=np.zeros((2, 3)), terrain=TERRAIN),
                         dict(path="file", values="array", terrain="part"), works=False),
    "read_release": Call(gr.read_release, dict(source=SQUARE, terrain=TERRAIN, thickness=1.0),
                         dict(terrain="part", thickness="positive?", solid_fraction="share?", measured="name")),
    "compare_outline": Call(gr.compare_outline, dict(values=np.ones((2, 3)), observed=SQUARE, terrain=TERRAIN),
                            dict(values="array or file", terrain="part", above="number")),
    "draw_map": Call(gr.draw_map, dict(terrain=TERRAIN, values=np.ones((2, 3))),
                     dict(terrain="part", values="array?", label="text", release="part?", above="number", highest="positive?")),
    "build": Call(build, dict(data=dict(zip(("class", "from"), ("Roe", "fvkit.schemes.riemann"), strict=True)), name="data"), dict(name="text")),
    "fvkit.testing.run": Call(fv.testing.run, dict(suite=LimiterSuite), dict(suite="part")),
    # exact solutions
    "exact.accelerated": Call(exact.accelerated, dict(solution=exact.shallow_water_riemann((1.0, 0.0), (0.5, 0.0)), acceleration=1.0),
                              dict(solution="solution", acceleration="number", v0="number")),
    "exact.bernoulli_depth": Call(exact.bernoulli_depth, dict(b=[0.0, 0.1], q=1.0, energy=2.0),
                                  dict(b="array", q="number", energy="number", branch="name", g="positive")),
    "exact.block_stop": Call(exact.block_stop, dict(v0=1.0, nu=0.5, t=[0.1]), dict(v0="number", nu="not negative", t="array", g="positive")),
    "exact.critical_depth": Call(exact.critical_depth, dict(q=1.0), dict(q="number", g="positive")),
    "exact.hump": Call(exact.hump, {}, dict(amplitude="number", width="positive", centre="number", far_depth="positive")),
    "exact.path_sensitivity": Call(exact.path_sensitivity, dict(left=LEFT, right=RIGHT),
                                   dict(left="state of 4", right="state of 4", g="positive", gamma="open share")),
    "exact.periodic_flow": Call(exact.periodic_flow, dict(initial=flow, bottom=lambda x: 0.0 * x, t=0.001, modes=8),
                                dict(initial="function", bottom="function", t="number", interval="pair", g="positive", gamma="open share",
                                     modes="count", drag="not negative")),
    "exact.rarefaction_fans": Call(exact.rarefaction_fans, dict(left=LEFT, widths=(0.01, 0.01, 0.01, 0.01)),
                                   dict(left="state of 4", g="positive", gamma="open share", widths="widths")),
    "exact.reduced_riemann": Call(exact.reduced_riemann, dict(left=(1.0, 0.5, 0.0), right=(0.5, 0.5, 0.0)),
                                  dict(left="state of 3", right="state of 3", g="positive", gamma="open share")),
    "exact.shallow_water_riemann": Call(exact.shallow_water_riemann, dict(left=(1.0, 0.0), right=(0.5, 0.0)),
                                        dict(left="state of 2", right="state of 2", g="positive")),
    "exact.simple_wave": Call(exact.simple_wave, {}, dict(h0="function?", g="positive", far_depth="positive", interval="pair")),
    "exact.sliding_acceleration": Call(exact.sliding_acceleration, dict(slope=-1.0, nu=0.5),
                                       dict(slope="number", nu="not negative", g="positive", buoyancy="number")),
    "exact.steady_flow": Call(exact.steady_flow, dict(b=[0.0, 0.1, 0.0], q=1.0, h_out=2.0),
                              dict(b="array", q="number", h_out="number?", regime="name", g="positive")),
    "exact.thacker_basin": Call(exact.thacker_basin, {}, dict(a="positive", h0="positive", centre="number", amplitude="number?", g="positive")),
    "exact.two_phase_riemann": Call(exact.two_phase_riemann, dict(left=LEFT, right=RIGHT),
                                    dict(left="state of 4", right="state of 4", g="positive", gamma="open share", path="name")),
    "exact.uniform_drag": Call(exact.uniform_drag, dict(state=LEFT),
                               dict(state="state of 4", d0="not negative", d1="not negative", m="positive", gamma="open share")),
    # shapes
    "exact.Vortex": Call(exact.Vortex, {}, dict(depth="positive", speed="not negative", radius="positive", g="positive")),
    "exact.TwoPhaseVortex": Call(exact.TwoPhaseVortex, {}, dict(g="positive", gamma="open share")),
    "exact.ThackerBowl": Call(exact.ThackerBowl, {}, dict(motion="name", a="positive", h0="positive", eta="number", r0="positive", g="positive")),
    "exact.RadialDamBreak": Call(exact.RadialDamBreak, {}, dict(inside="positive", outside="not negative", radius="positive", g="positive", cells="count")),
    "shapes.Uniform": Call(shapes.Uniform, dict(value=1.0), dict(value="number")),
    "shapes.Step": Call(shapes.Step, dict(at=0.0, left=1.0, right=2.0), dict(at="number", left="number", right="number")),
    "shapes.Steps": Call(shapes.Steps, dict(at=[0.0], values=[1.0, 2.0]), dict(at="array", values="array")),
    "shapes.Block": Call(shapes.Block, dict(centre=0.0, half_width=1.0, height=1.0), dict(centre="number", half_width="positive", height="number")),
    "shapes.Hump": Call(shapes.Hump, dict(centre=0.0, half_width=1.0, height=1.0), dict(centre="number", half_width="positive", height="number")),
    "shapes.Gaussian": Call(shapes.Gaussian, dict(centre=0.0, width=1.0, height=1.0), dict(centre="number", width="positive", height="number")),
    "shapes.Cosine": Call(shapes.Cosine, dict(mean=0.0, amplitude=1.0, wavelength=1.0),
                          dict(mean="number", amplitude="number", wavelength="positive", crest="number")),
    "shapes.Plane": Call(shapes.Plane, dict(slope=1.0), dict(slope="number", at="number", level="number")),
    "shapes.PiecewiseLinear": Call(shapes.PiecewiseLinear, dict(points=[(0.0, 1.0), (1.0, 2.0)]), dict(points="array")),
    "shapes.Sum": Call(shapes.Sum, dict(terms=[1.0]), dict(terms="array")),
}

#: Public callables that are not in the table, and why.
RESULT = "a record that a function of the package returns: not made by hand, and made by attrs, which names a missing field"
ABSTRACT = "abstract: see test_abstract_parts_say_what_is_missing"
ERROR = "an exception, raised by the package"
NUMPY = "NumPy's own function, for pointwise code"
ELSEWHERE = {
    **dict.fromkeys(("Convergence", "Solution", "Stats", "SweepResult", "Advice", "TerrainAdvice", "MassBalance", "MovingEquilibrium", "OutlineScore", "Profile", "Release", "fvkit.testing.Outcome",
                     *(f"exact.{name}" for name in ("Accelerated", "PeriodicFlow", "RarefactionFans", "ReducedRiemann", "ReducedState",
                                                    "ShallowWaterRiemann", "ShallowWaterState", "SimpleWave", "ThackerBasin", "TwoPhaseRiemann",
                                                    "TwoPhaseState", "TwoPhaseWave", "UniformDrag", "Wave"))), RESULT),
    **dict.fromkeys(("Interrupted", "OrderError", "PointwiseError", "SolveError", "exact.NoFourWaveSolution"), ERROR),
    **dict.fromkeys(("maximum", "minimum", "where"), NUMPY),
    **dict.fromkeys(("Scheme", "Stop", "Reference", "Integrator", "Splitting", "shapes.Shape"), ABSTRACT),
    "mass_balance": "takes a run: see tests/terrain/test_mass_balance.py for what a wrong one gives",
    "SteepSlopeWarning": "a warning, given by the package",
    "Forcing": "takes a function: see tests of sources for what a wrong one gives",
    "Rain": "takes a field of any sign: see tests of sources for what a wrong one gives",
    "save": "`Solution.save` as a function: see that",
    "Phase": "a named tuple: a model that holds a wrong one says so, see tests/core/test_user_model.py",
    "Status": "an enumeration: Python names the value that is none of its members",
    "scene_names": "takes no argument", "Curvature": "takes no argument",
    "fvkit.testing.LimiterConformance": "a suite for pytest: see tests/core/test_conformance.py for what a bad part gives",
    "fvkit.testing.ModelConformance": "as above", "fvkit.testing.RiemannConformance": "as above",
    "fvkit.testing.SourceConformance": "as above",
}
