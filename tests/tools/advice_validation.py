"""Predicted against measured model errors on random scenes, and what is recommended there.

``python -m tests.tools.advice_validation 100 --seed 21`` from the top of a checkout.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from fvkit import Outflow, Wall
from fvkit.backends import BACKENDS
from fvkit.cli import INTERRUPTED, SUCCESS, done_so_far, progress_line
from fvkit.run.interruption import keeping
from fvkit.studies.tables import table
from fvkit_granular.cli.advise import model_errors
from fvkit_granular.scenes.scene import Scene
from fvkit_granular.sources.drag_laws import ConstantDrag
from fvkit_granular.sources.friction_laws import CoulombFriction
from fvkit_granular.studies.advise import decide
from fvkit_granular.studies.model_error_indicators import indicators

#: Kinds of scenes for which the indicators are meant, and others, to know how they fail.
MEANT, BEYOND = ("dam", "rest", "hump", "hump+slip"), ("dam+slip", "friction", "dry")

Random = np.random.Generator


def blob(x: np.ndarray, centre: float, width: float) -> np.ndarray:
    """Return exp(-((x - centre)/width)^2)."""
    return np.exp(-(((x - centre) / width) ** 2))


def _drag(rng: Random) -> float:
    """Drag coefficient, 1/s: none in one case of four, else 1e-2 to 1e3."""
    return 0.0 if rng.random() < 0.25 else float(10.0 ** rng.uniform(-2.0, 3.0))


def _constants(rng: Random) -> dict[str, Any]:
    return {"gamma": float(rng.uniform(0.2, 0.8)), "sources": ConstantDrag(_drag(rng)), "boundary": Outflow()}


def dam(rng: Random, slip: float = 0.0) -> Scene:
    """A dam break with a smeared jump of phi, from rest or with a slip on one side."""
    hl, hr = rng.uniform(1.5, 3.0), rng.uniform(0.8, 1.5)
    left, right = rng.uniform(0.2, 0.75, 2)
    place, width, w = rng.uniform(-1.5, 1.5), 10.0 ** rng.uniform(-1.3, 0.0), slip * rng.uniform(-0.8, 0.8)

    def flow(x: np.ndarray) -> dict[str, Any]:
        return {"h": np.where(x < 0.0, hl, hr), "phi": right + 0.5 * (left - right) * (1.0 - np.tanh((x - place) / width)),
                "vf": np.where(x < 0.0, w, 0.0)}

    return Scene((-5.0, 5.0), float(rng.uniform(0.2, 0.6)), flow, name="dam", **_constants(rng))


def rest(rng: Random) -> Scene:
    """A step of the surface over a bump, with a wavy phi."""
    step, wave, mean = rng.uniform(0.02, 0.1), 10.0 ** rng.uniform(-2.5, -0.7), rng.uniform(0.35, 0.65)
    number, shift, high = rng.integers(1, 4), rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.1, 0.4)

    def bottom(x: np.ndarray) -> np.ndarray:
        return high * blob(x, 0.6, 0.1)

    def flow(x: np.ndarray) -> dict[str, Any]:
        surface = 1.0 + np.where((x > 0.15) & (x < 0.3), step, 0.0)
        return {"h": surface - bottom(x), "phi": mean + wave * np.sin(2.0 * np.pi * number * x + shift)}

    return Scene((0.0, 1.0), float(rng.uniform(0.05, 0.2)), flow, bottom=bottom, name="rest", slope="mild", **_constants(rng))


def hump(rng: Random, slip: float = 0.0) -> Scene:
    """A moving hump of the depth with a blob of phi, and perhaps slip."""
    high, width, place = rng.uniform(0.05, 0.5), rng.uniform(0.5, 1.2), rng.uniform(-2.0, 2.0)
    phi, more, wide, v = rng.uniform(0.3, 0.55), 10.0 ** rng.uniform(-2.0, -0.7), rng.uniform(0.4, 1.5), rng.uniform(-1.0, 1.0)
    w, spot = slip * rng.uniform(-0.8, 0.8), rng.uniform(-2.0, 2.0)

    def flow(x: np.ndarray) -> dict[str, Any]:
        return {"h": 1.0 + high * blob(x, 0.0, width), "phi": phi + more * blob(x, place, wide), "vs": v,
                "vf": v + w * blob(x, spot, 1.0)}

    return Scene((-5.0, 5.0), float(rng.uniform(0.2, 0.8)), flow, name="hump", **_constants(rng))


def friction(rng: Random) -> Scene:
    """A dam break that slides with Coulomb friction."""
    scene, nu = dam(rng), rng.uniform(0.05, 0.4)
    return Scene(scene.interval, scene.t_end, scene.initial, boundary=Outflow(), gamma=scene.gamma, name="friction",
                 sources=(*scene.sources, CoulombFriction(float(nu))))


def dry(rng: Random) -> Scene:
    """A dam break onto dry ground with a blob of phi behind the dam."""
    depth, phi, more, place = rng.uniform(0.5, 2.0), rng.uniform(0.3, 0.5), rng.uniform(-0.2, 0.2), rng.uniform(-2.0, 0.0)

    def flow(x: np.ndarray) -> dict[str, Any]:
        return {"h": np.where(x < 0.0, depth, 0.0), "phi": phi + more * blob(x, place, 0.7)}

    return Scene((-5.0, 5.0), float(rng.uniform(0.2, 0.5)), flow, name="dry", **(_constants(rng) | {"boundary": Wall()}))


KINDS: dict[str, Callable[[Random], Scene]] = {
    "dam": dam, "rest": rest, "hump": hump, "hump+slip": lambda rng: hump(rng, 1.0), "dam+slip": lambda rng: dam(rng, 1.0),
    "friction": friction, "dry": dry,
}


#: Errors below this are not compared: rounding and the grid make much of them.
LEAST = 2e-5
#: An error counts as measured when half as many cells change it by no more than this share of itself.
SETTLED = 0.25
#: Tolerances at which decisions are judged.
TOLERANCES = (1e-3, 3e-3, 1e-2)


class Measured(NamedTuple):
    """Errors of the depth of a model against the full one, over the mean depth, of one scene.

    ``predicted``, ``measured`` and ``coarse``, on half as many cells, are pairs (reduced, shallow water); ``seconds`` are
    those of the full model, the reduced one, shallow water.
    """

    kind: str
    predicted: tuple[float, float]
    measured: tuple[float, float]
    coarse: tuple[float, float]
    seconds: tuple[float, float, float]


def random_scene(kind: str, seed: int, index: int) -> Scene:
    """Return scene number ``index`` of a kind, the same for the same seed."""
    return KINDS[kind](np.random.default_rng([seed, list(KINDS).index(kind), index]))


def validate(count: int, seed: int = 1, cells: int = 400, backend: str = "auto",
             progress: Callable[[str], None] | None = None) -> list[Measured]:
    """Measure ``count`` random scenes of the kinds that the indicators are meant for, and a quarter as many of each other kind.

    Parameters
    ----------
    count : number of scenes of the kinds ``MEANT`` together, at least 4.
    seed : of the scenes.
    cells : number of cells of the coarser runs; the errors are those on twice as many.
    backend : as for `fvkit.solve`.
    progress : function that receives a line of text before each scene.

    Raises
    ------
    KeyboardInterrupt
        After Ctrl-C; its attribute ``result`` is the list of the scenes that are done, None where there are none.
    """
    each = -(-count // len(MEANT))
    plan = [(kind, index) for index in range(each) for kind in MEANT][:count]
    plan += [(kind, index) for kind in BEYOND for index in range(each)]
    rows: list[Measured] = []
    with keeping(lambda: rows or None):
        for number, (kind, index) in enumerate(plan):
            if progress is not None:
                progress(f"scene {number + 1}/{len(plan)}: {kind}")
            scene = random_scene(kind, seed, index)
            found = indicators(scene)
            coarse, _ = model_errors(scene, cells, backend)
            measured, seconds = model_errors(scene, 2 * cells, backend)
            rows.append(Measured(kind, (found.reduced, found.shallow), measured, coarse, seconds))
    return rows


def quality(rows: Sequence[Measured], which: int) -> dict[str, float]:
    """Return how well one model's error is predicted: n, Spearman, median of predicted/measured, shares within 2 and 3.

    Parameters
    ----------
    rows : the scenes.
    which : 0 for the reduced model, 1 for shallow water.
    """
    from scipy.stats import spearmanr

    kept = [row for row in rows if row.measured[which] > LEAST
            and abs(row.measured[which] - row.coarse[which]) < SETTLED * row.measured[which]]
    predicted = np.array([row.predicted[which] for row in kept])
    measured = np.array([row.measured[which] for row in kept])
    ratio = predicted / measured
    return {"n": len(kept), "spearman": float(spearmanr(predicted, measured).statistic), "median": float(np.median(ratio)),
            "within 2": float(np.mean((ratio > 0.5) & (ratio < 2.0))),
            "within 3": float(np.mean((ratio > 1.0 / 3.0) & (ratio < 3.0)))}


def decisions(rows: Sequence[Measured], tol: float) -> dict[str, float]:
    """Return the shares of scenes where the cheapest model that keeps ``tol`` is recommended, one that misses it, a dearer."""
    order = {"shallow-water": 0, "reduced": 1, "two-phase": 2}
    right = missed = rich = 0
    for row in rows:
        chosen = order[decide(*row.predicted, tol)]
        reduced, shallow = row.measured
        best = 0 if shallow < tol else 1 if reduced < tol else 2
        right, rich = right + (chosen == best), rich + (chosen > best)
        missed += (shallow, reduced, 0.0)[chosen] >= tol
    return {"right": right / len(rows), "misses": missed / len(rows), "rich": rich / len(rows)}


def report(rows: Sequence[Measured]) -> str:
    """Return the tables of `quality` and `decisions`, for all kinds in scope together and for every kind."""
    groups = {"in scope": [row for row in rows if row.kind in MEANT]}
    groups |= {kind: [row for row in rows if row.kind == kind] for kind in KINDS}
    lines = [["scenes", "model", "n", "Spearman", "median I/e", "within x2", "within x3"]]
    choices = [["scenes", "tol", "n", "right", "misses tol", "too costly"]]
    for name, group in groups.items():
        if len(group) < 3:
            continue
        for which, model in enumerate(("reduced", "shallow-water")):
            q = quality(group, which)
            lines.append([name, model, f"{q['n']}", f"{q['spearman']:.3f}", f"{q['median']:.2f}", f"{q['within 2']:.0%}",
                          f"{q['within 3']:.0%}"])
        for tol in TOLERANCES:
            d = decisions(group, tol)
            choices.append([name, f"{tol:g}", f"{len(group)}", f"{d['right']:.0%}", f"{d['misses']:.1%}", f"{d['rich']:.0%}"])
    note = (f"predicted over measured, I/e, for errors above {LEAST:g} that half as many cells change by less than "
            f"{SETTLED:.0%};\nkinds out of scope: {', '.join(BEYOND)}")
    return f"{table(lines)}\n\ndecisions with doubled indicators\n\n{table(choices)}\n\n{note}"


def main(arguments: Sequence[str] | None = None) -> int:
    """Validate on as many scenes as the command line says, print the tables, return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.tools.advice_validation", description="Measure the predictions of fvkit advise.")
    parser.add_argument("count", type=int, metavar="N", help="random scenes of the kinds that are meant, at least 4; and others")
    parser.add_argument("--seed", type=int, default=1, help="seed of the scenes (default 1)")
    parser.add_argument("--cells", type=int, default=400, help="cells of the coarser runs (default 400)")
    parser.add_argument("--backend", default="auto", choices=BACKENDS)
    options = parser.parse_args(arguments)
    if options.count < 4 or options.seed < 0 or options.cells < 10:
        parser.error("N must be >= 4, --seed >= 0, --cells >= 10")
    tell = progress_line()
    rows, stopped = done_so_far(partial(validate, options.count, options.seed, options.cells, options.backend, progress=tell))
    if tell is not None:
        tell("")
    print(report(rows))
    return INTERRUPTED if stopped else SUCCESS


if __name__ == "__main__":
    sys.exit(main())
