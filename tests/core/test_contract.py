"""The pointwise contract: what a user's part may contain, what it must answer, and how a breach is named."""

import functools
import inspect
import math
import operator
from pathlib import Path

import attrs
import numpy as np
import pytest

import fvkit as fv
from fvkit.problem import questions
from tests.cases import Stepper, solve

OFFSETS = [0.0, 1.0]


class UserError(Exception):
    """Raised by a user's own code."""


def slope_by_branch(u):
    if u > 0.0:
        return u
    return -u


def passes_on(u):
    return slope_by_branch(u)


def fails(self, *arguments):
    raise UserError("not today")


@attrs.frozen
class Good(fv.Model):
    conserved = ("u",)
    factor: float = 1.0

    def flux(self, q):
        (u,) = q
        return (self.factor * u,)

    def wave_speeds(self, q):
        return self.factor, self.factor


def having(base=Good, name=None, **methods):
    """A subclass with other methods: functions of ``self`` and what comes behind."""
    return type(name or "Changed", (base,), methods)


def problem(model, **options):
    return fv.Problem(model, fv.Grid(0.0, 1.0, 8), lambda x: 1.0 + x[None] if len(model.conserved) == 1 else np.ones((2, x.size)), 1.0,
                      **options)


def refused(build, where, rule, line=None):
    """Building, of a model a problem, is refused with the method, this file, the line, and the rule."""
    with pytest.raises(fv.PointwiseError) as error:
        problem(build()) if isinstance(build, type) else build()
    message = str(error.value)
    assert message.startswith(where)
    assert rule in message
    if line is not None:
        assert f" ({Path(__file__)}:{line}): " in message


def marked(function):
    """The rule that a function breaks, and in which line: there it says so."""
    first = function.__code__.co_firstlineno
    lines = Path(__file__).read_text(encoding="utf-8").splitlines()[first - 1:]
    return next((text.split("# refused: ")[1], line) for line, text in enumerate(lines, first) if "# refused: " in text)


class Violations(Good):
    """One flux for each way of breaking a rule; the line that does names the rule."""

    def branch(self, q):
        if q[0] > 0.0:  # refused: fv.where(condition, a, b)
            return q
        return q

    def conditional(self, q):
        return (q[0] if q[0] > 1.0 else -q[0],)  # refused: fv.where

    def conjunction(self, q):
        low = (q[0] > 0.0) and (q[0] < 1.0)  # refused: fv.where
        return (low * q[0],)

    def repetition(self, q):
        (u,) = q
        while u > 1.0:  # refused: fv.where
            u = u - 1.0
        return (u,)

    def assertion(self, q):
        assert q[0] >= 0.0  # refused: fv.where
        return q


VIOLATIONS = {name: value for name, value in vars(Violations).items() if inspect.isfunction(value)} | {
    "disjunction": lambda self, q: ((q[0] > 0.5 or q[0] < -1.0) * q[0],),  # refused: fv.where
    "negation": lambda self, q: ((not q[0]) * q[0],),  # refused: fv.where
    "chained": lambda self, q: ((0.0 < q[0] < 2.0) * q[0],),  # refused: fv.where
    "parameter": lambda self, q: q if self.factor > 0.0 else (-q[0],),  # refused: fv.where
    "builtin": lambda self, q: (max(q[0], 3.0),),  # refused: fv.maximum(a, b)
    "scalar module": lambda self, q: (math.sqrt(q[0]),),  # refused: use np.sqrt and its like
    "conversion": lambda self, q: (float(q[0]),),  # refused: Python float
    "index from value": lambda self, q: (OFFSETS[q[0]] * q[0],),  # refused: a value is the number of one cell
    "index from parameter": lambda self, q: (q[self.factor],),  # refused: a constant of the class (ClassVar) is an integer
    "count from parameter": lambda self, q: (sum(q[0] for _ in range(self.factor)),),  # refused: a constant of the class
    "total": lambda self, q: (np.sum(q[0]) + q[0],),  # refused: np.sum does not take cells
    "method of array": lambda self, q: (q[0].sum() * q[0],),  # refused: no attribute 'sum'
    "extreme": lambda self, q: (np.min(q[0]) + 0.0 * q[0],),  # refused: no extremes
    "neighbour": lambda self, q: (np.roll(q[0], 1) - q[0],),  # refused: np.roll
    "one cell": lambda self, q: (q[0][3] + q[0],),  # refused: not subscriptable
    "slices": lambda self, q: (q[0][1:] - q[0][:-1],),  # refused: not subscriptable
    "unpacked": lambda self, q: tuple([u for u in q[0]]),  # noqa: C416  # refused: not iterable
    "stack": lambda self, q: (np.stack([q[0], q[0]]),),  # refused: np.stack
    "search": lambda self, q: (np.where(q[0] > 0.0)[0] * q[0],),  # refused: fv.where(condition, a, b)
    "sum of array": lambda self, q: (0.0 * q[0] + np.array([*q, *q]).sum(),),  # refused: keep components in tuples
    "interpolation": lambda self, q: (np.interp(q[0], [0.0, 1.0], [0.0, 1.0]),),  # refused: np.interp
    "settings": lambda self, q: (np.sqrt(q[0], dtype=float),),  # refused: plain arguments
    "remainder": lambda self, q: (q[0] % 3.0,),  # refused: %
    "imaginary": lambda self, q: (1j * q[0],),  # refused: a complex meets a value
    "attribute": lambda self, q: (self.factr * q[0],),  # refused: factr is neither a parameter of Violating (factor) nor
    "undefined": lambda self, q: (factr * q[0],),  # noqa: F821  # refused: the name factr is not defined
    "unknown function": lambda self, q: (np.sqtr(q[0]),),  # refused: sqtr
    "comprehended": lambda self, q: tuple(u if u > 2.0 else -u for u in q),  # refused: fv.where
}


@pytest.mark.parametrize("violation", VIOLATIONS)
def test_a_breach_is_refused_by_the_problem_with_method_file_line_and_rule(violation):
    flux = VIOLATIONS[violation]
    refused(having(name="Violating", flux=flux), "Violating.flux", *marked(flux))


def test_helpers_and_other_methods_are_examined_and_named_in_their_own_lines():
    line = inspect.getsourcelines(slope_by_branch)[1] + 1
    for helper in (slope_by_branch, passes_on):
        kind = having(flux=lambda self, q, helper=helper: (helper(q[0]),))
        refused(kind, "Changed.flux, in slope_by_branch", "fv.where", line)
    kind = having(Violations, flux=lambda self, q: self.conditional(q))
    refused(kind, "Changed.flux, in Violations.conditional", *marked(Violations.conditional))


@attrs.frozen
class Ordinary(Good):
    """f = (2 + 4) u in ordinary Python."""

    powers = (2.0, 4.0)

    def flux(self, q):
        return self.scaled(super().flux(q))

    def wave_speeds(self, q):
        return tuple(6.0 * speed for speed in super().wave_speeds(q))

    @functools.wraps(Good.flux)
    def scaled(self, q):
        square = lambda u: u * OFFSETS[-1]  # noqa: E731
        first, *rest = tuple(square(u) for u in q)
        both = {power: [power * item for item in (first, *rest)] for power in self.powers}
        total = [functools.reduce(operator.add, rows) for rows in zip(*both.values(), strict=True)]
        return (*total,) if len(total) == 1 and self.defines("flux") else ()


def closing_over(factor):
    return having(flux=lambda self, q: tuple([factor * u for u in q]), wave_speeds=lambda self, q: (factor, factor))


@pytest.mark.parametrize("kind", [Ordinary, closing_over(6.0)])
def test_ordinary_python_is_accepted_and_gives_the_same_numbers_on_both_backends(kind):
    wanted = having(flux=lambda self, q: (6.0 * q[0],), wave_speeds=lambda self, q: (6.0, 6.0))
    for backend in ("numpy", "numba"):
        ends = [solve(problem(model()), fv.WavePropagation(fv.HLL()), backend=backend).q[-1] for model in (kind, wanted)]
        np.testing.assert_array_equal(*ends)


def test_a_helper_that_is_defined_anew_is_looked_at_anew(monkeypatch):
    kind = having(flux=lambda self, q: (slope_by_branch(q[0]),))
    monkeypatch.setitem(globals(), "slope_by_branch", np.abs)
    problem(kind())
    monkeypatch.undo()
    refused(kind, "Changed.flux", "fv.where")


@attrs.frozen
class WithTable(Good):
    table: tuple[float, ...] = (1.0, 2.0)

    def flux(self, q):
        return (self.table[0] * q[0],)


def test_a_field_that_is_no_number_is_not_seen_since_other_problems_may_change_it():
    refused(WithTable, "WithTable.flux", "table is neither a parameter of WithTable (factor)")


@pytest.mark.parametrize(("flux", "rule"), [
    (lambda self, q: (None,), "component 0 must be a real number"), (lambda self, q: ("u",), "component 0 must be a real number"),
    (lambda self, q: q[0], "must return a tuple of 1 components, got one value; write (value,)"),
    (lambda self, q: (q[0], q[0]), "returns 2 components, 1 are needed"), (lambda self, q: (np.ones(3),), "component 0 has shape (3,)"),
    (functools.cache(lambda self, q: q), "unhashable"), (3.0, "must be a method, got 3.0")])
def test_an_answer_that_is_no_tuple_of_components_is_refused(flux, rule):
    refused(having(flux=flux), "Changed.flux", rule)


def test_a_method_that_writes_into_its_arguments_is_refused():
    def flux(self, q):
        (u,) = q
        u *= 2.0
        return (u,)

    with pytest.raises(ValueError, match="read-only"):
        problem(having(flux=flux)())


@attrs.frozen
class Pair(fv.Model):
    """Two components, of which the first is a mass."""

    conserved = ("h", "m")
    aux = ("b",)
    phases = (((0,), 1),)

    def flux(self, q):
        return q

    def wave_speeds(self, q):
        return 1.0, 1.0


@attrs.frozen
class Keeping(fv.Source):
    def step(self, model, q, aux, dt):
        return q

    def rate(self, model, q, aux):
        return 0.0 * q[0], 0.0 * q[1]


class Copying(fv.BoundaryCondition):
    def ghost(self, model, q, values):
        return q


TABLES = [(Pair, questions.MODEL, {}), (Keeping, questions.SOURCE, "sources"), (Copying, questions.BOUNDARY, "boundary")]


@pytest.mark.parametrize(("base", "asked", "place"), [(base, one, place) for base, table, place in TABLES for one in table],
                         ids=lambda value: getattr(value, "name", ""))
def test_every_question_is_asked_by_the_problem_which_names_an_answer_of_another_form(base, asked, place):
    answer = (1.0, 2.0) if asked.answers == "number" else (1.0, 2.0, 3.0)
    code = f"lambda self, {', '.join(name.split()[0] + str(k) for k, name in enumerate(asked.takes))}: {answer}"
    wrong = having(base, **{asked.name: eval(code)})()
    with pytest.raises(fv.PointwiseError, match=rf"^Changed\.{asked.name} .*(must return|components)"):
        problem(wrong) if base is Pair else problem(Pair(), **{place: wrong})


@pytest.mark.parametrize(("answer", "rule"), [(lambda jump: (jump,), "pair (waves, speeds)"), (lambda jump: ((jump, jump), (1.0,)), "2 waves and 1 speeds"),
                                              (lambda jump: (((),), (1.0,)), "wave 0: returns 0 components, 1 are needed")])
def test_waves_come_with_their_speeds(answer, rule):
    kind = having(decompose=lambda self, ql, qr, auxl, auxr, jump: answer(jump))
    refused(kind, "Changed.decompose", rule)
    solver = having(fv.RiemannSolver, "Own", solve=lambda self, model, ql, qr, auxl, auxr, jump: answer(jump))
    refused(lambda: Stepper(problem(Good()), fv.WavePropagation(solver())), "Own.solve", rule)


def test_a_plug_in_adds_questions_of_its_own():
    asked = (*fv.Model.questions, questions.Question("head", ("q", "height"), "number", "weirs"))
    problem(having(questions=asked, head=lambda self, q, height: q[0] + height)())
    refused(having(questions=asked, head=lambda self, q, height: q), "Changed.head", "must return one value")


@pytest.mark.parametrize("build", [Stepper, solve])
@pytest.mark.parametrize(("base", "method", "answer", "rule"), [
    (fv.RiemannSolver, "solve", lambda self, model, ql, qr, auxl, auxr, jump: ((jump,), (max(model.wave_speeds(ql)[0], 0.0),)), "fv.where"),
    (fv.RiemannSolver, "solve", lambda self, model, ql, qr, auxl, auxr, jump: ((jump,), (model.celerity,)), "celerity is neither a parameter of Good"),
    (fv.Limiter, "phi", lambda self, theta, nu: theta if theta > 0.0 else 0.0, "fv.where"),
    (fv.Limiter, "phi", lambda self, theta, nu: (theta,), "must return one value and no tuple"),
    (fv.Reconstruction, "right", lambda self, a, b, c, d, e: np.mean(c), "np.mean")])
def test_a_part_of_a_scheme_that_breaks_a_rule_is_refused_before_the_first_step(base, method, answer, rule, build):
    part = having(base, "Own", **{method: answer})()
    scheme = {fv.RiemannSolver: lambda: fv.WavePropagation(part), fv.Limiter: lambda: fv.WavePropagation(fv.HLL(), part),
              fv.Reconstruction: lambda: fv.MethodOfLines(fv.HLL(), part)}[base]()
    refused(lambda: build(problem(Good()), scheme), f"Own.{method}", rule)


def test_a_solver_that_needs_whole_arrays_is_not_traced():
    def solver(self, model, ql, qr, auxl, auxr, jump):
        return (jump,), (np.full(np.shape(jump[0]), float(np.max(ql[0])) if np.size(ql[0]) else 1.0),)

    whole = having(fv.RiemannSolver, "Whole", compilable=False, solve=solver)
    assert solve(problem(Good()), fv.WavePropagation(whole(), order=1), backend="numpy").success


@pytest.mark.parametrize("build", [
    lambda: problem(having(flux=fails)()), lambda: problem(having(wave_speeds=fails)()),
    lambda: fv.Problem(Good(), fv.Grid(0.0, 1.0, 8), fails, 1.0), lambda: problem(Pair(), sources=having(Keeping, step=fails)()),
    lambda: problem(Good(), boundary=having(Copying, ghost=fails)()),
    lambda: Stepper(problem(Good()), fv.WavePropagation(having(fv.RiemannSolver, solve=fails)())),
    lambda: Stepper(problem(Good()), fv.WavePropagation(fv.HLL(), having(fv.Limiter, phi=fails)()))])
def test_what_the_users_own_code_raises_passes_through_unchanged(build):
    with pytest.raises(UserError, match=r"^not today$") as error:
        build()
    assert error.value.__cause__ is None


def test_a_type_error_of_the_users_own_passes_through_unchanged():
    def flux(self, q):
        raise TypeError("my own words")

    with pytest.raises(TypeError, match=r"^my own words$") as error:
        problem(having(flux=flux)())
    assert type(error.value) is TypeError
    assert issubclass(fv.PointwiseError, TypeError)


def test_a_source_refuses_a_model_in_its_own_words():
    with pytest.raises(UserError, match=r"^not today$"):
        problem(Pair(), sources=having(Keeping, check=fails)())


def test_a_model_without_components_or_without_a_required_method_is_refused():
    with pytest.raises(ValueError, match=r"`conserved` of Changed"):
        problem(having(conserved=())())
    with pytest.raises(TypeError, match=r"wave_speeds"):
        having(fv.Model, conserved=("u",), flux=lambda self, q: q)()
