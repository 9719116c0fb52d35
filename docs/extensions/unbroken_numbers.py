"""Numbers such as 1e-13 in tables: browsers would break them after the hyphen."""

import re
from typing import Any

from docutils import nodes
from sphinx.transforms.post_transforms import SphinxPostTransform

NUMBER = re.compile(r"(\d+(?:\.\d+)?e-\d+)")


class UnbrokenNumbers(SphinxPostTransform):
    """Put each number with a negative exponent within a table into a span of the class ``number``."""

    default_priority = 900
    formats = ("html",)

    def run(self, **kwargs: Any) -> None:
        for entry in list(self.document.findall(nodes.entry)):
            for text in list(entry.findall(nodes.Text)):
                pieces = NUMBER.split(text.astext())
                if len(pieces) > 1 and not isinstance(text.parent, nodes.literal):
                    text.parent.replace(text, [nodes.inline(piece, piece, classes=["number"]) if k % 2 else nodes.Text(piece)
                                               for k, piece in enumerate(pieces) if piece])


def setup(app: Any) -> dict[str, Any]:
    """Add the transform."""
    app.add_post_transform(UnbrokenNumbers)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
