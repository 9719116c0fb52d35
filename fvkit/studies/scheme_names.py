"""Names of schemes in reports."""

from typing import Any

import attrs

from fvkit.pointwise.part import public_name
from fvkit.schemes.scheme import Scheme

#: Fields of schemes with a separate column.
NAMED = ("riemann", "limiter", "order", "reconstruction", "integrator")


def settings(scheme: Scheme) -> dict[str, Any]:
    """Return the columns of a report row that identify a scheme, {column: value}.

    ``limiter`` is the limiter, or the reconstruction of the method of lines; ``integrator`` is None for a fully discrete
    scheme. ``options`` lists the other fields that differ from their defaults.
    """
    integrator = scheme.time_integrator
    return {"scheme": public_name(scheme), "riemann": public_name(scheme.riemann), "limiter": public_name(scheme.limiting),
            "order": scheme.nominal_order, "integrator": None if integrator is None else public_name(integrator),
            "options": _options(scheme)}


def scheme_name(scheme: Scheme) -> str:
    """Return the name of a scheme with its parts, such as ``method-of-lines roe mp5 dp5``."""
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
