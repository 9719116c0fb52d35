"""Plots of two-phase flow: slip velocity, and accuracy of a scheme."""

from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fvkit import RiemannSolver, Scheme, Solution, WavePropagation, convergence, solve
from fvkit.output.figures import COLORS, new_axes, slope_guides, style
from fvkit_granular.models.two_phase import TwoPhase
from fvkit_granular.scenes.library.catalogue import scene

#: Scenes of `accuracy`: one with all kinds of waves and a smooth one, both with an exact or semi-exact reference.
JUMPS, SMOOTH = "dam-break-phi", "simple-wave"

#: Depth of a phase relative to the largest depth below which the slip is not plotted.
THIN = 1e-4


def slip(solution: Solution, ax: Axes | None = None, i: int = -1) -> Axes:
    """Plot the slip vf - vs at output ``i``, m/s, where both phases are deeper than 1/10000 of the largest depth.

    Parameters
    ----------
    solution : solution of a model with two velocities.
    ax : axes; None for a new figure.
    i : number of the output, the last by default.

    Raises
    ------
    ValueError
        For a model with one velocity, or a grid with two axes.

    Examples
    --------
    >>> import fvkit as fv, fvkit_granular as gr
    >>> solution = fv.solve(gr.scene("riemann").problem(gr.TwoPhase, 100), backend="numpy")
    >>> gr.plots.slip(solution).get_ylabel()
    'slip vf - vs, m/s'
    """
    if len(solution.grid.axes) > 1:
        raise ValueError("the slip is drawn over one axis, got a grid with two: take solution.plot(kind='vectors', vector='vs')")
    seen = solution.observables(i)
    if "vs" not in seen or "vf" not in seen:
        raise ValueError(f"{type(solution.model).__name__} has one velocity, hence no slip")
    target = ax if ax is not None else new_axes()[1][0]
    thinner = seen["h"] * np.minimum(seen["phi"], 1.0 - seen["phi"])
    shown = np.where(thinner > THIN * seen["h"].max(), seen["vf"] - seen["vs"], np.nan)
    target.plot(solution.grid.centers, shown, color=COLORS[0])
    target.axhline(0.0, color="0.4", linewidth=0.8)
    target.set(xlabel="x, m", ylabel="slip vf - vs, m/s", title=f"{type(solution.model).__name__}, t = {solution.t[i]:.4g}")
    target.grid(alpha=0.3)
    return target


def accuracy(scheme: Scheme | RiemannSolver, cells: Sequence[int] = (50, 100, 200, 400), *, backend: str = "auto") -> Figure:
    """Return a figure of the accuracy of a scheme for the two-phase model: a dam break with a jump of phi, and errors over cells.

    Left: solid depth on the coarsest and the finest grid, with the semi-exact solution. Right: L1 errors summed over the four
    components of q, for the dam break and for a smooth simple wave with an exact reference.

    Parameters
    ----------
    scheme : the scheme, or a Riemann solver for second-order `fvkit.WavePropagation`.
    cells : numbers of cells, ascending, at least two.
    backend : as for `fvkit.solve`.

    Examples
    --------
    >>> import fvkit as fv, fvkit_granular as gr
    >>> figure = gr.plots.accuracy(fv.WavePropagation(fv.Roe()), cells=(25, 50), backend="numpy")
    >>> figure.savefig("accuracy.pdf")  # doctest: +SKIP
    """
    chosen = WavePropagation(scheme) if isinstance(scheme, RiemannSolver) else scheme
    figure, (profile, error) = new_axes(1, 2, width=5.2, height=3.8)
    jumps = scene(JUMPS)
    for color, count in zip(COLORS, (cells[0], cells[-1]), strict=False):
        solution = solve(jumps.problem(TwoPhase, count), chosen, backend=backend)
        profile.plot(solution.grid.centers, solution.q[-1][0], color=color, linewidth=1.2,
                     label=f"{count} cells")
    known = jumps.known_reference()
    if known is None:
        raise ValueError(f"the scene {JUMPS} has no reference")
    reference = known.averages(TwoPhase(), solution.grid, jumps.t_end)
    profile.plot(solution.grid.centers, reference[0], color="0.35", linestyle="--", linewidth=0.9, label="semi-exact")
    profile.set(xlabel="x, m", ylabel="solid depth hs, m", title=f"{JUMPS}, t = {jumps.t_end:g} s")
    for k, (name, order) in enumerate(((JUMPS, 1), (SMOOTH, chosen.nominal_order))):
        case = scene(name)
        known = case.known_reference()
        found = convergence(partial(case.problem, TwoPhase), chosen, cells, known, backend=backend)
        error.loglog(found.cells, found.totals, **style(k), markersize=5, label=f"{name} ({found.kind})")
        slope_guides(error, found.cells, float(found.totals[0]), (order,))
    error.set_xticks(list(cells), labels=list(map(str, cells)))
    error.minorticks_off()
    error.set(xlabel="cells", ylabel="L1 error of q", title="error over cells")
    for axes in (profile, error):
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small")
    return figure
