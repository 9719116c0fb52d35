"""Equations as MathML: browsers show it without a network or a script; TeX that is not understood is a warning."""

import re
from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

LOG = logging.getLogger(__name__)
#: Digits as fraction, `\tfrac12`, which the converter of docutils takes for one number.
DIGITS = re.compile(r"(\\[td]?frac)\s*(\d)\s*(\d)")
#: Accents: a subscript of an accented letter stands beside it, not below.
ACCENTS = "ˆˉ˙˜"


def converted(tex: str, as_block: bool) -> str:
    """Return MathML of a formula in TeX, or raise MathError."""
    markup = tex2mathml(DIGITS.sub(r"\1{\2}{\3}", tex.strip()), as_block=as_block)
    tree = ElementTree.fromstring(markup.replace("&ApplyFunction;", "\u2061"))
    space = tree.tag.removesuffix("math")
    for node in tree.iter(f"{space}mo"):
        if node.text in ("|", "∣"):  # bars of an absolute value: neither relations nor stretched
            node.attrib.update(stretchy="false", lspace="0", rspace="0")
    for node in tree.iter(f"{space}munderover"):
        base, low, high = node
        if high.text in ACCENTS:
            accented = ElementTree.Element(f"{space}mover", accent="true")
            accented.extend((base, high))
            node.tag = f"{space}msub"
            node[:] = accented, low
    ElementTree.register_namespace("", space.strip("{}"))
    return ElementTree.tostring(tree, encoding="unicode")


def _written(translator: Any, node: nodes.Node, opening: str, closing: str, as_block: bool) -> None:
    try:
        markup = converted(node.astext(), as_block)
    except (MathError, ElementTree.ParseError) as error:
        LOG.warning("TeX that becomes no MathML: %s", error, location=node)
        markup = translator.encode(node.astext())
    translator.body.append(f"{opening}{markup}{closing}")
    raise nodes.SkipNode


def inline(translator: Any, node: nodes.Node) -> None:
    """Write a formula within a sentence; no line begins with the comma or full stop behind it (word joiner)."""
    _written(translator, node, '<span class="math">', "</span>\u2060", as_block=False)


def block(translator: Any, node: nodes.Node) -> None:
    """Write a formula on lines of its own, which scrolls where the page is narrow."""
    _written(translator, node, '<div class="math">', "</div>\n", as_block=True)


def setup(app: Any) -> dict[str, Any]:
    """Name the renderer; `html_math_renderer` chooses it."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
