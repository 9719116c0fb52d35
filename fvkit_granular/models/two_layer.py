"""Two-layer shallow water model."""

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from fvkit.pointwise.polynomial import product_slope, total
from fvkit_granular.models.beyond_the_end import deepened, deepening
from fvkit_granular.models.quantities import LAYERS, bottom, solid_and_fluid
from fvkit_granular.models.roe_decomposition import PressureCoupled
from fvkit_granular.models.spectrum import layer_couplings
from fvkit_granular.models.two_masses import advected
from fvkit_granular.models.wet_dry import bed_step, upper


@attrs.frozen
class TwoLayer(PressureCoupled):
    """Two-layer shallow water: a light layer (hf, vf) above a dense one (hs, vs), q = (hs, hs vs, hf, hf vf).

    ::

        hs_t + (hs vs)_x = 0,  hf_t + (hf vf)_x = 0,
        (hs vs)_t + (hs vs^2 + g/2 hs^2)_x + gamma g hs hf_x = -g hs b_x,
        (hf vf)_t + (hf vf^2 + g/2 hf^2)_x + g hf hs_x = -g hf b_x.

    Variables are named as in `TwoPhase`, whose equations have the additional term g (1-gamma)/2 hs hf. hs is the depth of the
    lower layer, hf that of the upper one, phi = hs/h. Layers do not mix; drag acts at their interface.

    Parameters
    ----------
    g : gravity, m/s^2, positive.
    gamma : density ratio upper/lower in (0, 1).
    dry : depth of a layer, m, below which its velocity is damped: thinner films do not move. None: 1e-8 of the largest
        initial depth, at least 1e-30 m; 1e-9 m where all is dry.

    Notes
    -----
    At rest surface h + b and interface hs + b are level, and hf (not phi) is constant. Speeds are real while::

        |vs - vf| <= s sqrt(1 - sqrt(gamma))  or  >= s sqrt(1 + sqrt(gamma)),   s = sqrt(g hs) + sqrt(g hf)

    (sufficient, derived here: the polynomial is positive at d (sqrt(cff) - sqrt(css))/(sqrt(css) + sqrt(cff)), d half the
    slip, between points where it is negative).

    Source: equations classical; jump on the segment of the depths, balanced at emerging layers, derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> model = gr.TwoLayer(gamma=0.8)
    >>> model.conserved_from(h=2.0, phi=0.25, vs=1.0, vf=2.0).tolist()
    [0.5, 0.5, 1.5, 3.0]
    """

    quantities: ClassVar[Mapping[str, tuple[str, str]]] = LAYERS

    def thicknesses(self, seen: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        lower, above = solid_and_fluid(seen).values()
        return {"lower layer": lower, "upper layer": above}

    def flux(self, q):
        hs, vs, hf, vf = self.layers(q)
        half = 0.5 * self.g
        return hs * vs, hs * vs * vs + half * hs * hs, hf * vf, hf * vf * vf + half * hf * hf

    def push(self, left, right, bl, br):
        (hsl, _, hfl, _), (hsr, _, hfr, _) = left, right
        hs, hf, dhs, dhf = 0.5 * (hsl + hsr), 0.5 * (hfl + hfr), hsr - hsl, hfr - hfl
        db, excess = bed_step(hsl + hfl, hsr + hfr, bl, br)
        _, beyond = bed_step(hsl, hsr, bl, br)
        surface, interface = dhs + dhf + (db - excess), dhs + (db - beyond)
        own = upper(db, hsl, hsr)
        return (self.g * (self.gamma * (hs * surface + own * excess) + (1.0 - self.gamma) * (hs * interface + own * beyond)),
                self.g * (hf * surface + upper(db, hfl, hfr) * excess))

    def couplings(self, hs, hf):
        return layer_couplings(hs, hf, self.g, self.gamma)

    def balanced_difference(self, ql, qr, auxl, auxr):
        (hsl, msl, hfl, mfl), (hsr, msr, hfr, mfr) = ql, qr
        db, excess = bed_step(hsl + hfl, hsr + hfr, auxl[0], auxr[0])
        _, beyond = bed_step(hsl, hsr, auxl[0], auxr[0])
        return (hsr - hsl) + (db - beyond), msr - msl, (hfr - hfl) + (beyond - excess), mfr - mfl

    def beyond(self, q, slopes, distance):
        hs, ms, hf, mf = q
        lower, slow, left = deepened(hs, deepening(self, q, slopes[0], distance), self.dry)
        upper, fast, _ = deepened(hf, left, self.dry)
        return lower * hs, slow * ms, upper * hf, fast * mf

    def lift(self, here, aux):
        return aux[0], 0.0, 0.0, 0.0

    def cell_integral(self, ql, qr, q, aux):
        hs, _, hf, _ = q
        solid, fluid = advected(self.layers(ql), self.layers(qr))
        surface, g = total(hs, hf, aux[0]), self.g
        return (qr[1] - ql[1], solid + g * (product_slope(hs, surface) - (1.0 - self.gamma) * product_slope(hs, hf)),
                qr[3] - ql[3], fluid + g * product_slope(hf, surface))

    def complex_slips(self, hs, hf):
        roots, share = np.sqrt(hs) + np.sqrt(hf), np.sqrt(self.gamma)
        scale = self.g * roots * roots
        return (1.0 - share) * scale, (1.0 + share) * scale

    def observables(self, q: np.ndarray, aux: Mapping[str, np.ndarray] | None = None) -> dict[str, np.ndarray]:
        """Return h, phi = hs/h, vs, vf, the momentum mean v, the surface h + b, and the interface hs + b."""
        return super().observables(q, aux) | {"interface": q[0] + bottom(aux, q[0])}
