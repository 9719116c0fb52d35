"""The tutorials run as they stand, cell by cell, without notebook software."""

from pathlib import Path

import matplotlib.pyplot as plt
import pytest

from tests.pages import code_blocks

FOLDER = Path(__file__).parent.parent / "docs" / "tutorials"
TUTORIALS = ("first_run", "first_model", "own_riemann_solver", "own_drag_law", "three_models", "two_layer_model", "dam_break_island")
KERNEL = """---
jupytext:
  text_representation:
    extension: .md
    format_name: myst
kernelspec:
  display_name: Python 3
  language: python
  name: python3
---
"""


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_runs_and_draws(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = FOLDER / f"{name}.md"
    cells = code_blocks(page, "{code-cell} ipython3")
    namespace = {"__name__": name}
    try:
        for number, cell in enumerate(cells, start=1):
            exec(compile(cell, f"{page.name}, cell {number}", "exec"), namespace)
        assert plt.get_fignums(), "a tutorial shows its point in a picture"
    finally:
        plt.close("all")
    assert not list(tmp_path.iterdir()), "a tutorial leaves no files behind"


@pytest.mark.parametrize("name", TUTORIALS)
def test_a_tutorial_is_a_notebook_whose_checks_can_fail(name):
    text = (FOLDER / f"{name}.md").read_text(encoding="utf-8")
    assert text.startswith(KERNEL)
    assert "raise " in text
    assert "## Where to go next" in text


@pytest.mark.parametrize("name", TUTORIALS)
def test_code_of_a_tutorial_fits_its_column(name):
    cells = code_blocks(FOLDER / f"{name}.md", "{code-cell} ipython3")
    assert not [line for cell in cells for line in cell.splitlines() if len(line) > 75]


def test_every_tutorial_is_run():
    assert {page.stem for page in FOLDER.glob("*.md")} - {"index"} == set(TUTORIALS)


def test_the_first_model_takes_thirty_lines():
    cells = code_blocks(FOLDER / "first_model.md", "{code-cell} ipython3")[:4]
    assert "fv.solve" in cells[-1]
    assert sum(bool(line.strip()) for cell in cells for line in cell.splitlines()) <= 30
