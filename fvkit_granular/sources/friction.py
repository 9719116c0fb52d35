"""Friction at the bed: one law R(load, h, speed) per class, for the momenta of every phase of every model.

    (m v)_t + ... = -m R sgn(v),   R the deceleration, m/s^2, and m the mass that carries the momentum m v.

At rest friction is a bound: it holds back any push up to m R(load, h, 0). And where it balances a slope nothing changes, though
both are large. So friction acts together with the transport, on cells and on the push of faces: `fvkit.Source.driven`.
"""

from abc import abstractmethod
from typing import ClassVar

import attrs
import numpy as np

from fvkit import Source, maximum, minimum, where
from fvkit.pointwise import combine
from fvkit.problem.fields import number
from fvkit_granular.models.wet_dry import share, threshold, velocity
from fvkit_granular.sources.plausible import caution

#: Relative excess of static over dynamic friction, so that a flow that comes to rest at its angle stops in finite time.
STICKING = 1e-6

#: Largest deceleration, m/s^2, far above any relevant one; keeps products finite.
STRONGEST = 1e100

#: Largest decay -log of a speed: exp(-100) is far below round-off.
DEEPEST = 100.0

#: Number of iterations of `BasalFriction.slowed`, of two evaluations of the law each.
ITERATIONS = 8

#: Largest coefficient of dry friction, the tangent of 80 degrees: more is an angle in degrees, not its tangent; and the largest
#: plausible one, of 63 degrees.
STEEPEST, STEEP = 5.67, 2.0

#: Said with a coefficient that is refused.
TANGENT = "the tangent of the friction angle: tan(35 deg) = 0.70"

#: Added to the square of a number whose root divides, where both may vanish.
LEAST = 1e-300


@attrs.frozen
class BasalFriction(Source):
    """Abstract friction law: a phase of speed |v| is decelerated by R(load, h, |v|) >= 0, m/s^2.

    A law is one pointwise method::

        @attrs.frozen
        class Viscous(gr.BasalFriction):
            k: float

            def resistance(self, model, load, h, speed):
                return self.k * speed / h

    Contract:

    1. ``resistance(model, load, h, speed)`` returns R, m/s^2, of one phase, from its effective normal load on the bed per
       mass, m/s^2 (the model's ``basal_load``: g for shallow water, g (1 - gamma/rho) for the reduced model, g (1-gamma)
       for the solid and 0 for the fluid of the two-phase model), the depth h of all phases together, m, not below the
       model's ``dry``, and the speed abs(v) >= 0, m/s. R < 0 counts as 0 (friction never drives), R above 1e100 as 1e100.
       Its value at speed 0 is static friction. It must be a number there.
    2. ``moved(model, load, h, v, change, dt)`` returns the velocity after dt of what starts with v, is accelerated by the
       constant change/dt, and has this friction. The default serves every law, see there; override it for a closed form.
    3. ``slowed(model, load, h, speed, dt)`` returns the speed v' in [0, speed] with v' + dt R(v') = speed: what the default
       of ``moved``, and a scheme with implicit sources, are made of.
    4. ``static = False`` says that R = 0 at rest: nothing is held there.

    Everything else is shared. The step is stable for any R and dt, of second order, exact where R does not depend on the speed
    and where R balances the drive; without a drive it never turns a momentum round nor lets it grow, ends in exactly 0 where
    static friction exceeds speed/dt, and leaves the masses as they are, bit for bit.

    What is at rest, momentum exactly 0, stays so where the drive is at most (1 + 1e-6) R(load, h, 0): static friction exceeds
    that of motion by 1e-6, so that a slope that comes to rest at its angle does so in finite time. At a face the load is that
    of the mean of both masses, and, for the excess of an emerged step of the bottom, of the upper side: weighted like the
    push, so the lower, dry end of a pile on a slope stays. Derived here.

    `fvkit.rhs`: a pile stays at rest, but what begins to slide feels friction only once it moves.
    """

    static: ClassVar[bool] = True

    def check(self, model):
        for name in ("basal_load", "depth"):
            if not callable(getattr(model, name, None)):
                raise ValueError(f"{type(self).__name__} needs the load on the bed, but {type(model).__name__} has no "
                                 f"`{name}(q)`: define it, or leave the friction out of `sources`")
        super().check(model)

    @abstractmethod
    def resistance(self, model, load, h, speed):
        """Return R(load, h, speed), m/s^2."""

    def slowed(self, model, load, h, speed, dt):
        """Return the speed v' after dt: v' + dt R(v') = speed, 0 where dt R(0) >= speed.

        Ridders' method for y = log(v'/speed), whose bracket never leaves (-inf, 0], on

            log(v' + dt (R(v') - R(0))) - log(speed - dt R(0)),

        which is a straight line for weak friction and for a power law under strong friction. Derived here.

        Parameters
        ----------
        model, load, h : handed to the law.
        speed : abs(v) at the start, m/s.
        dt : time >= 0, s.

        Notes
        -----
        Relative error of v' - of the part that static friction leaves - over dt from 1e-6 to 1e6 and speeds from 1e-9 to 1e3:
        rounding for powers of the speed up to the fourth with or without static friction, 2e-11 for the eighth. Where R
        falls with the speed there may be several solutions; one of them is found.
        """
        static = dt * self.bounded(model, load, h, 0.0 * speed)
        left = speed - static
        moves = left > 0.0
        goal, top = where(moves, left, 1.0), where(moves, speed, 1.0)
        low, high = np.log(goal / top) - DEEPEST, 0.0 * top
        below, above = (self.mismatch(model, load, h, top * np.exp(low), dt, static, goal),
                        self.mismatch(model, load, h, top, dt, static, goal))
        never, found = above <= 0.0, high
        for _ in range(ITERATIONS):
            middle = 0.5 * (low + high)
            centre = self.mismatch(model, load, h, top * np.exp(middle), dt, static, goal)
            bend = np.sqrt(maximum(centre * centre - below * above, 0.0) + LEAST)
            found = minimum(maximum(middle - (middle - low) * (centre / bend), low), high)
            value = self.mismatch(model, load, h, top * np.exp(found), dt, static, goal)
            first, second = minimum(middle, found), maximum(middle, found)
            at_first, at_second = where(middle < found, centre, value), where(middle < found, value, centre)
            rises, falls = at_first < 0.0, at_second >= 0.0
            low = where(falls, where(rises, first, low), second)
            below = where(falls, where(rises, at_first, below), at_second)
            high = where(rises, where(falls, second, high), first)
            above = where(rises, where(falls, at_second, above), at_first)
        return where(moves, where(never, speed, speed * np.exp(found)), 0.0)

    def mismatch(self, model, load, h, speed, dt, static, goal):
        """Return log(speed + dt R(speed) - static) - log(goal), far below 0 where the first has no logarithm."""
        total = speed + (dt * self.bounded(model, load, h, speed) - static)
        return np.log(maximum(total / goal, LEAST))

    def bounded(self, model, load, h, speed):
        """Return R(load, h, speed) within [0, 1e100]; NaN stays NaN."""
        return minimum(STRONGEST, maximum(0.0, self.resistance(model, load, h, speed)))

    def moved(self, model, load, h, v, change, dt):
        """Return the velocity after dt under this friction and a constant drive change/dt, from the initial velocity v.

        Richardson extrapolation of two implicit half steps and one full step: second order, exact where R does not depend on
        the speed and where R balances the drive. If the extrapolation changes the sign of the velocity or exceeds
        |v| + |change|, the half steps alone. Derived here.

        Parameters
        ----------
        model, load, h : handed to the law.
        v, change : m/s, of any sign.
        dt : time >= 0, s.
        """
        whole = self.stopped(model, load, h, v + change, dt)
        halves = self.stopped(model, load, h, v + 0.5 * change, 0.5 * dt)
        halves = self.stopped(model, load, h, halves + 0.5 * change, 0.5 * dt)
        better = 2.0 * halves - whole
        return where((better * halves > 0.0) & (np.abs(better) <= np.abs(v) + np.abs(change)), better, halves)

    def stopped(self, model, load, h, v, dt):
        """Return the velocity after an implicit step, no drive."""
        return np.sign(v) * self.slowed(model, load, h, np.abs(v), dt)

    def step(self, model, q, aux, dt):
        return self.driven(model, q, q, tuple([q[masses[-1]] for masses, _ in model.phases]), aux, dt)

    def driven(self, model, before, after, bearing, aux, dt):
        middle = combine(0.5, before, 0.5, after)
        result, h, loads = list(after), maximum(model.depth(middle), threshold(model.dry)), model.basal_load(middle)
        for load, mass, (masses, momentum) in zip(loads, bearing, model.phases, strict=True):
            row = masses[-1]
            free = velocity(after[row], after[momentum], model.dry)
            start = where(before[row] > threshold(model.dry), velocity(before[row], before[momentum], model.dry), free)
            # The force acts on the mass that bears the drive, the velocity is that of the end of the step.
            time = dt * share(mass, after[row])
            static = time * self.bounded(model, load, h, 0.0)
            held = (before[momentum] == 0.0) & (np.abs(free) <= (1.0 + STICKING) * static)
            end = where(held, 0.0, self.moved(model, load, h, start, free - start, time))
            moves = free != 0.0  # below ``dry`` a momentum is more than mass times velocity
            result[momentum] = where(moves, after[momentum] * (end / where(moves, free, 1.0)), after[momentum] + after[row] * end)
        return tuple(result)

    def rate(self, model, q, aux):
        result, h, loads = list(q), maximum(model.depth(q), threshold(model.dry)), model.basal_load(q)
        for load, (masses, momentum) in zip(loads, model.phases, strict=True):
            for row in masses:
                result[row] = 0.0 * q[row]
            v = velocity(q[masses[-1]], q[momentum], model.dry)
            result[momentum] = -np.sign(v) * (q[masses[-1]] * self.bounded(model, load, h, np.abs(v)))
        return tuple(result)

    def implicit_rate(self, model, q, aux, a):
        result, h, loads = list(q), maximum(model.depth(q), threshold(model.dry)), model.basal_load(q)
        for load, (masses, momentum) in zip(loads, model.phases, strict=True):
            for row in masses:
                result[row] = 0.0 * q[row]
            v = velocity(q[masses[-1]], q[momentum], model.dry)
            speed = self.slowed(model, load, h, np.abs(v), a)
            result[momentum] = -np.sign(v) * (q[masses[-1]] * self.bounded(model, load, h, speed))
        return tuple(result)


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
    """

    nu: float = number(at_least=0.0, at_most=STEEPEST, hint=TANGENT)

    def check(self, model):
        caution(self, "nu", 0.0, STEEP, TANGENT)
        super().check(model)

    def resistance(self, model, load, h, speed):
        return self.nu * load

    def moved(self, model, load, h, v, change, dt):
        return against_quadratic(v, change, self.nu * load, 0.0, dt)

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
    """

    n: float = number(at_least=0.0, hint="roughness in s/m^(1/3)")

    static: ClassVar[bool] = False

    def check(self, model):
        caution(self, "n", 0.0, 1.0, "roughness in s/m^(1/3); of Strickler's coefficient K it is n = 1/K")
        super().check(model)

    def resistance(self, model, load, h, speed):
        return self.strength(model, h) * (speed * speed)

    def moved(self, model, load, h, v, change, dt):
        return against_quadratic(v, change, 0.0, self.strength(model, h), dt)

    def slowed(self, model, load, h, speed, dt):
        return quadratic(speed, dt * self.strength(model, h))

    def strength(self, model, h):
        """Return g n^2/h^(4/3), 1/m."""
        # A power would not be vectorised: exp and log are.
        return model.g * (self.n * self.n) * np.exp(-4.0 / 3.0 * np.log(h))


def quadratic(speed, a):
    """Return v >= 0 with v + a v^2 = speed."""
    return 2.0 * speed / (1.0 + np.sqrt(1.0 + 4.0 * a * speed))


def against_quadratic(v, change, static, a, dt):
    """Return the velocity after dt of dv/dt = change/dt - (static + a v^2) sgn v.

    With the speed u and D = change - dt static, along the motion,

        u' = u + (D - a dt u^2)/(r + a dt u),   r = sqrt(1 + a dt max(D, 0)):

    second order, exact for a = 0, for D = 0, where D = a dt u^2, and for dt -> infinity. Where u + D < 0 the motion stops, and
    what is left of the step may push it back. Derived here.

    Parameters
    ----------
    v, change : m/s, of any sign.
    static : deceleration at rest, m/s^2.
    a : 1/m, >= 0.
    dt : time >= 0, s.
    """
    strong, held = minimum(a, STRONGEST) * dt, minimum(maximum(static, 0.0), STRONGEST) * dt
    u = np.abs(v)
    side = where(v == 0.0, np.sign(change), np.sign(v))
    drive = side * change - held
    root = np.sqrt(1.0 + strong * maximum(drive, 0.0))
    onward = maximum(u + (drive - strong * u * u) / (root + strong * u), 0.0)
    turned = u + drive < 0.0
    left = 1.0 - u / where(turned, -drive, 1.0)
    back = maximum(-side * change - held, 0.0) * left
    return side * where(turned, -back / np.sqrt(1.0 + strong * left * back), onward)
