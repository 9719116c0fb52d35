"""Laws of friction at the bed: Coulomb, Voellmy, Manning."""

from typing import ClassVar

import attrs
import numpy as np

from fvkit import maximum, minimum, where
from fvkit.problem.fields import number
from fvkit_granular.sources.friction import STRONGEST, BasalFriction
from fvkit_granular.sources.plausible import caution

#: Largest coefficient of dry friction, the tangent of 80 degrees: more is an angle in degrees, not its tangent; and the largest
#: plausible one, of 63 degrees.
STEEPEST, STEEP = 5.67, 2.0

#: Said with a coefficient that is refused.
TANGENT = "the tangent of the friction angle: tan(35 deg) = 0.70"


@attrs.frozen
class CoulombFriction(BasalFriction):
    """Coulomb (dry) friction, R = nu load: a pile below its angle of friction stays at rest, a sliding block stops.

    Exact in a step: v' = max(|v| - dt nu load, 0). In the two-phase model it acts on the solid alone, whose load
    is g (1-gamma); the fluid has none. In the reduced model the grains carry g (1 - gamma/rho).

    Parameters
    ----------
    nu : coefficient of friction, tangent of the angle at the bed, 0 to 5.67 (80 degrees); above 2 warns.

    Source: the paper's model, Pelanti, Bouchut, Mangeney, M2AN 42 (2008) 851-885, drops the term after its derivation;
    implicit clip remembered as common practice; the bound at faces is derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> law, model = gr.CoulombFriction(nu=0.3), gr.ShallowWater()
    >>> h, m = law.step(model, (np.array([1.0, 1.0]), np.array([2.0, 0.0])), (0.0,), 0.1)
    >>> (m / h).round(4).tolist()
    [1.7057, 0.0]
    """

    proportional: ClassVar[bool] = True

    nu: float = number(at_least=0.0, at_most=STEEPEST, hint=TANGENT)

    def check(self, model):
        caution(self, "nu", 0.0, STEEP, TANGENT)
        super().check(model)

    def resistance(self, model, load, h, speed):
        return self.nu * load

    def moved(self, model, load, h, v, change, dt):
        return against_quadratic(v, change, self.nu * load, None, dt)

    def slowed(self, model, load, h, speed, dt):
        return maximum(speed - dt * self.bounded(model, load, h, speed), 0.0)


@attrs.frozen
class Voellmy(BasalFriction):
    """Voellmy friction, R = mu load + g v^2/(xi h): dry friction and a turbulent part.

    In closed form: with s = max(|v| - dt mu load, 0) and a = dt g/(xi h), v' = 2 s/(1 + sqrt(1 + 4 a s)). In the two-phase
    model dry friction acts on the solid alone and the turbulent part on each phase by its own velocity, h being the depth
    of both: with one velocity for both phases the sum of them is the law for the whole layer.

    Parameters
    ----------
    mu : coefficient of dry friction, the tangent of its angle, 0 to 5.67 (80 degrees); above 2 warns.
    xi : turbulence coefficient, m/s^2, > 0; 100 to 2000 for avalanches and debris flows (remembered); below 1 warns.

    Source: A. Voellmy, Schweizerische Bauzeitung 73 (1955), as remembered; closed form of the step derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> law, model = gr.Voellmy(mu=0.2, xi=500.0), gr.ShallowWater()
    >>> h, m = law.step(model, (np.array([1.0]), np.array([2.0])), (0.0,), 0.1)
    >>> (m / h).round(4).tolist()
    [1.7967]
    """

    mu: float = number(at_least=0.0, at_most=STEEPEST, hint=TANGENT)
    xi: float = number(above=0.0, hint="turbulence coefficient in m/s^2")

    def check(self, model):
        caution(self, "mu", 0.0, STEEP, TANGENT)
        caution(self, "xi", 1.0, np.inf, "the turbulence coefficient in m/s^2 is 100 to 2000, not 1/xi or g/xi")
        super().check(model)

    def resistance(self, model, load, h, speed):
        return self.mu * load + model.g / self.xi / h * (speed * speed)

    def moved(self, model, load, h, v, change, dt):
        return against_quadratic(v, change, self.mu * load, model.g / self.xi / h, dt)

    def slowed(self, model, load, h, speed, dt):
        return quadratic(maximum(speed - dt * (self.mu * load), 0.0), dt * (model.g / self.xi / h))


@attrs.frozen
class Manning(BasalFriction):
    """Manning friction, R = g n^2 v^2/h^(4/3): rough turbulent flow, no friction at rest.

    In closed form: with a = dt g n^2/h^(4/3), v' = 2 |v|/(1 + sqrt(1 + 4 a |v|)). In the two-phase model it acts on each
    phase by its own velocity, h being the depth of both: with one velocity it is the law for the whole layer.

    Parameters
    ----------
    n : roughness, s/m^(1/3), >= 0; 0.01 to 0.1 for channels (remembered); above 1 warns. Of Strickler's coefficient K it is 1/K.

    Source: R. Manning, 1891, as in every textbook of hydraulics; closed form of the step derived here.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> law, model = gr.Manning(n=0.03), gr.ShallowWater()
    >>> h, m = law.step(model, (np.array([1.0]), np.array([2.0])), (0.0,), 10.0)
    >>> (m / h).round(4).tolist()
    [1.6998]
    """

    n: float = number(at_least=0.0, hint="roughness in s/m^(1/3)")

    static: ClassVar[bool] = False

    def check(self, model):
        caution(self, "n", 0.0, 1.0, "roughness in s/m^(1/3); of Strickler's coefficient K it is n = 1/K")
        super().check(model)

    def resistance(self, model, load, h, speed):
        return self.strength(model, h) * (speed * speed)

    def moved(self, model, load, h, v, change, dt):
        return against_quadratic(v, change, None, self.strength(model, h), dt)

    def slowed(self, model, load, h, speed, dt):
        return quadratic(speed, dt * self.strength(model, h))

    def strength(self, model, h):
        """Return g n^2/h^(4/3), 1/m."""
        # A power would not be vectorised: a cube root is.
        return model.g * (self.n * self.n) / (h * np.cbrt(h))


def quadratic(speed, a):
    """Return v >= 0 with v + a v^2 = speed."""
    return 2.0 * speed / (1.0 + np.sqrt(1.0 + 4.0 * a * speed))


def against_quadratic(v, change, static, a, dt):
    """Return the velocity after dt of dv/dt = change/dt - (static + a v^2) sgn v.

    With the speed u and D = change - dt static, along the motion,

        u' = u + (D - a dt u^2)/(r + a dt u),   r = sqrt(1 + a dt max(D, 0)):

    second order, exact for a = 0, for D = 0, where D = a dt u^2, and for dt -> infinity. Where u + D < 0 the motion stops, and
    the rest of the step may push it back, by B: u' = -B/sqrt(1 + a dt B). Derived here.

    v and ``change`` in m/s; the deceleration at rest ``static``, m/s^2, and a >= 0, 1/m, are None where there is none.
    """
    u, side = np.abs(v), where(v == 0.0, np.sign(change), np.sign(v))
    held = 0.0 if static is None else minimum(maximum(static, 0.0), STRONGEST) * dt
    drive = side * change - held
    stopped = u + drive
    turned = stopped < 0.0
    back = stopped if static is None else -maximum(-side * change - held, 0.0) * (1.0 + u / where(turned, drive, -1.0))
    if a is None:
        return side * where(turned, back, stopped)
    strong = minimum(a, STRONGEST) * dt
    root = np.sqrt(1.0 + strong * where(turned, -back, maximum(drive, 0.0)))
    gain = where(turned, back, drive - strong * u * u) / (root + where(turned, 0.0, strong * u))
    return side * where(turned, gain, maximum(u + gain, 0.0))
