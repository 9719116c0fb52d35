"""The two-phase model with the fluid momentum of Pitman and Le."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit import maximum, minimum, where
from fvkit_granular.models.mixture import Mixture
from fvkit_granular.models.roe_decomposition import ROUNDING
from fvkit_granular.models.spectrum import discriminant
from fvkit_granular.models.two_masses import moving, primitive
from fvkit_granular.models.wet_dry import TINY


@attrs.frozen
class PitmanLe(Mixture):
    """Pitman-Le model: two phases as in `TwoPhase`, q = (hs, hs vs, hf, hf vf), with the fluid momentum of Pitman and Le.

    Their fluid equation, (h vf)_t + (h vf^2)_x + g/2 (h^2)_x = -g h b_x, times 1 - phi, is that of `TwoPhase` with one
    additional term on its left::

        (hf vf)_t + (hf vf^2 + g/2 hf^2)_x + g hf hs_x - (1-phi) vf (hs (vs - vf))_x = -g hf b_x.

    Parameters
    ----------
    g : gravity, m/s^2, positive.
    gamma : density ratio fluid/solid in (0, 1).
    dry : depth of a phase, m, below which its velocity is damped: thinner films do not move. None: 1e-8 of the largest
        initial depth, at least 1e-30 m; 1e-9 m where all is dry.

    Notes
    -----
    The path of the jump is the segment in (hs, hf, k, S), k = (1-phi) vf, S = hs (vs - vf): on it the new product is
    -(kl + kr)/2 dS exactly, and the other terms are those of `TwoPhase`. The new product vanishes at rest and where vs = vf,
    where both models agree. An absent fluid has the velocity of the solid, S = 0.

    The term depends on vf itself, not on the slip. So the model is not Galilean invariant, and it conserves the momentum of
    the mixture only where the equations of `TwoPhase` hold; smooth flow over a flat bottom conserves h vf instead. At
    vs = vf = v its speeds are v -/+ a and v + phi v/2 -/+ sqrt((phi v)^2/4 + a^2 beta^2). The inner pair can coincide with an
    outer speed, so that a small slip makes speeds complex in fast flow, |phi v| near a (1 - beta^2).

    Real speeds lie between min(vs, vf - u-) - a and max(vs, vf + u+) + a, u-/+ = phi max(-/+ vf - a, 0): outside, w = l - vf,
    ((l-vs)^2 - css) (w^2 - phi vf w - cff) - csf (cff - (1-phi) vf w) is positive. Where |vf| <= a these are the bounds of
    `TwoPhase`. There is no Roe decomposition; use HLL, Rusanov or Relaxation.

    Source: equation (2.2d) and (3.3) of Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885, after Pitman and Le (2005);
    path, matrix, bounds and cross term derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> model = gr.PitmanLe(gamma=0.5)
    >>> model.conserved_from(h=1.0, phi=0.6, vs=1.0, vf=2.0).tolist()
    [0.6, 0.6, 0.4, 0.8]
    """

    dimensions: ClassVar[int] = 1

    def wave_speeds(self, q):
        hs, vs, hf, vf = self.layers(q)
        a = np.sqrt(self.g) * np.sqrt(hs + hf)
        vs, vf = moving(hs, vs, hf, vf)
        back, forth = outrun((hs, vs, hf, vf), a)
        return minimum(vs, vf - back) - a, maximum(vs, vf + forth) + a

    def sound(self, left, right, bl, br):
        al, ar = super().sound(left, right, bl, br)
        (backl, _), (_, forthr) = outrun(left, al), outrun(right, ar)
        return al + backl, ar + forthr

    def push(self, left, right, bl, br):
        solid, fluid = super().push(left, right, bl, br)
        (kl, sl), (kr, sr) = slipping(left), slipping(right)
        return solid, fluid - 0.5 * (kl + kr) * (sr - sl)

    def at_state(self, state, v):
        hs, _, hf, vf = state
        first, second, third, fourth = super().at_state(state, v)
        share = 1.0 / (hs + hf + TINY)
        return first, second, third, fourth - vf * share * (hf * (v[1] - vf * v[0]) - hs * (v[3] - vf * v[2]))

    def cross(self, ql, qr, auxl, auxr):
        zero, solid, _, fluid = super().cross(ql, qr, auxl, auxr)
        first, second, third, fourth = self.jump(ql, qr, auxl, auxr)
        (kl, sl), (kr, sr) = slipping(self.layers(ql)), slipping(self.layers(qr))
        hs, _, hf, vf = self.roe_mean(ql, qr)
        k_rate = (fourth - 0.5 * (kl + kr) * (first + third)) / (hs + hf + TINY)
        s_rate = second - vf * first - hs * ((fourth - vf * third) / (hf + TINY))
        return zero, solid, zero, fluid + ((kr - kl) * s_rate - k_rate * (sr - sl))

    def hyperbolic_discriminant(self, ql, qr):
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        css, cff, csf, _ = self.couplings(hs, hf)
        h = hs + hf + TINY
        excess, rest = vf * (hs / h), vf * (hf / h)
        d = 0.25 * (2.0 * (vs - vf) - excess)
        e = vf - vs + d
        solid, fluid = d * d - css, e * e + excess * e - cff
        return discriminant(solid + fluid - 4.0 * d * d, 2.0 * d * (solid - fluid) + csf * rest,
                            solid * fluid - csf * (cff + rest * e), self.g * h) + ROUNDING

    def eigenvalues(self, q: np.ndarray) -> np.ndarray:
        """Return the characteristic speeds (4, n), complex, sorted by real part; both phases present. By LAPACK."""
        return np.sort_complex(np.linalg.eigvals(np.moveaxis(self.matrix(q), -1, 0))).T.astype(complex)

    def margin(self, q: np.ndarray) -> np.ndarray:
        """Return the square of half the smallest difference of neighbouring speeds over a^2 = g h, (n,).

        Negative where a pair of speeds is complex.
        """
        hs, _, hf, _ = primitive(q)
        return np.min((np.diff(self.eigenvalues(q), axis=0) ** 2).real, axis=0) / (4.0 * self.g * (hs + hf))


def outrun(layers, a):
    """Return the excess of wave speeds beyond vf - a and vf + a, m/s: phi (|vf| - a) upstream or downstream of fast flow."""
    hs, _, hf, vf = layers
    share = hs / (hs + hf + TINY)
    return share * maximum(-vf - a, 0.0), share * maximum(vf - a, 0.0)


def slipping(layers):
    """Return k = (1 - phi) vf and S = hs (vs - vf), 0 where the fluid is absent."""
    hs, vs, hf, vf = layers
    return hf * vf / (hs + hf + TINY), where(hf > 0.0, hs * (vs - vf), 0.0)
