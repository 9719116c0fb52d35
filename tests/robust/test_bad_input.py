"""Bad input to every public callable: one clear error that names the argument, the value and what is allowed."""

import inspect
import re
from collections.abc import Mapping
from fractions import Fraction

import numpy as np
import pytest

import fvkit as fv
import fvkit_granular as gr
from fvkit.validation import shown
from fvkit_granular import exact, shapes
from tests.robust.cases_calls import CALLS, ELSEWHERE
from tests.robust.cases_single import SINGLE
from tests.robust.cases_values import wrong

#: Characters of a message: a list of all scenes is the longest thing that is allowed.
LONGEST = 1300

TABLE = [(name, argument, kind) for name, call in CALLS.items() for argument, kind in call.kinds.items()]

#: Calls that must be refused.
SIZE = sum(len(wrong(kind)) for _, _, kind in TABLE) + len(SINGLE)


def spellings(value):
    """What a message may say of a value: itself, its shape where that is wrong, or the part of it that is wrong."""
    found = [shown(value)[:40]]
    items = [value] if isinstance(value, str) else []
    found += [item.split(".")[0] for item in items]
    if isinstance(value, type):
        found.append(value.__name__)
    if isinstance(value, Mapping | list | tuple | np.ndarray) and not isinstance(value, np.ma.MaskedArray):
        items = value.ravel().tolist() if isinstance(value, np.ndarray) else list(value)
        found += [shown(item)[:40] for item in items]
        found += [str(len(items)), *(type(item).__name__ for item in items)]
    if isinstance(value, int | float | Fraction):
        found += [repr(float(value))] if abs(value) < 1e300 else []
    if hasattr(value, "shape"):
        found.append(str(value.shape))
    return [text for text in found if text]


def check_message(message, words, value):
    """Fail unless the message is one short line with all the words and one of the spellings of the value."""
    assert "\n" not in message
    assert len(message) < LONGEST
    for word in words:
        assert word in message
    assert any(text in message for text in spellings(value)), message
    assert any(word in message for word in ("must", "need", "give", "take")), message


@pytest.mark.parametrize(("name", "argument", "kind"), TABLE, ids=[f"{name}-{argument}" for name, argument, _ in TABLE])
def test_every_argument_refuses_what_it_cannot_be(name, argument, kind):
    call, before = CALLS[name], np.geterr()
    for value, error in wrong(kind):
        with pytest.raises((TypeError, ValueError)) as caught:
            call.function(**{**call.given, argument: value})
        assert isinstance(caught.value, error), f"{shown(value)}: {caught.value!r}"
        check_message(str(caught.value), [call.named.get(argument, argument)], value)
    assert np.geterr() == before


def test_the_table_is_as_large_as_promised():
    assert SIZE > 6000


@pytest.mark.parametrize("name", [name for name, call in CALLS.items() if call.works])
def test_the_calls_of_the_table_work_as_they_stand(name):
    CALLS[name].function(**CALLS[name].given)


@pytest.mark.parametrize("name", SINGLE)
def test_single_cases(name):
    call, error, words = SINGLE[name]
    with pytest.raises(error) as caught:
        call()
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < LONGEST
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("name", [name for name, call in CALLS.items() if call.given or call.kinds])
def test_an_unknown_argument_is_named(name):
    if inspect.isfunction(CALLS[name].function) and CALLS[name].function.__name__ == "<lambda>":
        pytest.skip("not the callable itself")
    with pytest.raises(TypeError, match="surplus"):
        CALLS[name].function(**CALLS[name].given, surplus=1)


@pytest.mark.parametrize(("module", "prefix", "names"), [
    (fv, "", fv.__all__), (gr, "", gr.__all__), (exact, "exact.", exact.__all__), (fv.testing, "fvkit.testing.", fv.testing.__all__),
    (shapes, "shapes.", [name for name, value in vars(shapes).items() if isinstance(value, type) and issubclass(value, shapes.Shape)])])
def test_every_public_callable_is_in_the_table_or_explained(module, prefix, names):
    known = {name.split(" of ")[0] for name in CALLS} | set(ELSEWHERE)
    for name in names:
        part = getattr(module, name)
        takes_nothing = isinstance(part, type) and not isinstance(part, type(fv.Status)) and not issubclass(part, BaseException) \
            and not inspect.signature(part).parameters
        assert not callable(part) or takes_nothing or prefix + name in known, name


def test_what_is_explained_exists():
    for name in ELSEWHERE:
        part = name.removeprefix("exact.").removeprefix("shapes.").removeprefix("fvkit.testing.")
        assert any(hasattr(module, part) for module in (fv, gr, exact, shapes, fv.testing)), name


@pytest.mark.parametrize("part", [fv.Outflow, fv.Roe, fv.MC, fv.Strang, fv.DP5, fv.MP5, fv.Burgers, gr.Relaxation])
def test_parts_without_arguments_take_none(part):
    with pytest.raises(TypeError, match=r"argument"):
        part(1)


@pytest.mark.parametrize("part", [fv.Model, fv.RiemannSolver, fv.Limiter, fv.BoundaryCondition, fv.Source, fv.Splitting, fv.Scheme,
                                  fv.Integrator, fv.Reconstruction, fv.Observer, fv.Stop, gr.Drag, gr.BasalFriction, gr.Reference,
                                  shapes.Shape])
def test_abstract_parts_say_what_is_missing(part):
    with pytest.raises(TypeError, match=r"abstract"):
        part()


@pytest.mark.parametrize("law", [lambda nu: gr.CoulombFriction(nu), lambda nu: gr.Voellmy(nu, 500.0)])
def test_degrees_are_no_coefficient_of_friction(law):
    for angle in (6.0, 10.0, 35.0, 89.0):
        with pytest.raises(ValueError, match=r"must be finite and >= 0 and <= 5.67, got .*tan\(35 deg\) = 0.70"):
            law(angle)
    for angle in (0.0, 35.0, 79.9):
        law(float(np.tan(np.radians(angle))))


def with_source(source):
    return fv.Problem(gr.ShallowWater(), fv.Grid(0.0, 1.0, 2), np.ones((2, 2)), 1.0, sources=source)


@pytest.mark.parametrize(("make", "strange", "plausible", "hint"), [
    (gr.CoulombFriction, [2.5, 5.0, [0.3, 3.0]], [0.0, 0.7, 1.96, [0.3, 0.4]], "tan(35 deg) = 0.70"),
    (lambda mu: gr.Voellmy(mu, 500.0), [2.5, 5.0], [0.0, 0.7, 1.96], "tan(35 deg) = 0.70"),
    (lambda xi: gr.Voellmy(0.1, xi), [1.0 / 400.0, 9.81 / 400.0, [400.0, 0.01]], [1.0, 400.0, [100.0, 2000.0]], "not 1/xi or g/xi"),
    (gr.Manning, [30.0, 1.5, [0.03, 40.0]], [0.0, 0.03, 0.8, [0.03, 0.05]], "n = 1/K"),
    (gr.Rain, [36.0, -5.0, [0.0, 36.0]], [1e-5, -1e-5, 1.0, lambda x: np.where(x < 0.5, 10.0, 0.0)], "36 mm/h = 1e-5 m/s"),
], ids=["nu", "mu", "xi", "n", "rain"])
def test_coefficients_in_another_unit_and_inverse_ones_are_warned_of_with_the_fix(make, strange, plausible, hint):
    for value in strange:
        with pytest.warns(UserWarning, match=re.escape(hint)) as told:
            with_source(make(value))
        assert told[0].filename == __file__
    for value in plausible:
        with_source(make(value))


@pytest.mark.parametrize(("make", "mistaken", "right", "hint"), [
    (gr.CoulombFriction, [6.0, 35.0], [], "tan(35 deg) = 0.70"),
    (lambda slope: gr.UniformSlope(slope), [10.0, -35.0], [0.1, -0.7, 5.0], "tan(5 deg) = 0.087"),
    (lambda slope: fv.Outflow(slope=slope), [10.0, -35.0], [0.1, -0.7, None], "tan(5 deg) = 0.087"),
    (lambda slope: gr.FixedLevel(1.0, slope=slope), [10.0, -35.0], [0.1, -0.7], "tan(5 deg) = 0.087"),
    (lambda phi: gr.GivenFlow(1.0, phi), [60.0, 1.5], [0.6], "60 % is 0.6"), (lambda phi: gr.FixedLevel(1.0, phi), [60.0], [0.6], "60 % is 0.6"),
    (lambda phi: gr.Hydrograph([0.0], [1.0], [phi]), [60.0], [0.6], "60 % is 0.6"), (lambda phi: gr.Rain(1e-5, phi), [60.0], [0.6], "60 % is 0.6"),
    (lambda phi: gr.TwoPhase().conserved_from(1.0, phi), [60.0], [0.6], "60 % is 0.6"),
    (lambda gamma: gr.TwoPhase(gamma=gamma), [2.65, 1000.0], [0.4], "density of the fluid over that of the solid"),
], ids=["degrees", "slope", "outflow", "level", "flow", "lake", "hydrograph", "rain-phi", "state", "gamma"])
def test_values_in_another_unit_and_inverse_ones_are_refused_with_the_fix(make, mistaken, right, hint):
    for value in mistaken:
        with pytest.raises(ValueError, match=re.escape(hint)):
            make(value)
    for value in right:
        make(value)
