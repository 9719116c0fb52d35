"""Sphinx configuration: `sphinx-build -W --keep-going -b html docs docs/_build`."""

import os
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path.insert(0, str(DOCS / "extensions"))

#: Pictures of the documents must not depend on whether a compiler is installed, and need none at these sizes.
os.environ.setdefault("FVKIT_BACKEND", "numpy")
#: With a backend of the caller's, notebooks would not show the figures of pyplot.
os.environ.pop("MPLBACKEND", None)

import fvkit  # noqa: E402

project = "fvkit"
author = "The fvkit developers"
project_copyright = "The fvkit developers, BSD 3-Clause"
version = release = fvkit.__version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_nb",
    "sphinx_gallery.gen_gallery",
    "sphinxcontrib.bibtex",
    "plain_docstrings",
    "gallery_scripts",
    "mathml",
    "unbroken_numbers",
]
exclude_patterns = ["_build", "jupyter_execute", *(f"gallery/*.{kind}" for kind in ("py", "ipynb", "zip", "json", "md5"))]
templates_path = ["templates"]

html_theme = "pydata_sphinx_theme"
html_theme_options = {"navigation_depth": 2, "show_toc_level": 2}
html_title = f"fvkit {version}"
# The scripts of the gallery need the width.
html_sidebars = {"gallery/*": []}
# Pages work without a network: MathML needs no MathJax.
html_math_renderer = "mathml"
html_static_path = ["static"]
html_css_files = ["fvkit.css"]

# A role without a name, `fv.solve`, is a link where there is a page for it, and else code.
default_role = "py:obj"
# A name in a docstring that has no page is a mistake, but for these.
nitpicky = True
nitpick_ignore_regex = [
    ("py:class", r"abc\.ABC|enum\.Enum|fvkit\.pointwise\.part\.Part|fvkit\.testing\.common\.\w+"),
    ("py:class", r"fvkit\.problem\.open_ends\.(Given|Continued)|fvkit\.run\.observers\.SeriesObserver"),
    ("py:class", r"fvkit\.output\.results\.Results|fvkit\.studies\.report_data\.ReportData"),
    ("py:class", r"fvkit_granular\.models\.shallow_flow\.ShallowFlow"),
    # Modules without a page: named for those who read the code.
    ("py:obj", r"fvkit\.(backends|output|pointwise|problem|run|schemes|studies|sweeps|validation|files)\b.*"),
    ("py:obj", r"fvkit_granular\.(models|scenes|sources|studies|terrain|csv_table)\b.*"),
    ("py:obj", r"concurrent\.futures\..*"),
    # Names as seen from within their class or module, or as the examples abbreviate them.
    ("py:obj", r"hyperbolic_discriminant|phase_waves|latin_hypercube|grid|given|Status\.\w+|Part\.defines"),
    ("py:obj", r"acted|values|NET|NEW|MASS_FLUX|SPEED|Axis|Parts|Snapshots|Scene"),
    ("py:obj", r"cross|Continued|Indicators|fv\.sweep|gr\.steady|debris-slope"),
]
# Options of commands begin with two hyphens.
smartquotes = False
autosummary_generate = True
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
# Annotations stand in the docstrings in words; those of attrs' fields are converters.
autodoc_typehints = "none"

# Members are listed by the template of a class; a second list, of attributes without a text, would be numpydoc's.
numpydoc_show_class_members = False

myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
# A cache would know the cells, not the library that they show.
nb_execution_mode = "force"
nb_execution_timeout = 120
nb_execution_raise_on_error = True

# The scripts of examples/ with a picture are the gallery, as they are; that of a page of its own is shown, not run.
sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "ignore_pattern": r"^(order_tables|moving_equilibria)\.py$",
    "filename_pattern": r"/(?!work_precision)\w+\.py$",
    "image_scrapers": ("gallery_scripts.pictures",),
    "reset_argv": "gallery_scripts.arguments",
    "within_subsection_order": "FileNameSortKey",
    "thumbnail_size": (860, 580),
    "download_all_examples": False,
    "show_memory": False,
    "write_computation_times": False,  # that page loads scripts from the network
    "abort_on_example_error": True,
}

bibtex_bibfiles = ["references.bib"]
bibtex_default_style = "plain"

# External addresses are looked at by hand, CI has no network: `sphinx-build -b linkcheck docs docs/_build/links`.
linkcheck_timeout = 20
