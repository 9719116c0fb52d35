"""Steady shallow-water flow over a bottom: Bernoulli's equation, with or without a hydraulic jump.

Exact: h v = q and q^2/(2 g h^2) + h + b = E on every smooth piece, that is the cubic

    h^3 + (b - E) h^2 + q^2/(2 g) = 0,

whose two positive roots are the subcritical and the supercritical depth; across a hydraulic jump
q^2/h + g h^2/2 is continuous. Classical. For uniform phi and vs = vf, with any drag, these are steady flows of the
two-phase model too. Accuracy: rounding, and the square root of it beside a critical point.
"""

import numpy as np
from numpy.typing import ArrayLike

from fvkit.validation import array, choice, real
from fvkit_granular.exact.states import FloatArray
from fvkit_granular.models.quantities import critical_depth

REGIMES = ("subcritical", "supercritical", "transcritical", "jump")
#: What the flow may be choked by, relatively, and still be called critical: rounding.
ROUNDING = 1e-12


def bernoulli_depth(b: ArrayLike, q: float, energy: float, branch: str = "subcritical", g: float = 9.81) -> FloatArray:
    """Return the depth of a steady flow of given discharge and energy head.

    With s = (E - b)/3 and sin^2(3 a/2) = q^2/(8 g s^3) the roots of the cubic are s (1 + 2 cos a),
    subcritical, and s (2 sin^2(a/2) + sqrt(3) sin a), supercritical.

    Parameters
    ----------
    b : bottom, m, any shape.
    q : discharge h v, m^2/s.
    energy : head E = v^2/(2 g) + h + b, m.
    branch : ``"subcritical"`` or ``"supercritical"``.
    g : gravity, m/s^2.

    Returns
    -------
    Depth, m, of the shape of ``b``.

    Raises
    ------
    ValueError
        Where the head is below what the discharge needs, 1.5 critical depths above the bottom (choked).
    """
    bottom, q, energy = array(b, "b"), real(q, "q"), real(energy, "energy")
    g = real(g, "g", above=0.0)
    branch = choice(branch, "branch", ("subcritical", "supercritical"))
    needed = 1.5 * critical_depth(q, g)
    head = energy - bottom
    if np.any(head < needed * (1.0 - ROUNDING)) or np.any(head <= 0.0):
        raise ValueError(f"choked flow: a discharge of {q:g} m^2/s needs a head of {needed:.6g} m above the bottom, but only "
                         f"{np.min(head):.6g} m are left above the crest b = {np.max(bottom):.6g}; lower the crest or q, or "
                         "raise the depth")
    s = head / 3.0
    a = 2.0 / 3.0 * np.arcsin(np.sqrt(np.minimum(q * q / (8.0 * g * s**3), 1.0)))
    if branch == "subcritical":
        return s * (1.0 + 2.0 * np.cos(a))
    return s * (2.0 * np.sin(0.5 * a) ** 2 + np.sqrt(3.0) * np.sin(a))


def steady_flow(b: ArrayLike, q: float, h_out: float | None = None, regime: str = "subcritical", g: float = 9.81) -> FloatArray:
    """Return the depth of the steady flow of discharge ``q`` to the right over the bottom ``b``.

    Parameters
    ----------
    b : bottom at points in order of x, (n,), m. A transcritical flow is critical at its highest value,
        so include the crest among the points.
    q : discharge h v > 0, m^2/s.
    h_out : depth at the last point, m; not used (None) for ``"transcritical"``, which has no choice.
    regime : ``"subcritical"`` or ``"supercritical"`` throughout; ``"transcritical"``, smoothly from sub- to
        supercritical at the crest; ``"jump"``, the same and back to ``h_out`` through a hydraulic jump
        downstream, placed between two points.
    g : gravity, m/s^2.

    Returns
    -------
    Depth (n,), m.

    Raises
    ------
    ValueError
        Where no such flow exists: choked by the crest, ``h_out`` of the other regime, or a jump that would be
        drowned or swept out, see the message.
    """
    bottom = array(b, "b")
    if bottom.ndim != 1 or bottom.size < 2:
        raise ValueError(f"`b` must be a 1D array of at least two points, got shape {bottom.shape}")
    q, g = real(q, "q", above=0.0), real(g, "g", above=0.0)
    regime = choice(regime, "regime", REGIMES)
    hc = critical_depth(q, g)
    crest = int(np.argmax(bottom))
    over = 1.5 * hc + float(bottom[crest])
    if regime == "transcritical":
        return _over_crest(bottom, q, over, crest, g)
    if h_out is None:
        raise ValueError(f"`h_out`, the depth at the last point, is needed for the {regime} regime")
    h_out = real(h_out, "h_out", above=0.0)
    if (h_out < hc) != (regime == "supercritical"):
        raise ValueError(
            f"`h_out` must be {'below' if regime == 'supercritical' else 'at least'} the critical depth {hc:.6g} m of "
            f"q = {q:g} for the {regime} regime, got {h_out:g}"
        )
    energy = q * q / (2.0 * g * h_out * h_out) + h_out + float(bottom[-1])
    if regime != "jump":
        return bernoulli_depth(bottom, q, energy, regime, g)
    return _with_jump(bottom, q, energy, over, crest, g)


def _over_crest(bottom: FloatArray, q: float, energy: float, crest: int, g: float) -> FloatArray:
    """Return the smooth transcritical depth: subcritical before the crest, supercritical behind it."""
    before, behind = (bernoulli_depth(bottom, q, energy, branch, g) for branch in ("subcritical", "supercritical"))
    return np.where(np.arange(bottom.size) <= crest, before, behind)


def _with_jump(bottom: FloatArray, q: float, energy: float, over: float, crest: int, g: float) -> FloatArray:
    """Return the transcritical depth that jumps back to the subcritical flow of head ``energy``."""
    if energy >= over:
        raise ValueError(
            f"the jump is drowned: the head {energy:.6g} m at the outlet exceeds the critical head {over:.6g} m at the "
            "crest, so the flow is subcritical throughout; use regime=\"subcritical\" or lower h_out"
        )
    if np.any(np.diff(bottom[crest:]) > 0.0):
        raise ValueError("`b` must not rise again behind its crest for the jump regime: there its place is not unique")
    h = _over_crest(bottom, q, over, crest, g)
    # the subcritical flow of the outlet reaches up as far as its head suffices ...
    reached = np.arange(crest + 1, bottom.size)
    reached = reached[energy - bottom[reached] >= 1.5 * critical_depth(q, g)]
    after = bernoulli_depth(bottom[reached], q, energy, "subcritical", g)
    # ... and as it pushes harder than the supercritical flow that comes down from the crest
    holds = np.flatnonzero(_momentum(after, q, g) >= _momentum(h[reached], q, g))
    if holds.size == 0:
        raise ValueError(
            f"the jump is swept out: at the outlet the supercritical flow (h = {h[-1]:.6g} m) pushes harder than the "
            "depth h_out; raise h_out, or use regime=\"transcritical\" for the flow without a jump"
        )
    return np.concatenate([h[: reached[holds[0]]], after[holds[0] :]])


def _momentum(h: FloatArray, q: float, g: float) -> FloatArray:
    return q * q / h + 0.5 * g * h * h
