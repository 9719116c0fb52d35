"""Tests run on the NumPy backend unless they ask for another: compiling is tested once, in tests/backends."""

import os

os.environ["FVKIT_BACKEND"] = "numpy"
os.environ.setdefault("MPLBACKEND", "Agg")
