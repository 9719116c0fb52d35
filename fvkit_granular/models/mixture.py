"""`Mixture`: base class of models of solid and fluid mixed in one layer: flux, pressure and rest."""

from abc import ABC

import attrs

from fvkit_granular.models.spectrum import couplings
from fvkit_granular.models.two_masses import TwoMasses
from fvkit_granular.models.wet_dry import TINY, bed_step, upper


@attrs.frozen
class Mixture(TwoMasses, ABC):
    """Abstract model of a layer in which solid and fluid are mixed, with the flux and the pressure of (3.5).

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> from fvkit_granular.models.mixture import Mixture
    >>> [issubclass(model, Mixture) for model in (gr.TwoPhase, gr.PitmanLe, gr.TwoLayer)]
    [True, True, False]
    >>> [float(value) for value in gr.TwoPhase(g=10.0, gamma=0.5).flux((1.0, 0.0, 1.0, 0.0))]
    [0.0, 7.5, 0.0, 5.0]
    """

    def flux(self, q):
        hs, vs, hf, vf = self.layers(q)
        half = 0.5 * self.g
        return (hs * vs, hs * vs * vs + half * hs * (hs + (1.0 - self.gamma) * hf), hf * vf, hf * vf * vf + half * hf * hf)

    def push(self, left, right, bl, br):
        """Return the pressure, nonconservative and bottom terms of both momenta over a face, sides (hs, vs, hf, vf), (3.5).

        On the segment of the depths g hs^ d(h + b) + g (1-gamma)/2 (hf^ dhs - hs^ dhf), g hf^ d(h + b) vanish to rounding at
        rest.
        """
        (hsl, _, hfl, _), (hsr, _, hfr, _) = left, right
        hs, hf, dhs, dhf = 0.5 * (hsl + hsr), 0.5 * (hfl + hfr), hsr - hsl, hfr - hfl
        db, excess = bed_step(hsl + hfl, hsr + hfr, bl, br)
        surface = dhs + dhf + (db - excess)
        return (self.g * (hs * surface + upper(db, hsl, hsr) * excess + 0.5 * (1.0 - self.gamma) * (hf * dhs - hs * dhf)),
                self.g * (hf * surface + upper(db, hfl, hfr) * excess))

    def couplings(self, hs, hf):
        return couplings(hs, hf, self.g, self.gamma)

    def balanced_difference(self, ql, qr, auxl, auxr):
        """Return qr - ql with the bottom step added to the depths in proportion: 0 at rest with uniform phi."""
        (hsl, msl, hfl, mfl), (hsr, msr, hfr, mfr) = ql, qr
        solid, _, fluid, _ = self.lift((hsl + hsr, 0.0, hfl + hfr, 0.0), (auxr[0] - auxl[0],))
        return (hsr - hsl) + solid, msr - msl, (hfr - hfl) + fluid, mfr - mfl

    def lift(self, here, aux):
        """Return the equilibrium correction, the bottom divided in proportion to the depths."""
        hs, _, hf, _ = here
        solid = hs / (hs + hf + TINY) * aux[0]
        return solid, 0.0, aux[0] - solid, 0.0
