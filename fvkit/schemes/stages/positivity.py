"""Positivity: bounds of the mass flux of a face, and a fallback at faces next to dry ground.

A face may take from a cell at most what keeps its half of the mass: with F the mass flux, f the physical one,

    -(qr dx/dt - fr)/2  <=  F  <=  (ql dx/dt + fl)/2.

Then no mass turns negative at Courant numbers up to 1, one face at a time. A correction is reduced to the share that
stays inside, for all rows of its phase: fluxes stay fluxes, so masses and mixture momentum stay conserved. Derived here.

The rows of ``left_going`` that belong to masses hold F itself; see `fvkit.schemes.stages.fluctuations`.
"""

from fvkit.pointwise import TINY, largest_share, maximum, minimum, where
from fvkit.problem.answers import mass_flux as flux_of
from fvkit.schemes.scheme import MASS_FLUX

#: Half of a cell's mass, less what rounding may add to it.
HALF = 0.5 * (1.0 - 1e-14)

#: Corrections of a mass below this part of the mass that carries the momentum are rounding: the bounds alone hold them.
ROUNDING = 1e-14

#: Correction fluxes fade where the masses of neighbours differ by more than this factor.
SHORE = 4.0


def window(parts, ratio, ql, qr, row):
    """Return the bounds of dt/dx times the flux of a mass through a face."""
    fluxl, fluxr = flux_of(parts.model, ql)[row], flux_of(parts.model, qr)[row]
    return HALF * (ratio * fluxr - qr[row]), HALF * (ql[row] + ratio * fluxl)


def carriers(model):
    """Rows of the masses that carry the momentum of each phase."""
    return [masses[-1] for masses, _ in model.phases]


def apart(parts, ql, qr, factor):
    """Whether the masses of neighbours differ by more than a factor."""
    found = False
    for row in carriers(parts.model):
        found = found | (factor * minimum(ql[row], qr[row]) < maximum(ql[row], qr[row]))
    return found


def evenness(left, right, factor):
    """Return factor times the smaller over the larger of two masses; 0 where both are."""
    return factor * minimum(left, right) / (maximum(left, right) + TINY)


def within_window(parts, ratio, ql, qr, fluxes):
    """Whether no mass is overdrawn by fluxes, given by row; False for NaN."""
    found = True
    for row in parts.model.mass_rows():
        low, high = window(parts, ratio, ql, qr, row)
        found = found & (ratio * fluxes[row] >= low) & (ratio * fluxes[row] <= high)
    return found


# ---------------------------------------------------------------------- the window

def mass_fluxes(parts, ratio, left_going, correction=None):
    """Return the flux of each mass through a face, and the correction without the rows that have gone into it."""
    rows = parts.model.mass_rows()
    if correction is None:
        return {MASS_FLUX: tuple([left_going[row] for row in rows])}
    rest = tuple([0.0 if k in rows else item for k, item in enumerate(correction)])
    return {MASS_FLUX: tuple([left_going[row] + correction[row] for row in rows]), "correction": rest}


def may_overdraw(parts, ratio, ql, qr, mass_flux, correction=None, **others):
    """Whether a mass flux leaves the window, or neighbours differ enough to fade the correction of the face."""
    found = ~within_window(parts, ratio, ql, qr, dict(zip(parts.model.mass_rows(), mass_flux, strict=True)))
    return found if correction is None else found | apart(parts, ql, qr, SHORE)


def hold_within(parts, ratio, ql, qr, left_going, mass_flux, correction=None, cross=None):
    """Keep the mass fluxes within the window, to the last bit, and the corrections to the share that this allows.

    At shores the corrections fade.
    """
    terms = {name: list(term) for name, term in (("correction", correction), ("cross", cross)) if term is not None}
    held = []
    total = dict(zip(parts.model.mass_rows(), mass_flux, strict=True))
    for masses, momentum in parts.model.phases:
        factor, bounds = 1.0, [window(parts, ratio, ql, qr, row) for row in masses]
        if correction is not None:
            for row, (low, high) in zip(masses, bounds, strict=True):
                first = ratio * left_going[row]
                added = ratio * total[row] - first
                share = largest_share(added, first - low, high - first)
                if row != masses[-1]:  # what rounding makes of a mass that is absent must not reduce the others
                    share = where(maximum(added, -added) <= ROUNDING * minimum(ql[masses[-1]], qr[masses[-1]]), 1.0, share)
                factor = minimum(factor, share)
            fading = minimum(1.0, evenness(ql[masses[-1]], qr[masses[-1]], SHORE))
            factor = factor * fading
            terms["correction"][momentum] = factor * correction[momentum]
            if cross is not None:
                terms["cross"][momentum] = fading * cross[momentum]
        for row, (low, high) in zip(masses, bounds, strict=True):
            reduced = left_going[row] if correction is None else left_going[row] + factor * (total[row] - left_going[row])
            flux = total[row] if correction is None else where(factor < 1.0, reduced, total[row])
            held.append(where(ratio * flux > high, high / ratio, where(ratio * flux < low, low / ratio, flux)))
    return {MASS_FLUX: tuple(held), **{name: tuple(term) for name, term in terms.items()}}
