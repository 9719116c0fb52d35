"""How reports are written: aligned text, and values that JSON knows."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np


def table(lines: Sequence[Sequence[str]], left: int = 2) -> str:
    """Return lines of cells as aligned text, a rule below the first; the first ``left`` columns start at their left."""
    rule = ["-" * max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join("  ".join(cell.ljust(len(dashes)) if k < left else cell.rjust(len(dashes))
                               for k, (cell, dashes) in enumerate(zip(line, rule, strict=True))).rstrip()
                     for line in [lines[0], rule, *lines[1:]])


def plain(value: Any) -> Any:
    """Return a value as JSON knows it; what is not a finite number is null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


#: Errors below this have no order, and make no curve worth drawing.
ROUNDING = 1e-13
