"""Text tables and JSON values of reports."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

#: Columns of a terminal or a page that printed results keep to.
WIDTH = 100


def filled(text: str, indent: str = "") -> str:
    """Return a paragraph broken into lines of at most `WIDTH` columns, those after the first behind ``indent``."""
    return textwrap.fill(text, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def table(lines: Sequence[Sequence[str]], left: int = 2) -> str:
    """Return an aligned text table with a rule below the header; the first ``left`` columns are left-aligned."""
    rule = ["-" * max(len(line[k]) for line in lines) for k in range(len(lines[0]))]
    return "\n".join("  ".join(cell.ljust(len(dashes)) if k < left else cell.rjust(len(dashes))
                               for k, (cell, dashes) in enumerate(zip(line, rule, strict=True))).rstrip()
                     for line in [lines[0], rule, *lines[1:]])


def preformatted(text: str) -> str:
    """Return text as HTML for notebooks, columns aligned."""
    return f"<pre>{escape(text)}</pre>"


def plain(value: Any) -> Any:
    """Return a value as JSON data; NaN and infinite numbers become None."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


#: Errors below this count as round-off and have no observed order.
ROUNDING = 1e-13
