"""The two-phase shallow granular flow model of Pelanti, Bouchut and Mangeney."""

from typing import ClassVar

import attrs

from fvkit.output.citation import Work
from fvkit.pointwise.polynomial import exchange, product_slope, total
from fvkit_granular.models.literature import PELANTI_2008
from fvkit_granular.models.mixture import Mixture
from fvkit_granular.models.roe_decomposition import PressureCoupled
from fvkit_granular.models.two_masses import advected


@attrs.frozen
class TwoPhase(Mixture, PressureCoupled):
    """Two-phase model: solid and fluid in one shallow layer, q = (hs, hs vs, hf, hf vf), (3.5).

    ::

        hs_t + (hs vs)_x = 0,  hf_t + (hf vf)_x = 0,
        (hs vs)_t + (hs vs^2 + g/2 hs^2 + g (1-gamma)/2 hs hf)_x + gamma g hs hf_x = -g hs b_x,
        (hf vf)_t + (hf vf^2 + g/2 hf^2)_x + g hf hs_x = -g hf b_x.

    Parameters
    ----------
    g : gravity, m/s^2, positive.
    gamma : density ratio fluid/solid in (0, 1).
    dry : depth of a phase, m, below which its velocity is damped: thinner films do not move. None: 1e-8 of the largest
        initial depth, at least 1e-30 m, and 1e-9 m where all is dry; with smaller values ever thinner films limit the time step.

    Notes
    -----
    Hyperbolic while |vs - vf| <= 2 a beta or >= 2 a, with a^2 = g h, beta^2 = (1-phi)(1-gamma)/2 (sufficient, 4.16).
    Elsewhere the inner speeds may be complex, and the problem is then ill-posed. The Roe decomposition keeps the outer
    waves and assigns the mean speed to the inner pair; ``stats.nonhyperbolic_faces`` counts the faces.

    Source: Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885. Roe averages: the velocity means of the paper with
    arithmetic depths, derived here to satisfy A^ dq = df + w^ exactly.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> model = gr.TwoPhase(gamma=0.5)
    >>> q = model.conserved_from(h=1.0, phi=0.6, vs=1.0, vf=2.0)
    >>> q.tolist()
    [0.6, 0.6, 0.4, 0.8]
    >>> [round(float(speed), 6) for speed in model.wave_speeds(tuple(q))]
    [-2.132092, 5.132092]
    """

    cite: ClassVar[tuple[Work, ...]] = (PELANTI_2008,)

    def cell_integral(self, ql, qr, q, aux):
        hs, _, hf, _ = q
        solid, fluid = advected(self.layers(ql), self.layers(qr))
        surface, g = total(hs, hf, aux[0]), self.g
        return (qr[1] - ql[1], solid + g * (product_slope(hs, surface) + 0.5 * (1.0 - self.gamma) * exchange(hf, hs)),
                qr[3] - ql[3], fluid + g * product_slope(hf, surface))

    def complex_slips(self, hs, hf):
        return 2.0 * self.g * (1.0 - self.gamma) * hf, 4.0 * self.g * (hs + hf)
