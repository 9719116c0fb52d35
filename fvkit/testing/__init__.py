"""Conformance suites: five lines of test for a part of yours give about twenty checks, on both backends.

>>> class TestMine(fvkit.testing.ModelConformance):          # doctest: +SKIP
...     model = MyModel(speed=2.0)
...
...     def states(self, rng, count):
...         return rng.uniform(0.5, 2.0, (2, count))

pytest collects the class as any other. The suites ask what a part defines and skip, by name, what does not concern it.
"""

from fvkit.testing.models import ModelConformance
from fvkit.testing.parts import LimiterConformance, SourceConformance
from fvkit.testing.riemann import RiemannConformance

__all__ = ["LimiterConformance", "ModelConformance", "RiemannConformance", "SourceConformance"]
