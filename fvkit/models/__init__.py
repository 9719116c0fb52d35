"""Teaching models: the smallest complete examples of the `fvkit.Model` contract."""

from fvkit.models.acoustics import Acoustics
from fvkit.models.advection import Advection
from fvkit.models.burgers import Burgers

__all__ = ["Acoustics", "Advection", "Burgers"]
