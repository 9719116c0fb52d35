"""The Roe solver."""

from typing import ClassVar

import attrs

from fvkit.riemann.base import RiemannSolver


@attrs.frozen
class Roe(RiemannSolver):
    """Roe's linearisation: the jump as a sum of eigenvectors of the Roe-mean matrix.

    The sharpest solver; it needs ``decompose`` of the model. By itself it guarantees neither positive depths near vacuum,
    where the scheme falls back to the model's ``relaxation``, nor, without the entropy fix of the scheme, a physical
    transonic rarefaction.

    Source: P. L. Roe, J. Comput. Phys. 43 (1981) 357-372; f-waves: Bale, LeVeque, Mitran, Rossmanith,
    SIAM J. Sci. Comput. 24 (2003) 955-978.
    """

    needs: ClassVar[tuple[str, ...]] = ("decompose",)
    eigenvectors: ClassVar[bool] = True

    def solve(self, model, ql, qr, auxl, auxr, jump):
        return model.decompose(ql, qr, auxl, auxr, jump)
