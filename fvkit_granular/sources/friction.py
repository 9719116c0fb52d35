"""Friction at the bed: the base class of laws R(load, h, speed), for the momenta of every phase of every model.

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
from fvkit_granular.models.wet_dry import share, threshold, velocity

#: Relative excess of static over dynamic friction, so that a flow that comes to rest at its angle stops in finite time.
STICKING = 1e-6

#: Largest deceleration, m/s^2, far above any relevant one; keeps products finite.
STRONGEST = 1e100

#: Largest decay -log of a speed: exp(-100) is far below round-off.
DEEPEST = 100.0

#: Number of iterations of `BasalFriction.slowed`, of two evaluations of the law each.
ITERATIONS = 8

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
    2. ``moved(model, load, h, v, change, dt)`` returns the velocity after dt, from v, under the constant acceleration change/dt
       and this friction. The default serves every law; override it for a closed form.
    3. ``slowed(model, load, h, speed, dt)`` returns the speed v' in [0, speed] with v' + dt R(v') = speed, for the default of
       ``moved`` and for schemes with implicit sources.
    4. ``static = False`` declares that R = 0 at rest, so that nothing is held there; ``proportional = True`` that R is a
       constant times the load.

    The rest is common. The step is stable for any R and dt, of second order, exact where R does not depend on the speed and
    where R balances the drive. Without a drive it never reverses or increases a momentum, and ends in exactly 0 where static
    friction exceeds speed/dt. It does not change the masses.

    A phase at rest, momentum exactly 0, stays at rest while the drive is at most (1 + 1e-6) R(load, h, 0): static friction
    exceeds dynamic friction by 1e-6, so that a slope comes to rest at its angle in finite time. At a face the load is that of
    the mean of both masses, and, for the excess of an emerged step of the bottom, of the upper side. It is weighted like the
    push, so the lower, dry end of a pile on a slope stays at rest. Derived here.

    `fvkit.rhs`: a pile stays at rest, but a pile that begins to slide feels friction only after it moves.

    Examples
    --------
    >>> import attrs
    >>> import fvkit_granular as gr
    >>> @attrs.frozen
    ... class Viscous(gr.BasalFriction):
    ...     k: float
    ...     def resistance(self, model, load, h, speed):
    ...         return self.k * speed / h
    >>> float(Viscous(0.2).resistance(gr.ShallowWater(), 9.81, 0.5, 2.0))
    0.8
    """

    static: ClassVar[bool] = True
    proportional: ClassVar[bool] = False
    separates: ClassVar[str] = ("friction at the bed slows grains and fluid differently, and in shallow water acts without "
                                "buoyancy")

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
            # The force acts on the mass that bears the drive, at a face all of it; the velocity is that of the end of the step.
            # Beside a flow of 1 m a film of 1e-300 m would feel it for ever: the product with a resistance must stay a number.
            time = dt if mass is after[row] else dt * minimum(share(mass, after[row]), STRONGEST)
            static = time * self.bounded(model, load, h, 0.0)
            held = (before[momentum] == 0.0) & (np.abs(free) <= (1.0 + STICKING) * static)
            end = where(held, 0.0, self.moved(model, load, h, start, free - start, time))
            # Where friction slows the flow, rounding of the product must not let its momentum grow.
            most, product = np.abs(after[momentum]), after[row] * end
            bounded = where(np.abs(end) < np.abs(free), minimum(maximum(product, -most), most), product)
            result[momentum] = where(end == free, after[momentum], bounded)
        return tuple(result)

    def rate(self, model, q, aux):
        return self.decelerated(model, q, lambda load, h, speed: speed)

    def implicit_rate(self, model, q, aux, a):
        return self.decelerated(model, q, lambda load, h, speed: self.slowed(model, load, h, speed, a))

    def decelerated(self, model, q, end):
        """Return dq/dt with R at the speed ``end(load, h, speed)`` of each phase."""
        result, h, loads = list(q), maximum(model.depth(q), threshold(model.dry)), model.basal_load(q)
        for load, (masses, momentum) in zip(loads, model.phases, strict=True):
            for row in masses:
                result[row] = 0.0 * q[row]
            v = velocity(q[masses[-1]], q[momentum], model.dry)
            result[momentum] = -np.sign(v) * (q[masses[-1]] * self.bounded(model, load, h, end(load, h, np.abs(v))))
        return tuple(result)
