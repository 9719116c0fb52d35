"""Equations of the documents become MathML without a script: the right one, also where TeX has short spellings."""

import importlib.util
from pathlib import Path
from xml.etree import ElementTree

import pytest

EXTENSION = Path(__file__).parent.parent / "docs" / "extensions" / "mathml.py"


@pytest.fixture(scope="module")
def converted():
    pytest.importorskip("sphinx")
    spec = importlib.util.spec_from_file_location("mathml", EXTENSION)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.converted


def plain(node):
    """Return a formula as nested lists of tags and texts."""
    tag = node.tag.rpartition("}")[2]
    return [tag, *(plain(child) for child in node)] if len(node) else [tag, node.text]


@pytest.mark.parametrize(("tex", "wanted"), [
    (r"\tfrac12 v", ["math", ["mfrac", ["mn", "1"], ["mn", "2"]], ["mi", "v"]]),
    (r"\frac{12}{5}", ["math", ["mfrac", ["mn", "12"], ["mn", "5"]]]),
    (r"\hat h_s", ["math", ["msub", ["mover", ["mi", "h"], ["mo", "ˆ"]], ["mi", "s"]]]),
    (r"\sum_k^n a", ["math", ["munderover", ["mo", "∑"], ["mi", "k"], ["mi", "n"]], ["mi", "a"]]),
])
def test_short_spellings(converted, tex, wanted):
    assert plain(ElementTree.fromstring(converted(tex, as_block=True))) == wanted


def test_bars_of_an_absolute_value_stay_small(converted):
    bars = [node for node in ElementTree.fromstring(converted("|v|", as_block=False)) if node.text in ("|", "∣")]
    assert [bar.get("lspace") for bar in bars] == ["0", "0"]


def test_what_is_no_equation_is_refused(converted):
    with pytest.raises(ValueError, match="unknownmacro"):
        converted(r"\unknownmacro x", as_block=True)
