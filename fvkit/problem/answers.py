"""Flux and wave speeds of a model at a place, with or without aux values: solvers and schemes call them here.

``flux(q)`` and ``wave_speeds(q)`` may take the aux values as well, where the law depends on x: which of them do is decided
once, when the class of the model is made (`Model.takes_aux`), and the others make the same code as ever.
"""

import numpy as np

from fvkit.pointwise import combine, maximum, minimum, subtract, where

#: Shares of the way from one state to the other at which the speeds of a scalar law are looked at.
BETWEEN = (0.2, 0.4, 0.6, 0.8)

#: States at which the speeds of a scalar law are looked at to find whether they are monotone.
SCANNED = 769

#: Change of a state, as a share of its size, above which the speed of its jump is more than rounding.
CHANGED = 1e-6


def flux(model, q, aux):
    """Return f(q) or f(q, aux)."""
    return model.flux(q, aux[:len(model.aux)]) if "flux" in model.takes_aux else model.flux(q)


def mass_flux(model, q):
    """Return f(q) of a model with masses, of which only the rows of masses count: these depend on no aux values."""
    return flux(model, q, (1.0,) * len(model.aux))


def wave_speeds(model, q, aux):
    """Return two bounds of the characteristic speeds at a state."""
    return model.wave_speeds(q, aux[:len(model.aux)]) if "wave_speeds" in model.takes_aux else model.wave_speeds(q)


def at_face(model, name, ql, qr, auxl, auxr):
    """Return what a model answers to a question of a face that it may answer without the aux values."""
    return getattr(model, name)(ql, qr, *((auxl[:len(model.aux)], auxr[:len(model.aux)]) if name in model.takes_aux else ()))


def looks_between(model):
    """Whether speeds between the states of a face are looked at, not only those of both sides."""
    return model.scans or model.defines("speeds_between")


def monotone(model, q, aux):
    """Whether the speeds of a scalar law are monotone from the least to the largest of values q (n,), and as far beyond."""
    low, high = float(np.min(q)), float(np.max(q))
    beyond = (high - low) or abs(high) or 1.0
    u = np.linspace(low - beyond, high + beyond, SCANNED)
    for given in zip(*aux, strict=True) if aux else ((),):
        with np.errstate(all="ignore"):
            bounds = wave_speeds(model, (u,), tuple([np.full(u.shape, value) for value in given]))
        for bound in bounds:
            values = np.broadcast_to(bound, u.shape)
            steps = np.diff(values[np.isfinite(values)])
            steps = steps[np.abs(steps) > 1e-9 * np.abs(values[np.isfinite(values)]).max(initial=0.0)]
            if (steps > 0.0).any() and (steps < 0.0).any():
                return False
    return True


def end_speeds(model, ql, qr, auxl, auxr):
    """Return two bounds of the speeds of both sides of a face."""
    lowl, highl = wave_speeds(model, ql, auxl)
    lowr, highr = wave_speeds(model, qr, auxr)
    return minimum(lowl, lowr), maximum(highl, highr)


def face_speeds(model, ql, qr, auxl, auxr):
    """Return two bounds of the speeds of all states between both sides of a face: what a Riemann solver takes.

    They are those of ``speeds_between`` where the model defines it, else those of both sides; of a scalar law that ``scans``,
    those of some states between as well, and the speed [f]/[q] of the jump.
    """
    if model.defines("speeds_between"):
        return at_face(model, "speeds_between", ql, qr, auxl, auxr)
    low, high = end_speeds(model, ql, qr, auxl, auxr)
    if not looks_between(model):
        return low, high
    for share in BETWEEN:
        lower, upper = wave_speeds(model, combine(1.0 - share, ql, share, qr), combine(1.0 - share, auxl, share, auxr))
        low, high = minimum(low, lower), maximum(high, upper)
    if model.defines("jump") or "flux" in model.takes_aux:
        return low, high
    change, jump = qr[0] - ql[0], subtract(flux(model, qr, auxr), flux(model, ql, auxl))[0]
    counts = np.abs(change) > CHANGED * (np.abs(ql[0]) + np.abs(qr[0]))
    speed = jump / where(counts, change, 1.0)
    return where(counts, minimum(low, speed), low), where(counts, maximum(high, speed), high)
