"""Conformance suites: five lines of test for a part of yours give about twenty checks, on both backends.

>>> class TestMine(fvkit.testing.ModelConformance):          # doctest: +SKIP
...     model = MyModel(speed=2.0)
...
...     def states(self, rng, count):
...         return rng.uniform(0.5, 2.0, (2, count))

pytest collects the class as any other, and `run` does without it. The suites check what a part defines and skip, by name,
what does not concern it.
"""

import pytest

# Before the suites are imported: pytest then shows the values of a bare assert in them, as of one in a user's file.
pytest.register_assert_rewrite("fvkit.testing.common", "fvkit.testing.models", "fvkit.testing.parts", "fvkit.testing.riemann")

from fvkit.testing.models import ModelConformance
from fvkit.testing.parts import LimiterConformance, SourceConformance
from fvkit.testing.riemann import RiemannConformance
from fvkit.testing.run import Outcome, run

__all__ = ["LimiterConformance", "ModelConformance", "Outcome", "RiemannConformance", "SourceConformance", "run"]
