"""Mutants for every day: one change each, the tests that must see it, and nothing drawn at random. They need no tool but pytest."""

from typing import NamedTuple


class Fault(NamedTuple):
    """A change of one module: ``old``, which stands in it once, becomes ``new``."""

    module: str
    old: str
    new: str
    tests: str


_RIEMANN, _REDUCED = "tests/core/test_riemann.py", "tests/granular/test_reduced_shallow.py"

FAULTS = (
    Fault("fvkit/schemes/limiters.py", "minimum(2.0, theta)", "minimum(3.0, theta)", "tests/core/test_limiters.py::test_the_limiter_has_its_exact_value"),
    Fault("fvkit/schemes/reconstruction.py", "47.0 * c", "46.0 * c", "tests/core/test_reconstruction.py::test_mp5_is_the_median_of_fifth_order_and_its_bounds"),
    Fault("fvkit/schemes/riemann.py", "-0.5 * s", "0.5 * s", f"{_RIEMANN}::test_hll_and_rusanov_have_their_values_for_burgers"),
    Fault("fvkit/schemes/riemann.py", "combine(ratio * face.s2", "combine(ratio * face.s1", f"{_RIEMANN}::test_hll_and_rusanov_have_their_values_for_burgers"),
    Fault("fvkit_granular/sources/drag_laws.py", "2.0**-53", "2.0**53", "tests/granular/test_drag.py::test_endless_drag_takes_all_slip_and_no_momentum"),
    Fault("fvkit_granular/sources/friction_laws.py", "drive - strong * u * u", "drive + strong * u * u",
          "tests/granular/test_friction.py::test_every_law_tends_to_the_answer_of_an_ode_solver"),
    Fault("fvkit_granular/models/shallow_water.py", "(s2 * first - second)", "(s1 * first - second)",
          f"{_REDUCED}::test_the_waves_are_eigenvectors_that_add_up_to_the_jump_on_any_bottom"),
    Fault("fvkit_granular/models/shallow_water.py", "push = self.g * (qr[1] - ql[1])", "push = self.g * (qr[1] + ql[1])",
          f"{_REDUCED}::test_shallow_water_is_the_reduced_model_at_uniform_density"),
    Fault("fvkit/schemes/stages/cell_polynomial.py", "one - 20.0 * two", "one + 20.0 * two",
          "tests/granular/test_method_of_lines.py::test_the_closed_integral_over_a_cell_is_that_of_the_jumps_to_seventh_order"),
    Fault("fvkit/schemes/stages/dry_fallback.py", "> SEPARATING * sound, 2.0 -", "> SEPARATING * sound, 1.0 -", "tests/granular/test_fingerprints.py"),
    Fault("fvkit/schemes/stages/dry_fallback.py", "parts.across > 0", "parts.across > 9", "tests/plane/test_sides.py"),
    Fault("fvkit/pointwise/tracing.py", 'graph.node("minimum", graph.node("maximum", a, low), high)',
          'graph.node("maximum", graph.node("maximum", a, low), high)',
          "tests/backends/test_trace.py::test_a_compiled_operation_means_what_numpy_means[clip]"),
    Fault("fvkit/backends/compiled/llvm.py", "number(1.0 / math.factorial(12))", "number(1.0 / math.factorial(11))",
          "tests/backends/test_trace.py::test_functions_are_exact_to_a_unit_in_the_last_place"),
)
