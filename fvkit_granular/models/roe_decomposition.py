"""`PressureCoupled`: two masses coupled by pressure alone, with their Roe linearisation."""

from abc import ABC, abstractmethod

import attrs
import numpy as np

from fvkit import maximum, minimum, where
from fvkit_granular.models.spectrum import quartic_discriminant, shifted_roots
from fvkit_granular.models.two_masses import TwoMasses, primitive
from fvkit_granular.models.wet_dry import threshold

#: Discriminant of the inner pair over g h above which its two speeds count as distinct; below it both waves have the mean speed.
DISTINCT = 1e-8

#: Round-off tolerance of the discriminant (of order 1) below 0, before a face counts as non-hyperbolic.
ROUNDING = 1e-12


@attrs.frozen
class PressureCoupled(TwoMasses, ABC):
    """Abstract model whose masses are coupled by pressure alone. Contract:

    ``flux``, ``push``, ``couplings``, ``balanced_difference`` and ``complex_slips`` define the model; ``push`` is consistent
    with A^, the matrix at arithmetic depths and sqrt-weighted velocities: A^ dq = jump on a flat bottom. Roe decomposition and
    eigenvalues follow from these.

    Examples
    --------
    At a face the waves of Roe's solver add up to the jump:

    >>> import numpy as np
    >>> import fvkit_granular as gr
    >>> model = gr.TwoPhase()
    >>> left, right = (1.2, 0.1, 0.8, 0.3), (0.9, 0.0, 0.7, 0.1)
    >>> jump = model.jump(left, right, (0.0,), (0.0,))
    >>> waves, speeds = model.decompose(left, right, (0.0,), (0.0,), jump)
    >>> np.allclose(np.sum(waves, axis=0), jump)
    True
    """

    def decompose(self, ql, qr, auxl, auxr, jump):
        hs, vs, hf, vf = self.linearised(ql, qr)
        coupled = self.couplings(hs, hf)
        css, cff, csf, _ = coupled
        a2 = self.g * (hs + hf)
        u1, u4, mu, disc = shifted_roots(coupled, vs, vf, a2, 1)
        distinct = disc > DISTINCT * a2
        half_gap = np.sqrt(where(distinct, disc, a2))
        middle, d = 0.5 * (vs + vf), 0.5 * (vs - vf)
        u3 = mu + half_gap
        l1, l4 = middle + u1, middle + u4
        l2, l3 = where(distinct, middle + (mu - half_gap), middle + mu), where(distinct, middle + u3, middle + mu)
        f1, f2, f3, f4 = jump
        x0, y0 = f2 - 2.0 * vs * f1, f4 - 2.0 * vf * f3
        e1, e4 = (u1 - u4) * ((u1 - mu) * (u1 - mu) - disc), (u4 - u1) * ((u4 - mu) * (u4 - mu) - disc)
        e3 = where(distinct, 2.0 * (u3 - u1) * (u3 - u4) * half_gap, a2)
        every = 1.0 / (e1 * e3 * e4)
        s1, t1 = project(every * (e3 * e4), u1, d, l1, f1, f3, x0, y0, css, cff, csf)
        s4, t4 = project(every * (e1 * e3), u4, d, l4, f1, f3, x0, y0, css, cff, csf)
        s3, t3 = project(every * (e1 * e4), u3, d, l3, f1, f3, x0, y0, css, cff, csf)
        rest = (f1 - s1 - s4, f2 - l1 * s1 - l4 * s4, f3 - t1 - t4, f4 - l1 * t1 - l4 * t4)
        z3 = (where(distinct, s3, 0.5 * rest[0]), where(distinct, l3 * s3, 0.5 * rest[1]),
              where(distinct, t3, 0.5 * rest[2]), where(distinct, l3 * t3, 0.5 * rest[3]))
        z2 = (rest[0] - z3[0], rest[1] - z3[1], rest[2] - z3[2], rest[3] - z3[3])
        return ((s1, l1 * s1, t1, l1 * t1), z2, z3, (s4, l4 * s4, t4, l4 * t4)), (l1, l2, l3, l4)

    def hyperbolic_discriminant(self, ql, qr):
        hs, vs, hf, vf = self.roe_mean(ql, qr)
        both = (hs > 0.0) & (hf > 0.0) & (hs + hf > threshold(self.dry))
        (least, most), slip = self.complex_slips(hs, hf), (vs - vf) * (vs - vf)
        both = both & (slip > least) & (slip < most)  # elsewhere rounding decides the sign of the discriminant, in films
        found = quartic_discriminant(self.couplings(hs, hf), vs, vf, self.g * (hs + hf)) + ROUNDING
        return where(both, found, 1.0)

    def may_lose_hyperbolicity(self, ql, qr):
        (hsl, vsl, hfl, vfl), (hsr, vsr, hfr, vfr) = self.layers(ql), self.layers(qr)
        hs, hf = 0.5 * (hsl + hsr), 0.5 * (hfl + hfr)
        # The velocities of the Roe mean are between those of both sides.
        ahead, behind = minimum(vsl, vsr) - maximum(vfl, vfr), maximum(vsl, vsr) - minimum(vfl, vfr)
        smallest, largest = maximum(0.0, maximum(ahead, -behind)), maximum(-ahead, behind)
        least, most = self.complex_slips(hs, hf)
        return (hs + hf > threshold(self.dry)) & (largest * largest > least) & (smallest * smallest < most)

    @abstractmethod
    def complex_slips(self, hs, hf):
        """Return bounds of the squares of slips at which speeds are complex, m^2/s^2; between them some are real."""

    def eigenvalues(self, q: np.ndarray) -> np.ndarray:
        """Return the characteristic speeds, (4, n), complex, sorted by real part; both masses must be present."""
        hs, vs, hf, vf = primitive(q)
        u1, u4, mu, disc = shifted_roots(self.couplings(hs, hf), vs, vf, self.g * (hs + hf))
        gap = np.sqrt(disc.astype(complex))
        return 0.5 * (vs + vf) + np.array([u1 + 0j, mu - gap, mu + gap, u4 + 0j])

    def margin(self, q: np.ndarray) -> np.ndarray:
        """Return the discriminant of the inner pair over a^2 = g h, (n,): negative where the speeds are complex."""
        hs, vs, hf, vf = primitive(q)
        a2 = self.g * (hs + hf)
        return shifted_roots(self.couplings(hs, hf), vs, vf, a2)[3] / a2


def project(weight, u, d, speed, f1, f3, x0, y0, css, cff, csf):
    """Return the two depth components of the wave with shifted speed u: the projection of the jump by the left eigenvector.

    There is no division by hs or hf, so the result is valid where a phase vanishes.
    """
    x, y = speed * f1 + x0, speed * f3 + y0
    up, down = u + d, u - d
    return weight * ((up * up - cff) * x + csf * y), weight * (cff * x + (down * down - css) * y)
