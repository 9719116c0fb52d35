"""Numbers such as 1e-13: browsers would break them after the hyphen."""

import re
from typing import Any

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

#: Nodes whose text is code, a formula or for a writer.
UNCHANGED = (nodes.literal, nodes.FixedTextElement, nodes.math, nodes.math_block, nodes.raw)

NUMBER = re.compile(r"(\d+(?:\.\d+)?e-\d+)")


class UnbrokenNumbers(SphinxPostTransform):
    """Put each number with a negative exponent, outside of code and formulas, into a span of the class ``number``."""

    default_priority = 900
    formats = ("html",)

    def run(self, **kwargs: Any) -> None:
        for text in list(self.document.findall(nodes.Text)):
            pieces = NUMBER.split(text.astext())
            if len(pieces) > 1 and not isinstance(text.parent, UNCHANGED):
                text.parent.replace(text, [nodes.inline(piece, piece, classes=["number"]) if k % 2 else nodes.Text(piece)
                                           for k, piece in enumerate(pieces) if piece])


def setup(app: Any) -> dict[str, Any]:
    """Add the transform."""
    app.add_post_transform(UnbrokenNumbers)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
