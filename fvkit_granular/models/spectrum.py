"""Characteristic speeds of two masses coupled by pressure: characteristic quartic, its roots and discriminant.

All functions are pointwise (scalars or arrays, branch-free) and shared by the Roe solver, the
public eigenvalues, the hyperbolicity margin and the exact solutions.

With u = lambda - (vs + vf)/2 and d = (vs - vf)/2 the characteristic polynomial (4.1) is

    P(u) = ((u - d)^2 - css) ((u + d)^2 - cff) - csf cfs,  cfs = cff,

with the pressure entries css, cff, csf of `couplings` (two phases) or `layer_couplings` (two layers).
"""

import numpy as np

from fvkit.pointwise import maximum

#: Added under square roots and to products of wave speeds, so that an absent phase gives
#: zero speed instead of 0/0: far below the square of any physical speed.
FLOOR = 1e-150


def couplings(hs, hf, g, gamma):
    """Return css, cff, csf of the two-phase matrix (3.6), and css cff - csf cff computed without cancellation.

    css = g (hs + (1-gamma)/2 hf),  cff = g hf,  csf = g (1+gamma)/2 hs;  the last is g h g (1-gamma)/2 hf.
    """
    half = 0.5 * g
    buoyant = half * (1.0 - gamma) * hf
    return g * hs + buoyant, g * hf, half * (1.0 + gamma) * hs, g * (hs + hf) * buoyant


def layer_couplings(hs, hf, g, gamma):
    """Return css = g hs, cff = g hf, csf = g gamma hs of two layers, hs below hf, and css cff - csf cff = (1-gamma) css cff."""
    css, cff = g * hs, g * hf
    return css, cff, gamma * css, (1.0 - gamma) * css * cff


def _newton_pair(u4, v1, d, sc, sf, middle, dp, dm, product):
    """Return both outer roots (v1 = -u1) after one Newton step in the surrogate form, with two divisions in total."""
    e4, f4, e1, f1 = u4 - d + sc, u4 + d + sf, v1 + d + sc, v1 - d + sf
    p4, p1 = e4 * f4, e1 * f1
    both = 1.0 / (p4 * p1)
    i4, i1 = both * p1, both * p4
    w4, w1 = product * i4, product * i1
    s4, s1 = np.sqrt(dp * dp + w4), np.sqrt(dm * dm + w1)
    g4, g1 = 2.0 * s4 + w4 * (e4 + f4) * i4, 2.0 * s1 + w1 * (e1 + f1) * i1
    both = 1.0 / (g4 * g1)
    return u4 - (u4 - middle - s4) * 2.0 * s4 * (both * g1), v1 - (v1 - middle - s1) * 2.0 * s1 * (both * g4)


def _depressed(css, cff, remainder, d):
    """Return the coefficients p2, q1, r of P(u) = u^4 + p2 u^2 + q1 u + r, with ``remainder`` = css cff - csf cfs."""
    trace, dd = css + cff, d * d
    return -2.0 * dd - trace, 2.0 * d * (cff - css), dd * dd - dd * trace + remainder


def discriminant(p2, q1, r, a2):
    """Return the discriminant of u^4 + p2 u^2 + q1 u + r over a2^6: the product of all squared differences of roots.

    Negative if and only if one pair of roots is complex.
    """
    share = 1.0 / a2
    p, q2, r = p2 * share, q1 * q1 * share * share * share, r * share * share
    pp = p * p
    return 16.0 * r * (pp - 4.0 * r) * (pp - 4.0 * r) - q2 * (4.0 * p * (pp - 36.0 * r) + 27.0 * q2)


def quartic_discriminant(coupled, vs, vf, a2):
    """Return the discriminant of (4.1) over (g h)^6, with ``a2`` = g h: negative if and only if the inner pair is complex.

    The outer roots are always real and distinct. ``coupled`` are `couplings` or `layer_couplings`.
    """
    css, cff, _, remainder = coupled
    p2, q1, r = _depressed(css, cff, remainder, 0.5 * (vs - vf))
    return discriminant(p2, q1, r, a2)


def shifted_roots(coupled, vs, vf, a2, polish=8):
    """Return u1, u4, mu, disc: the roots of (4.1) are vbar + (u1, mu -/+ sqrt(disc), u4).

    The outer roots, always real, come from two Newton steps on v = M + sqrt(D^2 + K/(E F)) (well
    conditioned where the system is strictly hyperbolic, also as phi tends to 0) and ``polish`` on the
    quartic; the inner pair by deflation. ``disc < 0`` means a complex inner pair.

    One polish is enough to rounding where the system is strictly hyperbolic. With less than 5 % of one
    phase and 2 a beta < |vs - vf| < 2 a an outer root nearly meets the inner pair; there one leaves up to
    3e-3 a, eight reach 1e-9 a. Two layers: 3e-7 a within the safe range of slip, eight 5e-10 a.

    ``coupled`` are `couplings` or `layer_couplings` of the depths, both positive; ``a2`` is g h, m^2/s^2, not below the square
    of an outer root at equal velocities.
    """
    css, cff, csf, remainder = coupled
    d = 0.5 * (vs - vf)
    p2, q1, r = _depressed(css, cff, remainder, d)
    sc, sf = np.sqrt(css), np.sqrt(cff)
    product = csf * cff + FLOOR
    middle, x, a = 0.5 * (sc + sf), 0.5 * (sc - sf), np.sqrt(a2)
    dp, dm = d + x, x - d
    u4, v1 = maximum(a, middle + np.abs(dp)), maximum(a, middle + np.abs(dm))
    u4, v1 = _newton_pair(u4, v1, d, sc, sf, middle, dp, dm, product)
    u4, v1 = _newton_pair(u4, v1, d, sc, sf, middle, dp, dm, product)
    u1 = -v1
    for _ in range(polish):
        x2, y2 = u4 * u4, u1 * u1
        e, t = (4.0 * x2 + 2.0 * p2) * u4 + q1, (4.0 * y2 + 2.0 * p2) * u1 + q1
        both = 1.0 / (e * t)
        u4 = u4 - (((x2 + p2) * u4 + q1) * u4 + r) * (both * t)
        u1 = u1 - (((y2 + p2) * u1 + q1) * u1 + r) * (both * e)
    mu = -0.5 * (u1 + u4)
    return u1, u4, mu, mu * mu - r / (u1 * u4)
