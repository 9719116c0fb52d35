"""The methods of parts, each declared once: checks of a problem, conformance suites and documents use this table.

A class of parts lists its questions as ``questions``; that of a plug-in adds its own,
``questions = (*Model.questions, Question(...))``.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from fvkit.pointwise.contract import Answer, check
from fvkit.pointwise.polynomial import polynomial


class Question(NamedTuple):
    """A pointwise method of a part.

    Attributes
    ----------
    name : of the method.
    takes : names of its arguments, see `samples`; any other name is a number.
    answers : what it returns, see `check_answers`.
    asked_by : who asks.
    also : arguments that it may take as well, see `fvkit.Model.takes_aux`.
    """

    name: str
    takes: tuple[str, ...]
    answers: str
    asked_by: str
    also: tuple[str, ...] = ()

    @property
    def call(self) -> str:
        """Its signature, such as flux(q[, aux])."""
        return f"{self.name}({', '.join(self.takes)}" + (f"[, {', '.join(self.also)}])" if self.also else ")")


_FACE = ("ql", "qr", "auxl", "auxr")

MODEL: tuple[Question, ...] = (
    Question("flux", ("q",), "state", "every scheme", ("aux",)),
    Question("wave_speeds", ("q",), "two bounds", "every scheme", ("aux",)),
    Question("speeds_between", ("ql", "qr"), "two bounds", "HLL, Rusanov", ("auxl", "auxr")),
    Question("jump", _FACE, "state", "every scheme"),
    Question("difference", _FACE, "state", "Riemann solvers"),
    Question("balanced_difference", _FACE, "state", "HLL, Rusanov"),
    Question("decompose", (*_FACE, "jump"), "waves", "Roe"),
    Question("matrix_product", (*_FACE, "v"), "state", "second order"),
    Question("cross", _FACE, "state", "second order"),
    Question("relaxation", (*_FACE, "jump"), "waves", "faces next to dry ground"),
    Question("lift", ("here", "aux"), "state", "MethodOfLines"),
    Question("to_modes", ("here", "w"), "state", "MethodOfLines"),
    Question("from_modes", ("here", "amplitudes"), "state", "MethodOfLines"),
    Question("cell_integral", ("ql", "qr", "q in the cell", "aux in the cell"), "state", "MethodOfLines"),
    Question("beyond", ("q", "slopes", "distance"), "state", "open ends"),
    Question("settle", ("q",), "state", "every step"),
    Question("admissible", ("q",), "number", "every step"),
    Question("hyperbolic_discriminant", ("ql", "qr"), "number", "every step", ("auxl", "auxr")),
    Question("may_lose_hyperbolicity", ("ql", "qr"), "number", "every step", ("auxl", "auxr")),
)
SOURCE: tuple[Question, ...] = (
    Question("step", ("model", "q", "aux", "dt"), "state", "splitting"),
    Question("rate", ("model", "q", "aux"), "state", "fvkit.rhs, MethodOfLines"),
    Question("driven", ("model", "before", "after", "bearing", "aux", "dt"), "state", "WavePropagation"),
    Question("implicit_rate", ("model", "q", "aux", "a"), "state", "implicit stages"),
)
BOUNDARY: tuple[Question, ...] = (
    Question("ghost", ("model", "q", "values"), "state", "every scheme"),
    Question("mass_fluxes", ("model", "values"), "masses or ()", "every scheme"),
)
RIEMANN: tuple[Question, ...] = (
    Question("solve", ("model", *_FACE, "jump"), "waves", "every scheme"),
    Question("total", _FACE, "state", "second order"),
)
LIMITER: tuple[Question, ...] = (Question("phi", ("theta", "nu"), "number", "WavePropagation"),)
RECONSTRUCTION: tuple[Question, ...] = (Question("right", ("a", "b", "c", "d", "e"), "number", "MethodOfLines"),)


def samples(model: Any, q: tuple[Any, ...], aux: tuple[Any, ...]) -> dict[str, Any]:
    """Return sample values of each argument, from states and aux values of some cells, tuples of arrays."""
    (qr, auxr), one = (tuple([row[::-1] for row in rows]) for rows in (q, aux)), np.ones(q[0].shape)
    return {
        "model": model, "ql": q, "qr": qr, "aux": aux, "auxl": aux, "auxr": auxr, "dt": 0.0,
        **dict.fromkeys(("q", "here", "w", "amplitudes", "v", "jump", "before", "after"), q),
        **{f"{name} in the cell": tuple([polynomial(row, row, row[::-1], 0.0 * row) for row in rows])
           for name, rows in (("q", q), ("aux", aux))},
        "slopes": (1.0,) * len(aux), "bearing": tuple([q[masses[-1]] for masses, _ in model.phases]),
        "theta": 4.0 * one.cumsum() / one.size - 1.0, "nu": 0.5 * one,
        **{name: (1.0 + k % 3) * one for k, name in enumerate("abcde")},
    }


def check_answers(part: Any, given: Mapping[str, Any], traced: bool = True) -> dict[str, Any]:
    """Ask a part every question that it answers, and return {name: answer}; a PointwiseError where it breaks the pointwise
    contract, or an answer has another form than it should, see `fvkit.pointwise.contract`.
    """
    q, masses = given["q"], len(given["model"].mass_rows())
    forms = {"state": Answer(len(q)), "two bounds": Answer(2), "number": Answer(None), "waves": Answer(len(q), waves=True),
             "masses": Answer(masses), "masses or ()": Answer(masses, optional=True),
             "one per phase": Answer(len(given["model"].phases))}
    found = {}
    for name, takes, answers, _, also in part.questions:
        if part.defines(name):
            names = (*takes, *also) if name in getattr(part, "takes_aux", ()) else takes
            found[name] = check(part, name, tuple([given.get(item, 1.0) for item in names]), forms[answers], q[0].size, traced)
    return found


@lru_cache(maxsize=64)
def aux_places(questions: tuple[Question, ...]) -> dict[str, tuple[int, ...]]:
    """Return which arguments of each question hold aux values, from 0, for questions that have any."""
    places = {name: tuple(k for k, item in enumerate((*takes, *also)) if item.startswith("aux"))
              for name, takes, _, _, also in questions}
    return {name: found for name, found in places.items() if found}
