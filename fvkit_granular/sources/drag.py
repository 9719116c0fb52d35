"""Drag between solid and fluid: one law D(phi, |vf - vs|) per class.

    (hs vs)_t = gamma F_D,   (hf vf)_t = -F_D,   F_D = D h (vf - vs).

Depths and mixture momentum stay; the slip w = vf - vs decays as dw/dt = -K D(phi, |w|) w, see
`fvkit_granular.sources.slip_decay`.
"""

from abc import abstractmethod
from typing import ClassVar

import attrs
import numpy as np

from fvkit import Source, maximum, minimum, where
from fvkit_granular.models.wet_dry import share, velocity
from fvkit_granular.sources.slip_decay import drag_rate, exchange, slip_momentum

#: Bounds of D, 1/s, that keep D K t finite and positive; both are far outside the range that changes the slip.
STRONGEST, WEAKEST = 1e100, 1e-200

#: Largest decay -log(r) of the slip: exp(-100) is far below round-off of the velocities.
DEEPEST = 100.0

#: Nodes below 1/2 and weights of Gauss and Legendre's rule on (0, 1); 1 minus a node is a node, of the same weight.
NODES = tuple((0.5 + 0.5 * float(x), 0.5 * float(w)) for x, w in zip(*np.polynomial.legendre.leggauss(6), strict=True) if x < 0.0)

#: Number of iterations of `Drag.remaining`.
ITERATIONS = 6

#: Number of secants of `Drag.resisted`; with 6 a law that grows as the square of the slip is left with an error of 3e-8.
SECANTS = 7

#: A phase whose mass has grown by more than this factor in a step has the slip that the drive alone gives it, in proportion: what
#: stood there before was too little to have one.
GROWN = 4.0

#: Below this argument (exp(x) - 1)/x and log(1 + x)/x are taken from their series, to 1e-13.
SERIES = 1e-3

@attrs.frozen
class Drag(Source):
    """Abstract drag law F_D = D h (vf - vs) on the fluid, -gamma F_D of which acts on the solid.

    A law is one pointwise method::

        @attrs.frozen
        class Saturating(gr.Drag):
            d: float

            def coefficient(self, model, phi, slip):
                return self.d / (1.0 + slip)

    Contract:

    1. ``coefficient(model, phi, slip)`` returns D, 1/s, already divided by the density of the fluid, for the solid
       fraction phi in [0, 1] and slip = abs(vf - vs) >= 0, m/s. It need not be finite at the ends of these ranges. D < 0
       counts as 0 (drag never drives), D above 1e100 as 1e100.
    2. ``remaining(model, phi, slip, time)`` returns the share of the slip that is left after a time, in [0, 1]. The
       default serves every law, see there; override it where the law has a closed form.
    3. ``constant = True`` declares that D is the same for every phi and slip.

    The rest is common: the step does not change the masses, conserves the mixture momentum hs vs + gamma hf vf, acts only where
    both phases are present, never increases the slip or changes its sign, and is stable for any D and dt.

    Examples
    --------
    >>> import fvkit_granular as gr
    >>> import numpy as np
    >>> class Linear(gr.Drag):
    ...     def coefficient(self, model, phi, slip):
    ...         return 20.0 * phi
    >>> model = gr.TwoPhase(gamma=0.5)
    >>> q = model.conserved_from(np.array([1.0]), 0.5, 0.0, 1.0)
    >>> hs, ms, hf, mf = Linear().step(model, tuple(q), (0.0,), 0.1)
    >>> (mf / hf - ms / hs).round(6).tolist()
    [0.049787]
    """

    between_phases: ClassVar[bool] = True
    constant: ClassVar[bool] = False
    separates: ClassVar[str] = ""

    @abstractmethod
    def coefficient(self, model, phi, slip):
        """Return D(phi, slip), 1/s."""

    def remaining(self, model, phi, slip, time):
        """Return the remaining fraction r of the slip after ``time``: dr/dt = -D(phi, slip r) r, r(0) = 1.

        The depth of decay L = -log r solves  integral_0^L dl/D(phi, slip exp(-l)) = time.  The integral is that of the power
        law through both ends, in closed form, plus Gauss and Legendre's rule for the rest, which vanishes at both ends;
        the equation is solved by iterations that are exact for a power law, kept within a bracket. Derived here.

        Parameters
        ----------
        model : gives its parameters to the law.
        phi : solid fraction in [0, 1].
        slip : abs(vf - vs) at the start, m/s.
        time : K t, s, >= 0, with K of `fvkit_granular.sources.slip_decay.drag_rate`.

        Notes
        -----
        Error of r, largest over D(phi, slip) time from 1e-6 to 1e12, measured against an ODE solver: rounding for every
        power of the slip; 1e-9 for d/(1 + slip), 1e-7 for d/(1 + 100 slip), 3e-7 for d0 + d1 slip, 1e-5 for d0 + d1 slip^2
        and exp(5 slip), 2e-4 for a law that jumps by a factor 1000 within a factor 3 of the slip (d0, d1: any ratio).
        Where D(phi, slip) time < 1 the first four are below 1e-9.
        """
        start = self.bounded(model, phi, slip) + WEAKEST
        depth = minimum(np.log(1.0 + start * time), DEEPEST)
        low, high = 0.0 * depth, 0.0 * depth + DEEPEST
        for _ in range(ITERATIONS):
            left = np.exp(-depth)
            end = self.bounded(model, phi, slip * left) + WEAKEST
            fall = start / end
            spread = np.log(fall)
            power = spread / maximum(depth, WEAKEST)
            bend = 0.0 * depth
            for node, weight in NODES:
                near, law = np.exp(-node * depth), np.exp(node * spread)
                first = self.bounded(model, phi, slip * near) + WEAKEST
                second = self.bounded(model, phi, slip * (left / near)) + WEAKEST
                bend = bend + weight * ((1.0 / first - law / start) + (1.0 / second - fall / law / start))
            missing = time - depth * bend
            flat = np.abs(spread) < SERIES
            growth = where(flat, series_of_exp(spread), (fall - 1.0) / where(flat, 1.0, spread))
            ahead = end * (missing - depth / start * growth)
            change = power * ahead
            close = np.abs(change) < SERIES
            target = maximum(1.0 / fall + power * end * missing, WEAKEST)
            step = where(close, ahead * series_of_log(where(close, change, 0.0)), np.log(target) / where(close, 1.0, power))
            # Where D grows as the slip falls, a power law ends in finite time: Newton's step, which never overshoots there.
            step = where(power < 0.0, ahead, step)
            low, high = where(ahead > 0.0, depth, low), where(ahead > 0.0, high, depth)
            outside = (depth + step < low) | (depth + step > high)
            depth = where(outside, 0.5 * (low + high), depth + step)
        return np.exp(-depth)

    def resisted(self, model, phi, slip, time):
        """Return D(phi, slip r) r of an implicit step of length ``time``: r (1 + time D(phi, slip r)) = 1.

        The depth L = -log r is the root of L - log(1 + time D(phi, slip exp(-L))), whose slope lies between 1 and 1 + p where
        D grows like a power p of the slip: secants. Override it where the law has a closed form. Derived here.

        Parameters
        ----------
        model, phi, slip, time : as for `remaining`; time 0 gives D(phi, slip).

        Notes
        -----
        Relative error for powers 0 to 2 of the slip and D(phi, slip) time from 1e-6 to 1e12: below 1e-10.
        """
        before = 0.0 * slip
        depth = minimum(np.log(1.0 + time * self.bounded(model, phi, slip)), DEEPEST)
        missed = -depth
        for _ in range(SECANTS):
            miss = depth - np.log(1.0 + time * self.bounded(model, phi, slip * np.exp(-depth)))
            moved, change = depth - before, miss - missed
            usable = change * moved > 0.0
            step = where(usable, miss * moved / where(usable, change, 1.0), miss)
            before, missed, depth = depth, miss, maximum(0.0, minimum(depth - step, DEEPEST))
        left = np.exp(-depth)
        return self.bounded(model, phi, slip * left) * left

    def bounded(self, model, phi, slip):
        """Return D(phi, slip) within [0, 1e100]; NaN stays NaN."""
        return minimum(STRONGEST, maximum(0.0, self.coefficient(model, phi, slip)))

    def moved(self, model, phi, slip, change, time):
        """Return the slip after ``time`` under this drag and a constant drive change/time, from the initial ``slip``.

        Richardson extrapolation of two implicit half steps and one full step: second order, exact where drag balances the
        drive. If the extrapolation changes the sign of the slip, the half steps alone; without a drive, `remaining`. Derived
        here.

        Parameters
        ----------
        model, phi : as for `remaining`.
        slip, change : vf - vs at the start, and its change by the drive alone, m/s.
        time : K t, s.
        """
        whole = self.resisting(model, phi, slip + change, time)
        halves = self.resisting(model, phi, slip + 0.5 * change, 0.5 * time)
        halves = self.resisting(model, phi, halves + 0.5 * change, 0.5 * time)
        better = 2.0 * halves - whole
        free = slip * self.remaining(model, phi, np.abs(slip), time)
        return where(change == 0.0, free, where(better * halves > 0.0, better, halves))

    def resisting(self, model, phi, slip, time):
        """Return the slip after an implicit step, no drive."""
        return slip * (1.0 - time * self.resisted(model, phi, np.abs(slip), time))

    def step(self, model, q, aux, dt):
        hs, ms, hf, mf = q
        slip = np.abs(velocity(hf, mf, model.dry) - velocity(hs, ms, model.dry))
        time = dt * drag_rate(hs, hf, model.gamma)
        gone = 1.0 - self.remaining(model, share(hs, hs + hf), slip, time)
        moved = where((hs > 0.0) & (hf > 0.0), gone * slip_momentum(hs, ms, hf, mf, model.gamma), 0.0)
        return hs, ms + model.gamma * moved, hf, mf - moved

    def driven(self, model, before, after, bearing, aux, dt):
        (hs, ms, hf, mf), (old_s, old_ms, old_f, old_mf) = after, before
        free = velocity(hf, mf, model.dry) - velocity(hs, ms, model.dry)
        both = (hs > 0.0) & (hf > 0.0)
        slip = velocity(old_f, old_mf, model.dry) - velocity(old_s, old_ms, model.dry)
        stood = minimum(1.0, GROWN * minimum(share(old_s, hs), share(old_f, hf)))
        start = where(both & (stood < 1.0), free + stood * (slip - free), where(both, slip, free))
        # The force acts on the mean masses of the step; the slip is that at the end of the step.
        solid, fluid = 0.5 * (hs + old_s), 0.5 * (hf + old_f)
        time = dt * drag_rate(hs, hf, model.gamma) * share(solid + fluid, hs + hf)
        end = self.moved(model, share(solid, solid + fluid), start, free - start, time)
        _, _, part = exchange(hs, hf, model.gamma)
        moved = where(both, (free - end) * (hs * part), 0.0)
        return hs, ms + model.gamma * moved, hf, mf - moved

    def rate(self, model, q, aux):
        hs, ms, hf, mf = q
        slip = velocity(hf, mf, model.dry) - velocity(hs, ms, model.dry)
        return exchanged(model, q, self.bounded(model, share(hs, hs + hf), np.abs(slip)), slip)

    def implicit_rate(self, model, q, aux, a):
        hs, ms, hf, mf = q
        slip = velocity(hf, mf, model.dry) - velocity(hs, ms, model.dry)
        time = a * drag_rate(hs, hf, model.gamma)
        return exchanged(model, q, self.resisted(model, share(hs, hs + hf), np.abs(slip), time), slip)


def exchanged(model, q, drag, slip):
    """Return the rates of q from the force ``drag`` h ``slip`` of the solid on the fluid; none where a phase is absent."""
    hs, _, hf, _ = q
    force = where((hs > 0.0) & (hf > 0.0), drag * ((hs + hf) * slip), 0.0)
    return 0.0 * hs, model.gamma * force, 0.0 * hf, -force


def towards_balance(slip, change, decays):
    """Return the slip after a step of a constant drive, which alone adds ``change``, and of linear drag, D K t = ``decays``:

    w' = w exp(-d) + change (1 - exp(-d))/d, exactly.
    """
    slow = decays < SERIES
    mean = where(slow, series_of_exp(-decays), -np.expm1(-decays) / where(slow, 1.0, decays))
    return slip * np.exp(-decays) + change * mean


def series_of_exp(x):
    """Return (exp(x) - 1)/x for small x."""
    return 1.0 + x * (0.5 + x * (1.0 / 6.0 + x / 24.0))


def series_of_log(x):
    """Return log(1 + x)/x for small x."""
    return 1.0 - x * (0.5 - x * (1.0 / 3.0 - x / 4.0))
