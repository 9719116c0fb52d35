"""Mutants for every day: one change each, the tests that must see it, and nothing drawn at random. They need no tool but pytest."""

from typing import NamedTuple


class Fault(NamedTuple):
    """A change of one module: ``old``, which stands in it once, becomes ``new``."""

    module: str
    old: str
    new: str
    tests: str


FAULTS = (
    Fault("fvkit/limiters.py", "minimum(2.0, theta)", "minimum(3.0, theta)", "tests/core/test_limiters.py"),
    Fault("fvkit/riemann/rusanov.py", "-0.5 * s", "0.5 * s", "tests/core/test_riemann.py"),
    Fault("fvkit/riemann/hll.py", "minimum(lowl, lowr)", "minimum(lowl, highr)", "tests/core/test_riemann.py"),
    Fault("fvkit_granular/drag.py", "2.0**-53", "2.0**53", "tests/granular/test_drag.py"),
    Fault("fvkit_granular/friction.py", "1.0 + 4.0 * a * speed", "1.0 - 4.0 * a * speed", "tests/granular/test_friction.py"),
    Fault("fvkit_granular/shallow_water.py", "(s2 * first - second)", "(s1 * first - second)", "tests/granular/test_reduced_shallow.py"),
    Fault("fvkit_granular/shallow_water.py", "push = self.g * (qr[1] - ql[1])", "push = self.g * (qr[1] + ql[1])",
          "tests/granular/test_reduced_shallow.py"),
    Fault("fvkit/schemes/cells.py", "- 20.0 * two", "+ 20.0 * two", "tests/core/test_method_of_lines.py"),
    Fault("fvkit/backends/trace.py", 'graph.node("minimum", graph.node("maximum", a, low), high)',
          'graph.node("maximum", graph.node("maximum", a, low), high)', "tests/backends/test_trace.py"),
    Fault("fvkit/backends/emit.py", 'number(1.0 / math.factorial(12))', 'number(1.0 / math.factorial(11))', "tests/backends/test_trace.py"),
)
