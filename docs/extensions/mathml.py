"""Equations as MathML: browsers show it without a network or a script; TeX that is not understood is a warning."""

from typing import Any

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

LOG = logging.getLogger(__name__)


def _written(translator: Any, node: nodes.Node, opening: str, closing: str, as_block: bool) -> None:
    try:
        markup = tex2mathml(node.astext().strip(), as_block=as_block)
    except MathError as error:
        LOG.warning("TeX that becomes no MathML: %s", error, location=node)
        markup = translator.encode(node.astext())
    translator.body.append(f"{opening}{markup}{closing}")
    raise nodes.SkipNode


def inline(translator: Any, node: nodes.Node) -> None:
    """Write a formula within a sentence."""
    _written(translator, node, '<span class="math">', "</span>", as_block=False)


def block(translator: Any, node: nodes.Node) -> None:
    """Write a formula on lines of its own, which scrolls where the page is narrow."""
    _written(translator, node, '<div class="math">', "</div>\n", as_block=True)


def setup(app: Any) -> dict[str, Any]:
    """Name the renderer; `html_math_renderer` chooses it."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
