"""What a scheme is called in reports."""

from typing import Any

import attrs

from fvkit.names import public_name
from fvkit.schemes import MethodOfLines, Scheme, WavePropagation

#: Fields of schemes that have a column of their own.
NAMED = ("riemann", "limiter", "order", "reconstruction", "integrator")


def settings(scheme: Scheme) -> dict[str, Any]:
    """Return the columns of a row that name the scheme.

    For the method of lines ``limiter`` is the reconstruction and ``order`` its order; ``integrator`` is None for wave
    propagation. ``options`` names whatever else is not as by default, empty where all is.
    """
    if isinstance(scheme, WavePropagation):
        parts: dict[str, Any] = {"limiter": public_name(scheme.limiter), "order": scheme.order, "integrator": None}
    elif isinstance(scheme, MethodOfLines):
        parts = {"limiter": public_name(scheme.reconstruction), "order": scheme.reconstruction.order,
                 "integrator": public_name(scheme.integrator)}
    else:
        raise TypeError(f"`schemes` must hold fv.WavePropagation and fv.MethodOfLines, got {scheme!r}")
    return {"scheme": public_name(scheme), "riemann": public_name(scheme.riemann), **parts, "options": _options(scheme)}


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
