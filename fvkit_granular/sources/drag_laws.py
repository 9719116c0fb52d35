"""Laws of drag between solid and fluid: constant, growing with the slip, Pitman and Le."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit import maximum
from fvkit.problem.fields import number
from fvkit_granular.sources.drag import Drag, towards_balance
from fvkit_granular.sources.slip_decay import decay

#: The smallest 1 - phi that differs from 0 in double precision.
ROUNDING = 2.0**-53


@attrs.frozen
class ConstantDrag(Drag):
    """Constant drag coefficient D: the slip decays as w(t) = w(0) exp(-D K t), exactly in a step.

    Parameters
    ----------
    D : drag coefficient, 1/s, >= 0, per density of the fluid.

    Source: Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885, (3.5c); closed form derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> model = gr.TwoPhase(gamma=0.5)
    >>> q = model.conserved_from(np.array([1.0]), 0.5, 0.0, 1.0)
    >>> hs, ms, hf, mf = gr.ConstantDrag(D=10.0).step(model, tuple(q), (0.0,), 0.1)
    >>> (mf / hf - ms / hs).round(6).tolist(), (ms + 0.5 * mf).round(12).tolist()
    ([0.049787], [0.25])
    """

    constant: ClassVar[bool] = True

    D: float = number(at_least=0.0, hint="drag coefficient in 1/s")

    def coefficient(self, model, phi, slip):
        return self.D

    def remaining(self, model, phi, slip, time):
        return np.exp(-self.D * time)

    def moved(self, model, phi, slip, change, time):
        return towards_balance(slip, change, self.D * time)

    def resisted(self, model, phi, slip, time):
        return self.D / (1.0 + self.D * time)


@attrs.frozen
class VelocityDrag(Drag):
    """Velocity-dependent drag, D = d0 + d1 abs(vf - vs), exactly in a step.

    w(t) = w(0) e / (1 + d1 abs(w(0)) (1 - e)/d0) with e = exp(-d0 K t).

    Parameters
    ----------
    d0 : drag coefficient at no slip, 1/s, >= 0.
    d1 : its growth with the slip, 1/m, >= 0. Both are already divided by the density of the fluid.

    Source: closed form derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> model = gr.TwoPhase(gamma=0.5)
    >>> q = model.conserved_from(np.array([1.0]), 0.5, 0.0, 1.0)
    >>> hs, ms, hf, mf = gr.VelocityDrag(d0=1.0, d1=2.0).step(model, tuple(q), (0.0,), 0.1)
    >>> (mf / hf - ms / hs).round(6).tolist()
    [0.487906]
    """

    d0: float = number(at_least=0.0, hint="drag coefficient in 1/s")
    d1: float = number(at_least=0.0, hint="drag coefficient per slip, in 1/m")

    def coefficient(self, model, phi, slip):
        return self.d0 + self.d1 * slip

    def remaining(self, model, phi, slip, time):
        return decay(time, self.d0, self.d1 * slip, 1.0)

    def resisted(self, model, phi, slip, time):
        straight, bent = 1.0 + self.d0 * time, self.d1 * slip * time
        left = 2.0 / (straight + np.sqrt(straight * straight + 4.0 * bent))
        return (self.d0 + self.d1 * slip * left) * left


@attrs.frozen
class PitmanLeDrag(Drag):
    """Pitman-Le drag, D = g (1/gamma - 1) phi (1 - phi)^(1 - exponent) / v_T, exactly in a step.

    The force on the fluid is D h (vf - vs), per density of the fluid, as for every law here. Pitman and Le divide their
    fluid equation, h vf in place of (1 - phi) h vf, by 1 - phi: there the same D appears as D/(1 - phi).

    Parameters
    ----------
    v_T : settling velocity, m/s, > 0: the slip at which this drag carries the weight less buoyancy of grains for phi -> 0.
    exponent : hindrance by other grains, in [0, 10]; depends on the Reynolds number of a grain.

    Notes
    -----
    D -> 0 for phi -> 0. For exponent > 1, D grows beyond bound for phi -> 1; there 1 - phi is taken as 1e-16 at least, so D
    is finite, and no fluid is left to be dragged.

    Source: E. B. Pitman, L. Le, Phil. Trans. R. Soc. A 363 (2005) 1573-1601, as quoted by Pelanti, Bouchut, Mangeney,
    M2AN 42 (2008) 851-885; the reading of v_T and the closed form are derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> model = gr.TwoPhase(gamma=0.5)
    >>> q = model.conserved_from(np.array([1.0]), 0.5, 0.0, 1.0)
    >>> hs, ms, hf, mf = gr.PitmanLeDrag(v_T=1.0, exponent=3.0).step(model, tuple(q), (0.0,), 0.01)
    >>> (mf / hf - ms / hs).round(6).tolist()
    [0.555104]
    """

    v_T: float = number(above=0.0, hint="settling velocity in m/s")
    exponent: float = number(at_least=0.0, at_most=10.0, hint="of 1 - phi")

    def coefficient(self, model, phi, slip):
        # A power would not be vectorised: exp and log are.
        crowding = np.exp((1.0 - self.exponent) * np.log(maximum(1.0 - phi, ROUNDING)))
        return model.g * (1.0 / model.gamma - 1.0) * phi * crowding / self.v_T

    def remaining(self, model, phi, slip, time):
        return np.exp(-self.bounded(model, phi, slip) * time)

    def moved(self, model, phi, slip, change, time):
        return towards_balance(slip, change, self.bounded(model, phi, slip) * time)

    def resisted(self, model, phi, slip, time):
        drag = self.bounded(model, phi, slip)
        return drag / (1.0 + drag * time)
