"""`SceneRun`: a function of parameters by name that runs a scene, for sweeps and fits."""
import inspect
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from fvkit import Model, Problem, Scheme, Solution, WavePropagation, solve, validation
from fvkit.backends import BACKENDS
from fvkit.problem.directions import observables
from fvkit.schemes.registry import INTEGRATORS, LIMITERS, RECONSTRUCTIONS
from fvkit.schemes.riemann import default_riemann
from fvkit_granular.models.quantities import flow_names
from fvkit_granular.models.registry import MODELS, RIEMANN
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.scenes.scene import ascending as _times
from fvkit_granular.scenes.toml.read import find_factory

#: Fields of a scene that are parameters.
PHYSICS = ("g", "gamma", "t_end")

#: How the name of a factor on a field of a source ends.
FACTOR = ".factor"

#: Numbers of cells of a run, with two axes along x, where none is given, by the number of axes.
CELLS = {1: 400, 2: 100}

#: Parts of a scheme that may be given by name.
NAMED = {"riemann": RIEMANN, "limiter": LIMITERS, "reconstruction": RECONSTRUCTIONS, "integrator": INTEGRATORS}


def _model(value: Any) -> Any:
    if isinstance(value, type) and issubclass(value, Model):
        return value
    return validation.instance(value, "model", Model, "such as gr.TwoPhase, or gr.TwoPhase(g=9.81, gamma=0.5)")


def _factory(given: Any) -> Any:
    if isinstance(given, str):
        find_factory(given)
        return given
    if not callable(given):
        raise TypeError("`scene` must be the name of a built-in scene, the path of a .toml file, or a function that returns a "
                        f"gr.Scene (at the top level of a module, for processes), got {validation.shown(given)}")
    return given


@attrs.frozen
class SceneRun:
    """Run of a scene as a function of parameters, for `fvkit.sweep` and optimisers.

    Parameters
    ----------
    scene : name of a built-in scene, path of a TOML file, or a function that returns a `Scene`.
    model : instance, or class that gets the scene's g and gamma.
    scheme : None for second-order wave propagation with the model's default solver.
    cells : number of cells; with two axes along x, or (nx, ny). None for 400, with two axes 100.
    times : output times, s; None for the end alone.
    backend : as for `fvkit.solve`.

    Notes
    -----
    Parameters of the call, all optional:

    * arguments of the function that makes the scene, such as ``eps`` of perturbed-rest;
    * ``g``, ``gamma``, ``t_end``: of the scene;
    * ``sources.D``: the field D of the source that has one; ``sources.0.D`` where several have, counted from 0;
      ``sources.D.factor``: a factor on it, also where it varies over the grid, which one number would not;
    * ``initial.h``, ``initial.phi``, ``initial.vs``, ``initial.vf``, with two axes ``initial.vs_x`` and so on: a factor on that
      initial value, everywhere;
    * ``model``: a model by name; ``model.dry``: its fields;
    * ``scheme.cfl``, ``scheme.limiter``: fields of the scheme, parts by name;
    * ``cells``.

    Loss of hyperbolicity gives no warning here: keep ``nonhyperbolic_faces`` to detect it. A failed run returns its partial
    solution, with its status.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> run = gr.SceneRun("dam-break", model=gr.ShallowWater, cells=50, backend="numpy")
    >>> run(t_end=0.5).t.tolist()
    [0.0, 0.5]
    """

    scene: str | Callable[..., Scene] = attrs.field(converter=_factory)
    model: Model | type[Model] = attrs.field(default=TwoPhase, converter=_model)
    scheme: Scheme | None = validation.field(
        validation.instance, None, optional=True, kind=Scheme, hint="such as fv.WavePropagation(fv.HLL())")
    cells: Any = validation.field(validation.per_axis, None, optional=True, each=validation.whole, at_least=1,
                                  hint="the number of cells")
    times: tuple[float, ...] | None = attrs.field(default=None, converter=attrs.converters.optional(_times))
    backend: str = validation.field(validation.choice, "auto", known=BACKENDS)

    def __call__(self, **parameters: Any) -> Solution:
        """Run the scene with these parameters."""
        problem, scheme = self.setup(parameters)
        return solve(problem, scheme, self.times, backend=self.backend, nonhyperbolic="ignore", throw=False)

    def setup(self, parameters: Mapping[str, Any]) -> tuple[Problem, Scheme | None]:
        """Return problem and scheme for parameters by name.

        Raises
        ------
        ValueError
            For an unknown parameter, with the list and the nearest match.
        """
        _, problem, scheme = self.setup_of_scene(parameters)
        return problem, scheme

    def setup_of_scene(self, parameters: Mapping[str, Any]) -> tuple[Scene, Problem, Scheme | None]:
        """Return the scene as well, see `setup`."""
        left = dict(parameters)
        scene = self._scene(left)
        model = self._model(scene, left)
        scheme = _changed_scheme(self.scheme, model, left)
        own = None if scene.terrain is not None else CELLS[len(scene.axes)]
        cells = left.pop("cells", own if self.cells is None else self.cells)
        if left:
            validation.choice(next(iter(left)), "parameter", self.names(scene, model))
        problem = scene.problem(model, cells)
        if isinstance(scene.initial, Scaled):
            scene.initial.check(observables(problem.model, problem.grid, problem.q0, problem.aux_averages))
        return scene, problem, scheme

    def scene_of(self, parameters: Mapping[str, Any]) -> Scene:
        """Return the scene for parameters by name, those of model, scheme and cells among them."""
        return self._scene(dict(parameters))

    def names(self, scene: Scene, model: Model) -> list[str]:
        """Return the parameters that a call may have, without those of the scheme."""
        sources = scene.sources
        return [*self._arguments(), *PHYSICS, *(f"initial.{name}" for name in flow_names(len(scene.axes))), "cells", "model",
                *(f"model.{name}" for name in model.parameter_names()),
                *dict.fromkeys(f"sources.{name}" for source in sources for name in source.parameter_names()), "scheme.cfl"]

    def _arguments(self) -> list[str]:
        return list(inspect.signature(self._make).parameters)

    @property
    def _make(self) -> Callable[..., Scene]:
        return find_factory(self.scene) if isinstance(self.scene, str) else self.scene

    def _scene(self, left: dict[str, Any]) -> Scene:
        scene = self._make(**{name: left.pop(name) for name in self._arguments() if name in left})
        validation.instance(scene, "scene", Scene)
        changes: dict[str, Any] = {name: left.pop(name) for name in PHYSICS if name in left}
        factors = {name: validation.real(left.pop(f"initial.{name}"), f"initial.{name}", hint="a factor")
                   for name in flow_names(len(scene.axes)) if f"initial.{name}" in left}
        if factors:
            changes["initial"] = Scaled(scene, factors)
        sources = list(scene.sources)
        for name in [name for name in left if name.startswith("sources.")]:
            _change_source(sources, name, left.pop(name))
        return attrs.evolve(scene, sources=tuple(sources), **changes)

    def _model(self, scene: Scene, left: dict[str, Any]) -> Model:
        given: Any = self.model
        if "model" in left:
            given = MODELS[validation.choice(left.pop("model"), "model", MODELS)]
        model = scene.model(given)
        known = model.parameter_names()
        fields = {name: left.pop(f"model.{name}") for name in known if f"model.{name}" in left}
        return attrs.evolve(model, **fields)


@attrs.frozen(eq=False)
class Scaled:
    """The initial flow of a scene with a factor on each of some values, {name: factor}."""

    of_release: ClassVar[bool] = True  #: a scene may have it beside its release

    scene: Scene
    factors: Mapping[str, float]

    def check(self, seen: Mapping[str, np.ndarray]) -> None:
        """Raise ValueError for a factor on an observable that is 0 in all cells; ``seen`` are the observables of the start."""
        for name, factor in self.factors.items():
            if factor != 0.0 and name in seen and not np.any(seen[name]):
                raise ValueError(f"`initial.{name}` is a factor on the initial {name} of the scene, which is 0 everywhere: it "
                                 "changes nothing, leave it out")

    def __call__(self, *places: np.ndarray) -> dict[str, Any]:
        flow, factors = dict(self.scene.initial(*places)), dict(self.factors)
        if "surface" in flow and "h" in factors:
            b = self.scene.height(*places)
            flow = {name: value for name, value in flow.items() if name != "h"}
            flow["surface"] = b + factors.pop("h") * (flow["surface"] - b)
        return flow | {name: factor * np.asarray(flow.get(name, 0.0)) for name, factor in factors.items()}


def _change_source(sources: list[Any], name: str, value: Any) -> None:
    """Put ``value`` into the one source that ``name`` means: ``sources.FIELD`` or ``sources.NUMBER.FIELD``, or a factor on it."""
    name, factor, _ = name.partition(FACTOR)
    *number, field = name.split(".")[1:]
    known = {f"sources.{i}.{have}": i for i, source in enumerate(sources) for have in source.parameter_names()}
    if number:
        where = [known[validation.choice(name, "parameter", known)]]
    else:
        where = [i for full, i in known.items() if full.endswith(f".{field}")]
    if not where:
        short = [f"sources.{full.split('.')[2]}" for full in known]
        validation.choice(name, "parameter", short or ["none: the scene has no sources"])
    if len(where) > 1:
        raise ValueError(f"parameter `{name}` is in several sources: write one of " + ", ".join(
            full for full in known if full.endswith(f".{field}")))
    before = getattr(sources[where[0]], field)
    varies, single = callable(before) or np.ndim(before) > 0, validation.is_single(value) and not callable(value)
    if varies and single and (callable(before) or not factor):
        way = "give a function that makes the scene from its parameters" if callable(before) else \
            f"take `{name}{FACTOR}`, a factor on it"
        raise ValueError(f"`{name}` varies over the grid, and one number would replace all of it: {way}")
    if factor:
        value = validation.real(value, f"{name}{FACTOR}", hint="a factor") * (np.asarray(before) if varies else before)
    sources[where[0]] = attrs.evolve(sources[where[0]], **{field: value})


def _changed_scheme(scheme: Scheme | None, model: Model, left: dict[str, Any]) -> Scheme | None:
    names = [name for name in left if name.startswith("scheme.")]
    if not names:
        return scheme
    base: Any = WavePropagation(default_riemann(model)) if scheme is None else scheme
    known = [f"scheme.{field.name}" for field in attrs.fields(type(base)) if field.init]
    changes = {}
    for name in names:
        field = validation.choice(name, "parameter", known).removeprefix("scheme.")
        value = left.pop(name)
        parts: Mapping[str, type] = NAMED.get(field, {})
        changes[field] = parts[validation.choice(value, name, parts)]() if isinstance(value, str) and parts else value
    return attrs.evolve(base, **changes)
