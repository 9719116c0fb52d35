"""Your own equations: a shock tube, with Roe, HLL and an HLLC of your own
=======================================================================

`fvkit.compare` measures error against run time for any model. Here: the Euler equations, Sod's shock tube, and an exact solution.

HLL has two waves and smears the contact; HLLC (Toro, Spruce, Speares, Shock Waves 4, 1994, 25-34) puts it back as a third one,
between the states that the jump conditions give it. A Riemann solver of fvkit returns waves of the flux: each jump of the state
times its speed.

Usage: python examples/shock_tube.py [FOLDER]     (writes the report there; default: shock_tube)
"""

import sys
from pathlib import Path

import attrs
import numpy as np
from scipy.optimize import brentq

import fvkit as fv
from fvkit.pointwise import maximum, minimum, scale, subtract


@attrs.frozen
class Gas(fv.Model):
    """Euler equations of an ideal gas, q = (rho, m = rho u, E), with Roe's mean state."""

    conserved = ("rho", "m", "E")

    kappa: float = 1.4

    def pressure(self, q):
        rho, m, e = q
        return (self.kappa - 1.0) * (e - 0.5 * m * m / rho)

    def flux(self, q):
        u, p = q[1] / q[0], self.pressure(q)
        return q[1], q[1] * u + p, (q[2] + p) * u

    def wave_speeds(self, q):
        u, c = q[1] / q[0], np.sqrt(self.kappa * self.pressure(q) / q[0])
        return u - c, u + c

    def decompose(self, ql, qr, auxl, auxr, jump):
        left, right = np.sqrt(ql[0]), np.sqrt(qr[0])
        share = left / (left + right)
        enthalpy = [(q[2] + self.pressure(q)) / q[0] for q in (ql, qr)]
        u = share * ql[1] / ql[0] + (1.0 - share) * qr[1] / qr[0]
        h = share * enthalpy[0] + (1.0 - share) * enthalpy[1]
        c2 = (self.kappa - 1.0) * (h - 0.5 * u * u)
        c = np.sqrt(c2)
        middle = (self.kappa - 1.0) / c2 * ((h - u * u) * jump[0] + u * jump[1] - jump[2])
        last = (jump[1] + (c - u) * jump[0] - c * middle) / (2.0 * c)
        first = jump[0] - middle - last
        waves = ((first, first * (u - c), first * (h - u * c)), (middle, middle * u, middle * 0.5 * u * u),
                 (last, last * (u + c), last * (h + u * c)))
        return waves, (u - c, u, u + c)

    def observables(self, q, aux=None):
        return {"rho": q[0], "u": q[1] / q[0], "p": self.pressure(q)}


@attrs.frozen
class HLLC(fv.RiemannSolver):
    """HLL with the contact: three waves, for `Gas`."""

    def solve(self, model, ql, qr, auxl, auxr, jump):
        (low, high), (lowr, highr) = model.wave_speeds(ql), model.wave_speeds(qr)
        s1, s3 = minimum(low, lowr), maximum(high, highr)
        pl, pr, ul, ur = model.pressure(ql), model.pressure(qr), ql[1] / ql[0], qr[1] / qr[0]
        ml, mr = ql[0] * (s1 - ul), qr[0] * (s3 - ur)
        s2 = (pr - pl + ul * ml - ur * mr) / (ml - mr)
        middle_left, middle_right = self.middle(ql, ul, pl, s1, s2), self.middle(qr, ur, pr, s3, s2)
        first = scale(s1, subtract(middle_left, ql))
        last = scale(s3, subtract(qr, middle_right))
        return (first, subtract(subtract(jump, first), last), last), (s1, s2, s3)

    def middle(self, q, u, p, s, contact):
        """Return the state between the wave of speed s and the contact."""
        rho = q[0] * (s - u) / (s - contact)
        return rho, rho * contact, rho * (q[2] / q[0] + (contact - u) * (contact + p / (q[0] * (s - u))))


MODEL, LEFT, RIGHT, T_END = Gas(), (1.0, 0.0, 1.0), (0.125, 0.0, 0.1), 0.2


def state(rho, u, p):
    """Return (rho, m, E)."""
    return np.stack(np.broadcast_arrays(rho, rho * u, p / (MODEL.kappa - 1.0) + 0.5 * rho * u * u))


def problem(cells: int) -> fv.Problem:
    """Return Sod's shock tube (J. Comput. Phys. 27, 1978, 1-31): gas at rest, a membrane at x = 0.5 bursts."""
    return fv.Problem(MODEL, fv.Grid(0.0, 1.0, cells), lambda x: exact(x, 0.0), T_END)


def exact(x, t):
    """Return the exact solution (rarefaction, contact, shock), (3, m) at x (m,), of Toro, Riemann Solvers, chapter 4."""
    k, (rhol, ul, pl), (rhor, ur, pr) = MODEL.kappa, LEFT, RIGHT
    cl = np.sqrt(k * pl / rhol)

    def behind_fan(p):
        return ul + 2.0 * cl / (k - 1.0) * (1.0 - (p / pl) ** ((k - 1.0) / (2.0 * k)))

    def behind_shock(p):
        return ur + (p - pr) * np.sqrt(2.0 / (rhor * ((k + 1.0) * p + (k - 1.0) * pr)))

    p = brentq(lambda p: behind_fan(p) - behind_shock(p), pr, pl, xtol=1e-14)
    u = behind_fan(p)
    rho1 = rhol * (p / pl) ** (1.0 / k)
    rho2 = rhor * ((k + 1.0) * p + (k - 1.0) * pr) / ((k - 1.0) * p + (k + 1.0) * pr)
    shock = rho2 * u / (rho2 - rhor)
    xi = (x - 0.5) / t if t > 0.0 else np.where(x < 0.5, -np.inf, np.inf)
    inside = np.clip(xi, ul - cl, u - np.sqrt(k * p / rho1))
    c = 2.0 / (k + 1.0) * (cl + 0.5 * (k - 1.0) * (ul - inside))
    fan = state(rhol * (c / cl) ** (2.0 / (k - 1.0)), inside + c, pl * (c / cl) ** (2.0 * k / (k - 1.0)))
    return np.where(xi < u, fan, np.where(xi < shock, state(rho2, u, p)[:, None], state(rhor, ur, pr)[:, None]))


def main(folder: Path) -> None:
    schemes = [fv.WavePropagation(solver) for solver in (fv.Roe(), fv.HLL(), HLLC())]
    report = fv.compare(problem, schemes, (100, 200, 400), exact, name="Sod's shock tube", repeats=1)
    print(report.table())
    report.save(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "shock_tube"))
