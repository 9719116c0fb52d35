"""`GivenFlow`: a boundary where a flow comes in, for every model."""

from typing import Any

import attrs

from fvkit import _validate
from fvkit.boundary import Given


@attrs.frozen
class GivenFlow(Given):
    """A constant flow at the end, as `fvkit.Inflow`, but in terms that every model understands.

    The Riemann solver lets in what travels inwards: of a subcritical flow only a part is imposed.

    Parameters
    ----------
    h : depth, m, >= 0.
    phi : solid fraction in [0, 1].
    vs, vf : velocities of solid and fluid, m/s, positive to the right.
    slope : fall of the bottom per metre beyond the end, outwards, positive where it falls; None for that of the last two cells.
    """

    # Not annotated as floats: those are parameters of pointwise code, and here only `values`, plain Python, reads them.
    h: Any = attrs.field(converter=_validate.within(at_least=0.0, hint="depth in m"))  # type: ignore[misc]
    phi: Any = attrs.field(converter=_validate.within(at_least=0.0, at_most=1.0, hint="solid fraction"))  # type: ignore[misc]
    vs: Any = attrs.field(default=0.0, converter=_validate.within(hint="velocity in m/s"))  # type: ignore[misc]
    vf: Any = attrs.field(default=0.0, converter=_validate.within(hint="velocity in m/s"))  # type: ignore[misc]

    def given(self, model, t):
        if not callable(getattr(model, "conserved_from", None)):
            raise ValueError(f"GivenFlow needs a model with h, phi, vs, vf; {type(model).__name__} has no `conserved_from`")
        return tuple(float(value) for value in model.conserved_from(self.h, self.phi, self.vs, self.vf))
