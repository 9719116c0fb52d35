"""What a scheme is called in reports."""

from typing import Any

import attrs

from fvkit.pointwise.part import public_name
from fvkit.schemes.scheme import Scheme

#: Fields of schemes that have a column of their own.
NAMED = ("riemann", "limiter", "order", "reconstruction", "integrator")


def settings(scheme: Scheme) -> dict[str, Any]:
    """Return the columns of a row that name the scheme.

    ``limiter`` is what limits, of the method of lines the reconstruction; ``integrator`` is None where the scheme makes its
    step itself. ``options`` names whatever else is not as by default, empty where all is.
    """
    integrator = scheme.time_integrator
    return {"scheme": public_name(scheme), "riemann": public_name(scheme.riemann), "limiter": public_name(scheme.limiting),
            "order": scheme.nominal_order, "integrator": None if integrator is None else public_name(integrator),
            "options": _options(scheme)}


def describe(scheme: Scheme) -> str:
    """Return a scheme as a few words: ``method-of-lines roe mp5 dp5``."""
    found = settings(scheme)
    words = [found["scheme"], found["riemann"], found["limiter"]]
    words += [found["integrator"]] if found["integrator"] else [f"order {found['order']}"]
    return " ".join(words + [found["options"]] * bool(found["options"]))


def _options(scheme: Any) -> str:
    fields = [field for field in attrs.fields(type(scheme)) if field.init]
    plain = type(scheme)(**{field.name: getattr(scheme, field.name) for field in fields if field.name in NAMED})
    return " ".join(f"{field.name}={_value(getattr(scheme, field.name))}" for field in fields
                    if field.name not in NAMED and getattr(scheme, field.name) != getattr(plain, field.name))


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return f"{value:g}" if isinstance(value, float) else public_name(value)
