"""The pointwise contract: what a user's part may contain, and how a breach is named."""

import inspect
import math
from functools import cache
from pathlib import Path

import attrs
import numpy as np
import pytest

import fvkit as fv
from tests.cases import Stepper, solve

OFFSETS = [0.0, 1.0]
FACTOR = 2.0


class UserError(Exception):
    """Raised by a user's own code."""


def slope_by_branch(u):
    if u > 0.0:
        return u
    return -u


def harmless(u):
    return FACTOR * u


def passes_on(u):
    return slope_by_branch(u)


@attrs.frozen
class Good(fv.Model):
    conserved = ("u",)
    factor: float = 1.0

    def flux(self, q):
        (u,) = q
        return (self.factor * u,)

    def wave_speeds(self, q):
        return self.factor, self.factor


class IfOnValue(Good):
    def flux(self, q):
        (u,) = q
        if u > 0.0:
            u = -u
        return (u,)


class AndOnValues(Good):
    def wave_speeds(self, q):
        (u,) = q
        low = (u > 0.0) and (u < 1.0)
        return low, u


class ConditionalExpression(Good):
    def flux(self, q):
        (u,) = q
        return (u if u > 0.0 else -u,)


class WhileOnValue(Good):
    def flux(self, q):
        (u,) = q
        while u > 1.0:
            u = u - 1.0
        return (u,)


class ChainedComparison(Good):
    def flux(self, q):
        (u,) = q
        return ((0.0 < u < 1.0) * u,)


class UnknownAttribute(Good):
    def flux(self, q):
        (u,) = q
        return (self.factr * u,)


class PlainClassConstant(Good):
    constant = 3.0

    def flux(self, q):
        (u,) = q
        return (self.constant * u,)


class BuiltinMaximum(Good):
    def wave_speeds(self, q):
        (u,) = q
        return min(u, 0.0), u


class ScalarModule(Good):
    def flux(self, q):
        (u,) = q
        return (math.sin(u),)


class UndefinedName(Good):
    def flux(self, q):
        (u,) = q
        return (factr * u,)  # noqa: F821


class GlobalList(Good):
    def flux(self, q):
        (u,) = q
        return (OFFSETS[1] * u,)


class Comprehension(Good):
    def flux(self, q):
        return tuple([u * u for u in q])


class GeneratorExpression(Good):
    def flux(self, q):
        return tuple(u * u for u in q)


class UsesSuper(Good):
    def flux(self, q):
        return super().flux(q)


class TooManyComponents(Good):
    def flux(self, q):
        (u,) = q
        return u, u


class OneSpeed(Good):
    def wave_speeds(self, q):
        (u,) = q
        return (u,)


class SumOverCells(Good):
    def flux(self, q):
        (u,) = q
        return (np.array([np.sum(u), 0.0]),)


class Stacked(Good):
    def flux(self, q):
        (u,) = q
        return (np.stack([u, u]),)


class MissingTuple(Good):
    def flux(self, q):
        (u,) = q
        return u


class ArrayForTuple(Good):
    def wave_speeds(self, q):
        (u,) = q
        return np.stack([u, u])


class HelperBranches(Good):
    def flux(self, q):
        (u,) = q
        return (slope_by_branch(u),)


class HelperOfHelperBranches(Good):
    def flux(self, q):
        (u,) = q
        return (passes_on(u),)


class MethodBranches(Good):
    def speed(self, u):
        return u if u > 0.0 else -u

    def flux(self, q):
        (u,) = q
        return (self.speed(u) * u,)


class DecomposeReturnsWavesOnly(Good):
    def decompose(self, ql, qr, auxl, auxr, jump):
        return (jump,)


class DecomposeForgetsASpeed(Good):
    def decompose(self, ql, qr, auxl, auxr, jump):
        return (jump, jump), (self.factor,)


class AdmissibleBranches(Good):
    def admissible(self, q):
        (u,) = q
        return u > 0.0 or u < -1.0


def from_scope(factor):
    class Closure(Good):
        def flux(self, q):
            (u,) = q
            return (factor * u,)

    return Closure


class SumAsFactor(Good):
    def flux(self, q):
        (u,) = q
        return (np.sum(u) * u,)


class ExtremeOfAllCells(Good):
    def wave_speeds(self, q):
        (u,) = q
        return np.min(u), np.max(u)


class NeighbourByRoll(Good):
    def flux(self, q):
        (u,) = q
        return (np.roll(u, 1) - u,)


class NoneForAComponent(Good):
    def flux(self, q):
        return (None,)


class TextForAComponent(Good):
    def flux(self, q):
        return ("u",)


class ComplexComponent(Good):
    def flux(self, q):
        return (1j * q[0],)


class DecoratedMethod(Good):
    @cache  # noqa: B019
    def flux(self, q):
        return q


class InPlace(Good):
    def flux(self, q):
        (u,) = q
        u *= 2.0
        return (u,)


def problem(model, **options):
    return fv.Problem(model, fv.Grid(0.0, 1.0, 8), lambda x: 1.0 + 0.0 * x[None], 1.0, **options)


def line_of(function, text):
    lines, first = inspect.getsourcelines(function)
    return first + next(offset for offset, line in enumerate(lines) if text in line)


def assert_refused(error, method, rule, function, text=None):
    """The message names the method, this file, the line (of ``text``, or any of the function's) and the rule."""
    message = str(error.value)
    assert method in message
    assert Path(__file__).name in message
    assert rule in message
    lines, first = inspect.getsourcelines(function)
    named = int(message.split(f"{Path(__file__).name}:")[1].split(")")[0])
    if text is None:
        assert first <= named < first + len(lines)
    else:
        assert named == line_of(function, text)


REFUSED_MODELS = [
    (IfOnValue, "flux", "fv.where", "if u > 0.0"),
    (AndOnValues, "wave_speeds", "fv.where", "and (u < 1.0)"),
    (ConditionalExpression, "flux", "fv.where", "if u > 0.0 else"),
    (WhileOnValue, "flux", "fv.where", "while u > 1.0"),
    (ChainedComparison, "flux", "fv.where", "0.0 < u < 1.0"),
    (UnknownAttribute, "flux", "self.factr is neither a parameter of UnknownAttribute (factor)", "self.factr"),
    (PlainClassConstant, "flux", "self.constant is neither a parameter", "self.constant"),
    (BuiltinMaximum, "wave_speeds", "use fv.minimum(a, b)", "min(u, 0.0)"),
    (ScalarModule, "flux", "use np.sqrt and its like", "math.sin"),
    (UndefinedName, "flux", "the name factr is not defined", "factr * u"),
    (GlobalList, "flux", "the global OFFSETS is a list", "OFFSETS"),
    (from_scope(2.0), "flux", "enclosing scope (factor)", None),
    (UsesSuper, "flux", "super()", None),
    (Comprehension, "flux", "no comprehension", None),
    (GeneratorExpression, "flux", "no comprehension", None),
    (TooManyComponents, "flux", "returns 2 components, 1 are needed", None),
    (OneSpeed, "wave_speeds", "returns 1 components, 2 are needed", None),
    (SumOverCells, "flux", "component 0 has shape (2,)", None),
    (Stacked, "flux", "component 0 has shape (2, ", None),
    (MissingTuple, "flux", "must return a tuple of 1 components, got an array of shape", None),
    (ArrayForTuple, "wave_speeds", "must return a tuple of 2 components, got an array of shape", None),
    (DecomposeReturnsWavesOnly, "decompose", "pair (waves, speeds)", None),
    (DecomposeForgetsASpeed, "decompose", "2 waves and 1 speeds", None),
    (AdmissibleBranches, "admissible", "fv.where", "or u < -1.0"),
]


@pytest.mark.parametrize(
    ("model", "method", "rule", "text"), REFUSED_MODELS, ids=lambda v: getattr(v, "__name__", None)
)
def test_a_model_that_breaks_a_rule_is_refused_by_the_problem_with_method_file_line_and_rule(model, method, rule, text):
    with pytest.raises(fv.PointwiseError) as error:
        problem(model())
    assert_refused(error, f"{model.__name__}.{method}", rule, getattr(model, method), text)


@pytest.mark.parametrize(
    ("model", "method"),
    [(SumAsFactor, "flux"), (ExtremeOfAllCells, "wave_speeds"), (NeighbourByRoll, "flux")],
    ids=lambda v: getattr(v, "__name__", None),
)
def test_a_method_that_looks_at_more_than_its_own_cell_is_refused(model, method):
    with pytest.raises(fv.PointwiseError) as error:
        fv.Problem(model(), fv.Grid(0.0, 1.0, 8), lambda x: 1.0 + x[None], 1.0)
    assert_refused(error, f"{model.__name__}.{method}", "pointwise", getattr(model, method))


@pytest.mark.parametrize("model", [NoneForAComponent, TextForAComponent, ComplexComponent], ids=lambda v: v.__name__)
def test_a_component_that_is_no_real_number_is_refused(model):
    with pytest.raises(fv.PointwiseError) as error:
        problem(model())
    assert_refused(error, f"{model.__name__}.flux", "component 0", model.flux)


def test_a_decorated_method_is_refused_with_its_name():
    with pytest.raises(fv.PointwiseError, match=r"DecoratedMethod.flux"):
        problem(DecoratedMethod())


def test_a_method_that_writes_into_its_arguments_is_refused():
    with pytest.raises((fv.PointwiseError, ValueError)):
        problem(InPlace())


@pytest.mark.parametrize(
    ("model", "helper"), [(HelperBranches, slope_by_branch), (HelperOfHelperBranches, slope_by_branch)]
)
def test_a_helper_function_is_examined_and_named_in_its_own_line(model, helper):
    with pytest.raises(fv.PointwiseError) as error:
        problem(model())
    assert_refused(error, helper.__name__, "fv.where", helper, "if u > 0.0")


def test_another_method_of_the_model_is_examined_where_it_is_called():
    with pytest.raises(fv.PointwiseError) as error:
        problem(MethodBranches())
    assert_refused(error, "MethodBranches.speed", "fv.where", MethodBranches.speed, "if u > 0.0 else")


def test_a_refusal_is_a_type_error():
    assert issubclass(fv.PointwiseError, TypeError)


def test_helpers_number_globals_and_loops_over_components_are_accepted():
    class Accepted(Good):
        def flux(self, q):
            result = []
            for u in q:
                result.append(harmless(u) * self.factor)
            return tuple(result)

    accepted = problem(Accepted())
    np.testing.assert_array_equal(accepted.model.flux(tuple(accepted.q0))[0], 2.0 * accepted.q0[0])


def raises_value_error(u):
    raise ValueError("my own words")


class RaisesValueError(Good):
    def flux(self, q):
        return (raises_value_error(q[0]),)


class RaisesUserError(Good):
    def wave_speeds(self, q):
        raise UserError("no speeds today")


def test_a_value_error_of_the_users_flux_passes_through_unchanged():
    with pytest.raises(ValueError, match=r"^my own words$") as error:
        problem(RaisesValueError())
    assert type(error.value) is ValueError
    assert error.value.__cause__ is None


def test_an_exception_type_of_the_user_passes_through_unchanged():
    with pytest.raises(UserError, match=r"^no speeds today$"):
        problem(RaisesUserError())


def test_an_exception_of_the_users_initial_function_passes_through_unchanged():
    def initial(x):
        raise UserError("no data today")

    with pytest.raises(UserError, match=r"^no data today$"):
        fv.Problem(Good(), fv.Grid(0.0, 1.0, 8), initial, 1.0)


class BranchingSolver(fv.RiemannSolver):
    def solve(self, model, ql, qr, auxl, auxr, jump):
        speed = model.wave_speeds(ql)[0]
        if speed > 0.0:
            return (jump,), (speed,)
        return (jump,), (-speed,)


class AsksForTooMuch(fv.RiemannSolver):
    def solve(self, model, ql, qr, auxl, auxr, jump):
        return (jump,), (model.celerity,)


class ForgetsSpeeds(fv.RiemannSolver):
    def solve(self, model, ql, qr, auxl, auxr, jump):
        return (jump,)


class ShortWaves(fv.RiemannSolver):
    def solve(self, model, ql, qr, auxl, auxr, jump):
        return ((),), (1.0,)


class RaisingSolver(fv.RiemannSolver):
    def solve(self, model, ql, qr, auxl, auxr, jump):
        raise UserError("no waves today")


REFUSED_SOLVERS = [
    (BranchingSolver, "fv.where", "if speed > 0.0"),
    (AsksForTooMuch, "model.celerity is neither a parameter of Good", "model.celerity"),
    (ForgetsSpeeds, "pair (waves, speeds)", None),
    (ShortWaves, "returns 0 components, 1 are needed", None),
]


@pytest.mark.parametrize("build", [Stepper, solve])
@pytest.mark.parametrize(("solver", "rule", "text"), REFUSED_SOLVERS, ids=lambda v: getattr(v, "__name__", None))
def test_a_riemann_solver_that_breaks_a_rule_is_refused_before_the_first_step(solver, rule, text, build):
    with pytest.raises(fv.PointwiseError) as error:
        build(problem(Good()), fv.WavePropagation(solver()))
    assert_refused(error, f"{solver.__name__}.solve", rule, solver.solve, text)


@pytest.mark.parametrize("build", [Stepper, solve])
def test_an_exception_of_the_users_riemann_solver_passes_through_unchanged(build):
    with pytest.raises(UserError, match=r"^no waves today$"):
        build(problem(Good()), fv.WavePropagation(RaisingSolver()))


class BranchingLimiter(fv.Limiter):
    def phi(self, theta, nu):
        return theta if theta > 0.0 else 0.0


class SummingLimiter(fv.Limiter):
    def phi(self, theta, nu):
        return np.array([np.sum(theta), 1.0])


class TupleLimiter(fv.Limiter):
    def phi(self, theta, nu):
        return (theta,)


class RaisingLimiter(fv.Limiter):
    def phi(self, theta, nu):
        raise UserError("no limit today")


@pytest.mark.parametrize("build", [Stepper, solve])
@pytest.mark.parametrize(("limiter", "rule", "text"), [
    (BranchingLimiter, "fv.where", "if theta > 0.0 else"),
    (SummingLimiter, "has shape (2,)", None),
    (TupleLimiter, "shape", None),
], ids=lambda v: getattr(v, "__name__", None))
def test_a_limiter_that_breaks_a_rule_is_refused_before_the_first_step(limiter, rule, text, build):
    with pytest.raises(fv.PointwiseError) as error:
        build(problem(Good()), fv.WavePropagation(fv.HLL(), limiter()))
    assert_refused(error, f"{limiter.__name__}.phi", rule, limiter.phi, text)


@pytest.mark.parametrize("build", [Stepper, solve])
def test_an_exception_of_the_users_limiter_passes_through_unchanged(build):
    with pytest.raises(UserError, match=r"^no limit today$"):
        build(problem(Good()), fv.WavePropagation(fv.HLL(), RaisingLimiter()))


class BranchingBoundary(fv.BoundaryCondition):
    def ghost(self, model, q, values):
        return q if q[0] > 0.0 else values


class ShortBoundary(fv.BoundaryCondition):
    def ghost(self, model, q, values):
        return ()


class RaisingBoundary(fv.BoundaryCondition):
    def ghost(self, model, q, values):
        raise UserError("no ghosts today")


@pytest.mark.parametrize(("boundary", "rule", "text"), [
    (BranchingBoundary, "fv.where", "if q[0] > 0.0 else"),
    (ShortBoundary, "returns 0 components, 1 are needed", None),
], ids=lambda v: getattr(v, "__name__", None))
def test_a_boundary_condition_that_breaks_a_rule_is_refused_by_the_problem(boundary, rule, text):
    with pytest.raises(fv.PointwiseError) as error:
        problem(Good(), boundary=(fv.Outflow(), boundary()))
    assert_refused(error, f"{boundary.__name__}.ghost", rule, boundary.ghost, text)


def test_an_exception_of_the_users_boundary_condition_passes_through_unchanged():
    with pytest.raises(UserError, match=r"^no ghosts today$"):
        problem(Good(), boundary=RaisingBoundary())


@attrs.frozen
class Decay(fv.Source):
    rate_constant: float = 1.0

    def step(self, model, q, aux, dt):
        (u,) = q
        return (u * np.exp(-self.rate_constant * dt),)

    def rate(self, model, q, aux):
        (u,) = q
        return (-self.rate_constant * u,)


class BranchingStep(Decay):
    def step(self, model, q, aux, dt):
        (u,) = q
        return (u if u > 0.0 else 0.0 * u,)


class BareRate(Decay):
    def rate(self, model, q, aux):
        (u,) = q
        return -u


class WrongAttribute(Decay):
    def rate(self, model, q, aux):
        (u,) = q
        return (-self.decay * u,)


class RaisingSource(Decay):
    def step(self, model, q, aux, dt):
        raise UserError("no decay today")


class ChoosySource(Decay):
    def check(self, model):
        raise ValueError(f"ChoosySource cannot act on {type(model).__name__}")


@pytest.mark.parametrize(("source", "method", "rule", "text"), [
    (BranchingStep, "step", "fv.where", "if u > 0.0 else"),
    (BareRate, "rate", "must return a tuple of 1 components", None),
    (WrongAttribute, "rate", "self.decay is neither a parameter of WrongAttribute (rate_constant)", "self.decay"),
], ids=lambda v: getattr(v, "__name__", None))
def test_a_source_that_breaks_a_rule_is_refused_by_the_problem(source, method, rule, text):
    with pytest.raises(fv.PointwiseError) as error:
        problem(Good(), sources=source())
    assert_refused(error, f"{source.__name__}.{method}", rule, getattr(source, method), text)


def test_an_exception_of_the_users_source_passes_through_unchanged():
    with pytest.raises(UserError, match=r"^no decay today$"):
        problem(Good(), sources=RaisingSource())


def test_a_source_refuses_a_model_in_its_own_words():
    with pytest.raises(ValueError, match=r"^ChoosySource cannot act on Good$"):
        problem(Good(), sources=ChoosySource())


def test_a_users_source_acts_in_the_run():
    solution = solve(problem(Good(), sources=Decay(2.0), boundary=fv.Periodic()), fv.WavePropagation(fv.HLL()))
    np.testing.assert_allclose(solution.q[-1], np.exp(-2.0), rtol=1e-13)


def test_a_model_without_components_is_refused():
    class Nameless(Good):
        conserved = ()

    with pytest.raises(ValueError, match=r"`conserved` of Nameless"):
        problem(Nameless())


def test_a_model_that_lacks_a_required_method_cannot_be_made():
    class NoSpeeds(fv.Model):
        conserved = ("u",)

        def flux(self, q):
            return q

    with pytest.raises(TypeError, match=r"wave_speeds"):
        NoSpeeds()
