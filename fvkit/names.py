"""Names of parts in reports, files and on the command line: ``VanLeer`` is ``van-leer``."""

import re
from collections.abc import Iterable
from typing import Any

from fvkit.integrators import ARK4, DP5, SSPRK3, SSPRK104
from fvkit.limiters import MC, Minmod, NoLimiter, Superbee, ThirdOrder, VanLeer
from fvkit.reconstruction import MP5, MUSCL, WENO5
from fvkit.schemes import MethodOfLines, WavePropagation


def public_name(part: Any) -> str:
    """Return the name of a part (instance or class); a tuple of parts joins theirs with ``+``."""
    if isinstance(part, tuple):
        return "+".join(dict.fromkeys(public_name(item) for item in part)) if len(set(part)) == 1 else \
            "+".join(public_name(item) for item in part)
    kind = part if isinstance(part, type) else type(part)
    if kind is NoLimiter:
        return "none"
    return re.sub(r"(?<=[a-z])(?=[A-Z])", "-", kind.__name__).lower()


def by_name(kinds: Iterable[type]) -> dict[str, type]:
    """Return {public name: class}."""
    return {public_name(kind): kind for kind in kinds}


LIMITERS = by_name((NoLimiter, Minmod, MC, Superbee, VanLeer, ThirdOrder))

RECONSTRUCTIONS = by_name((MP5, WENO5, MUSCL))

INTEGRATORS = by_name((SSPRK104, SSPRK3, DP5, ARK4))

METHODS = by_name((WavePropagation, MethodOfLines))
