"""The code of documents."""

import re
from pathlib import Path


def code_blocks(page: Path, fence: str) -> list[str]:
    """Return the text of every block of a page that opens with ``fence``, such as ``python`` or ``{code-cell} ipython3``.

    Options of a notebook cell (lines ``:name: value``) are left out.
    """
    blocks = re.findall(rf"^```{re.escape(fence)}\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    return [re.sub(r"\A(:.*\n)+", "", block) for block in blocks]
