"""`steady`: moving equilibria over a bottom, exact profiles and those that a scheme keeps to rounding."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import attrs
import numpy as np

from fvkit import Grid, Model
from fvkit.problem.cell_averages import cell_averages
from fvkit.validation import flag, function, instance, real
from fvkit.validation import interval as checked_interval
from fvkit_granular.exact.discrete_equilibrium import MORE_CELLS, march
from fvkit_granular.models.quantities import conserved, over, whole_flow
from fvkit_granular.models.roe_decomposition import PressureCoupled
from fvkit_granular.models.two_phase import TwoPhase

if TYPE_CHECKING:
    from fvkit_granular.exact.steady_curve import Discharges, Piece


#: Samples of the bottom that find its highest and its lowest point.
SAMPLES = 4001
#: What a discrete flow may be away from the exact one, relatively.
FAR = 0.3
#: Depths that may pass a crest are looked for in steps of this factor, up to this factor.
NEAR, WIDEST = 1.02, 10.0
#: What a crest may exceed the height that a flow can pass, in depths, and still be passed: rounding.
ROUNDING = 1e-12


@attrs.frozen(eq=False)
class MovingEquilibrium:
    """Moving equilibrium: a steady flow of two masses over a bottom, the result of `steady`.

    Attributes
    ----------
    model : the model whose steady flow it is.
    bottom : x (m,) -> b (m,), m.
    interval : (lower, upper), m.
    inflow : {h, phi, vs, vf} at x = ``place``.
    place : where the inflow holds, m.
    ms, mf : discharges hs vs, hf vf, m^2/s, the same everywhere.
    crest : highest point of a transcritical flow, m; None for a flow that stays on its branch.
    kind : ``"exact"``.

    Examples
    --------
    >>> import numpy as np
    >>> import fvkit_granular as gr
    >>> inflow = {"h": 1.0, "phi": 0.6, "vs": 0.8, "vf": -0.2}
    >>> flow = gr.steady(lambda x: 0.2 * np.exp(-(x - 5.0) ** 2), inflow, interval=(0.0, 10.0), at=0.0)
    >>> round(flow.ms, 3), round(flow.mf, 3), flow.kind
    (0.48, -0.08, 'exact')
    >>> flow.at(np.array([5.0]))["h"].round(3)
    array([0.8])
    """

    kind: ClassVar[str] = "exact"
    model: PressureCoupled
    bottom: Callable[[np.ndarray], np.ndarray] = attrs.field(repr=False)
    interval: tuple[float, float]
    inflow: Mapping[str, float]
    place: float
    flow: "Discharges" = attrs.field(repr=False)
    crest: float | None
    pieces: "tuple[Piece, ...]" = attrs.field(repr=False)

    @property
    def ms(self) -> float:
        """Discharge hs vs of the first mass, m^2/s."""
        return self.flow.ms

    @property
    def mf(self) -> float:
        """Discharge hf vf of the second mass, m^2/s."""
        return self.flow.mf

    def at(self, x: Any, t: float = 0.0) -> dict[str, np.ndarray]:
        """Return ``h``, ``phi``, ``vs``, ``vf`` at points ``x`` (any shape), at all times."""
        points = np.asarray(x, dtype=float)
        hs, hf = (depth.reshape(points.shape) for depth in self._depths(points.ravel()))
        return {"h": hs + hf, "phi": hs / (hs + hf), "vs": self.ms / hs, "vf": self.mf / hf}

    def _depths(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        b = np.broadcast_to(np.asarray(self.bottom(x), dtype=float), x.shape)
        above = b >= self.pieces[0].y_start[2]
        beyond = np.zeros(x.shape, dtype=bool)
        if self.crest is not None:
            beyond = (x > self.crest) != (self.place > self.crest)
        hs, hf = np.empty(x.shape), np.empty(x.shape)
        for piece, here in zip(self.pieces, (above & ~beyond, ~above & ~beyond, beyond), strict=False):
            hs[here], hf[here] = piece.depths(b[here])
        return hs, hf

    def averages(self, model: Model, grid: Grid) -> np.ndarray:
        """Return the cell averages (num_eqn, n) of the flow in the variables of ``model``.

        By Gauss's rule with five nodes in each cell: exact to rounding where kinks of the bottom lie on cell edges.
        """
        return cell_averages(conserved(model, self.at), grid, len(model.conserved), "steady flow")

    def discrete(self, model: Any, grid: Grid) -> np.ndarray:
        """Return the steady flow of the scheme, (num_eqn, n): ``model.jump`` is 0 to rounding at every face.

        Wave propagation, at order 1 or 2, with any solver whose waves sum up the jump (Roe), any limiter, keeps it to
        rounding. It differs from the exact averages by O(dx^2). Found face by face with Newton's method, starting in the
        cell of the inflow, or at the crest where the flow is transcritical; momenta are uniform.

        Parameters
        ----------
        model : a model with one momentum per mass, such as the one of the flow.
        grid : the grid; cell averages of the bottom are those of `fvkit.Problem`.

        Raises
        ------
        ValueError
            For a model that has more masses than momenta, or where Newton's method does not converge or finds another
            branch: beside a critical point on a coarse grid.
        """
        if any(len(masses) != 1 for masses, _ in model.phases) or not model.phases:
            raise ValueError(f"a discrete steady flow needs one momentum per mass, {type(model).__name__} has none such; use "
                             "`averages`")
        b = cell_averages(self.bottom, grid, None, "bottom")
        exact = self.averages(model, grid)
        q = exact.copy()
        momenta = [momentum for _, momentum in model.phases]
        q[momenta] = model.conserved_from(**self.inflow)[momenta, None]
        start = [int(np.clip((self.place - grid.lower) / grid.dx, 0, grid.num_cells - 1))]
        if self.crest is not None:
            start = list(np.flatnonzero(b >= b.max() - ROUNDING * np.ptp(b)))
            hs, hf, _ = self.pieces[0].y_end
            critical = model.conserved_from(hs + hf, hs / (hs + hf), self.ms / hs, self.mf / hf)
            q[:, start[0] : start[-1] + 1] = critical[:, None]
        march(model, q, b, start[0], start[-1], grid.centers)
        masses = list(model.mass_rows())
        away = np.abs(q[masses] / exact[masses] - 1.0).max(axis=0)
        if away.max() > FAR:
            raise ValueError(f"the discrete steady flow leaves the branch of the exact one beside x = "
                             f"{grid.centers[int(np.argmax(away > FAR))]:.6g}; {MORE_CELLS}")
        return q


def steady(bottom: Callable[[np.ndarray], Any], inflow: Mapping[str, float], interval: tuple[float, float],
           at: float | None = None, *, model: PressureCoupled | None = None, transcritical: bool = False) -> MovingEquilibrium:
    """Return the steady flow of two masses, (3.8), that is ``inflow`` at x = ``at``, over a bottom.

    hs vs = ms, hf vf = mf, and hs(b), hf(b) from  (css - vs^2) dhs + csf dhf = -g hs db,  cff dhs + (cff - vf^2) dhf = -g hf db.

    Parameters
    ----------
    bottom : x (m,) -> height b (m,), m; continuous. Its derivative is not needed.
    inflow : h, m, phi in (0, 1), vs, vf, m/s (0 where missing).
    interval : (lower, upper), m, of the profile.
    at : where the inflow holds, m, within the interval; default: its lower end.
    model : `TwoPhase` (default, gamma = 0.5) or `TwoLayer`.
    transcritical : a flow that becomes critical at the highest point of the bottom and continues behind it on the other
        branch. Such a flow has one datum less: discharges and phi of the inflow are kept, and its h adapted.

    Returns
    -------
    MovingEquilibrium, exact: ``.at(x)``, ``.averages(model, grid)`` and, for schemes, ``.discrete(model, grid)``.

    Raises
    ------
    ValueError
        Where no such flow exists: choked before the crest, complex characteristic speeds on the way, no depth that passes
        the crest. The message has the place and the remedy.
    TypeError
        For a model that has no such flows.

    Notes
    -----
    A flow that is transcritical for the outer waves is preserved with ``WavePropagation(..., entropy_fix=False)`` only, since
    the fix acts on it as on a transonic rarefaction. Flows on either side of the critical point of a wave, outer or inner, exist,
    and flows through it. For vs = vf and uniform phi the flow is that of one phase, `exact.steady_flow`.

    Source: Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885, (3.8); form in b derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> inflow = {"h": 1.0, "phi": 0.6, "vs": 0.3, "vf": 0.2}
    >>> flow = gr.steady(lambda x: 0.2 * np.exp(-(x - 5.0) ** 2), inflow, interval=(0.0, 10.0), at=0.0)
    >>> {name: round(float(value), 4) for name, value in flow.at(5.0).items()}
    {'h': 0.7989, 'phi': 0.5956, 'vs': 0.3783, 'vf': 0.2476}
    """
    from fvkit_granular.exact.steady_curve import discharges

    chosen = instance(TwoPhase() if model is None else model, "model", PressureCoupled, "gr.TwoPhase or gr.TwoLayer; for "
                      "gr.ShallowWater see exact.steady_flow")
    function(bottom, "bottom", "x -> height")
    lower, upper = checked_interval(interval, "interval")
    place = lower if at is None else real(at, "at", at_least=lower, at_most=upper)
    state = _state(inflow)
    x = np.unique(np.append(np.linspace(lower, upper, SAMPLES), place))
    b = over(x, bottom(x), "bottom(x)")
    if not np.isfinite(b).all():
        raise ValueError(f"`bottom` must be finite on the interval, got {b[~np.isfinite(b)][0]} at x = "
                         f"{x[~np.isfinite(b)][0]:g}")
    top, crest = _extreme(bottom, x, b, 1.0)
    low, _ = _extreme(bottom, x, b, -1.0)
    b0 = float(b[np.searchsorted(x, place)])
    hs, hf = state["phi"] * state["h"], (1.0 - state["phi"]) * state["h"]
    flow = discharges(chosen, hs, hf, state["vs"], state["vf"])
    if flag(transcritical, "transcritical"):
        _check_crest(x, b, crest, place, top - low)
        h = _passing(flow, state["h"], state["phi"], b0, top, low)
        state = {"h": h, "phi": state["phi"], "vs": flow.ms / (state["phi"] * h), "vf": flow.mf / ((1.0 - state["phi"]) * h)}
    pieces = _pieces(flow, state, b0, top, low, transcritical, (x, b))
    return MovingEquilibrium(chosen, bottom, (lower, upper), state, place, flow, crest if transcritical else None, pieces)


def _state(inflow: Mapping[str, float]) -> dict[str, float]:
    flow = whole_flow(inflow, name="inflow", what="`inflow`")
    return {"h": real(flow["h"], "h", above=0.0), "phi": real(flow["phi"], "phi", above=0.0, below=1.0),
            "vs": real(flow["vs"], "vs"), "vf": real(flow["vf"], "vf")}


def _extreme(bottom: Callable[[np.ndarray], Any], x: np.ndarray, b: np.ndarray, sign: float) -> tuple[float, float]:
    """Return the largest of sign b, times sign, and where it is: the best sample, improved between its neighbours."""
    k = int(np.argmax(sign * b))
    near = np.linspace(x[max(k - 1, 0)], x[min(k + 1, x.size - 1)], SAMPLES)
    fine = np.broadcast_to(np.asarray(bottom(near), dtype=float), near.shape)
    j = int(np.argmax(sign * fine))
    return (float(fine[j]), float(near[j])) if sign * fine[j] > sign * b[k] else (float(b[k]), float(x[k]))


def _check_crest(x: np.ndarray, b: np.ndarray, crest: float, place: float, height: float) -> None:
    """Raise ValueError unless the bottom has one highest point or plateau inside the interval, away from the inflow."""
    high = np.flatnonzero(b >= b.max() - 1e-9 * height)
    if height == 0.0 or high[0] == 0 or high[-1] == x.size - 1:
        raise ValueError(f"a transcritical flow needs its crest inside the interval, the bottom is highest at its end {crest:g}")
    if high[-1] - high[0] + 1 != high.size:
        raise ValueError(f"a transcritical flow needs one crest, the bottom is highest at {x[high[0]]:g} and {x[high[-1]]:g}")
    if x[high[0]] <= place <= x[high[-1]]:
        raise ValueError(f"`at` must not be the crest of a transcritical flow, got {place:g}: give the inflow before it")


def _heading(flow: "Discharges", hs: float, hf: float) -> float:
    """Return the direction of s in which b rises."""
    return 1.0 if flow.standing(hs, hf) > 0.0 else -1.0


def _pieces(flow: "Discharges", state: Mapping[str, float], b0: float, top: float, low: float, transcritical: bool,
            samples: tuple[np.ndarray, np.ndarray]) -> "tuple[Piece, ...]":
    """Return the curve upwards and downwards from the inflow, and, for a transcritical flow, down behind the crest."""
    from fvkit_granular.exact.steady_curve import follow

    h = state["h"]
    start = (state["phi"] * h, (1.0 - state["phi"]) * h, b0)
    rise = _heading(flow, *start[:2])
    up = follow(flow, start, rise, top + h if transcritical else top, top - low)
    if up.critical and not transcritical and up.y_end[2] < top - ROUNDING * h:
        raise ValueError(_choked(flow, up, samples, "rise"))
    down = follow(flow, start, -rise, low, top - low)
    if down.critical and down.y_end[2] > low + ROUNDING * h:
        raise ValueError(_choked(flow, down, samples, "fall"))
    if not transcritical:
        return up, down
    hs, hf, _ = up.y_end
    return up, down, follow(flow, (hs, hf, top), rise, low, top - low)


def _choked(flow: "Discharges", piece: "Piece", samples: tuple[np.ndarray, np.ndarray], way: str) -> str:
    hs, hf, height = piece.y_end
    x, b = samples
    sign = 1.0 if way == "rise" else -1.0
    where = float(x[np.argmax(sign * (b - height) > 0.0)])
    standing = int(np.argmin(np.abs(flow.speeds(hs, hf))))
    waves = "outer" if standing in (0, 3) else "inner"
    return (f"choked flow: with these discharges the {waves} waves stand at b = {height:.6g} (first at x = {where:.6g}), where "
            f"hs = {hs:.6g}, hf = {hf:.6g}, vs = {flow.ms / hs:.6g}, vf = {flow.mf / hf:.6g}; the bottom goes on to {way} by "
            f"{(sign * (b - height)).max():.6g} m; lower the crest or the discharges, raise the depth, or choose "
            "transcritical=True, which adapts the depth")


def _passing(flow: "Discharges", h: float, phi: float, b0: float, top: float, low: float) -> float:
    """Return the depth nearest to ``h`` with which the flow is critical exactly at the crest."""
    from scipy.optimize import brentq

    from fvkit_granular.exact.steady_curve import Lost, follow

    def excess(depth: float) -> float:
        hs, hf = phi * depth, (1.0 - phi) * depth
        piece = follow(flow, (hs, hf, b0), _heading(flow, hs, hf), top + depth, top - low)
        return float(piece.y_end[2]) - top if piece.critical else depth

    sign = np.sign(flow.standing(phi * h, (1.0 - phi) * h))
    start = excess(h)
    seen = {h: start}
    for factor in (NEAR, 1.0 / NEAR):
        near, value = h, start
        while 1.0 / WIDEST < near / h < WIDEST:
            further = near * factor
            if np.sign(flow.standing(phi * further, (1.0 - phi) * further)) != sign:
                break
            try:
                found = excess(further)
            except Lost:
                break
            if found * value <= 0.0:
                depth = float(brentq(excess, near, further, xtol=1e-16, rtol=1e-15))
                # where two critical points exchange their roles the height that can be passed jumps through the crest
                if abs(excess(depth)) < 1e-9 * h:
                    return depth
            near, value = further, found
            seen[near] = value
    raise ValueError(f"no transcritical flow: with depths from {min(seen):.6g} to {max(seen):.6g} m at the inflow it is critical "
                     f"between {min(seen.values()):.3g} and {max(seen.values()):.3g} m above the crest; change discharges or phi")
