"""Drag between solid and fluid."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit import Source
from fvkit._validate import within
from fvkit_granular.slip import drag_rate, slip_momentum


@attrs.frozen
class ConstantDrag(Source):
    """Drag F_D = D h (vf - vs) on the fluid, gamma F_D on the solid, with constant D.

    The slip decays as w(t) = w(0) exp(-D K t), K = h (hs + gamma hf)/(hs hf); depths and mixture momentum stay. Exact
    in a step, for any D and dt.

    Parameters
    ----------
    D : drag coefficient, 1/s, >= 0 (already divided by the density of the fluid).

    Source: Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885, (3.6); closed form derived here.
    """

    between_phases: ClassVar[bool] = True

    D: float = attrs.field(converter=within(at_least=0.0, hint="drag coefficient in 1/s"))  # type: ignore[misc]

    def step(self, model, q, aux, dt):
        hs, ms, hf, mf = q
        lost = 1.0 - np.exp(-self.D * dt * drag_rate(hs, hf, model.gamma))
        moved = lost * slip_momentum(hs, ms, hf, mf, model.gamma)
        return hs, ms + model.gamma * moved, hf, mf - moved

    def rate(self, model, q, aux):
        hs, ms, hf, mf = q
        force = self.D * (hs + hf) * (mf / hf - ms / hs)
        return 0.0 * hs, model.gamma * force, 0.0 * hf, -force
