"""Docstrings of fvkit, written to be read in a terminal, as numpydoc and reStructuredText want them.

* `name : what it is` of a parameter becomes the name and, below it, the text: numpydoc would take the first line for a type.
* `Source: ...` below the parameters begins numpydoc's section of notes: it would be one more parameter.
* A default that attrs makes anew for each object shows as dots.
* Bars and stars of plain formulas, as in |vs - vf| and h*, are no markup.
"""

import inspect
import re
from typing import Any

FIELDS = ("Parameters", "Attributes")
ITEM = re.compile(r"^(\*{0,2}\w[\w, .*]*?) : (.+)$")
CODE = re.compile(r"(``.+?``|`[^`]+`)")


def plain(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Rewrite the lines of a docstring in place."""
    if not (name.startswith("fvkit") and (getattr(obj, "__module__", None) or "fvkit").startswith("fvkit")):
        return
    result: list[str] = []
    section, literal = "", -1
    for number, line in enumerate(lines):
        indent = len(line) - len(line.lstrip())
        if literal >= 0 and line.strip() and indent <= literal:
            literal = -1
        following = lines[number + 1] if number + 1 < len(lines) else ""
        if literal < 0 and line.strip() and re.fullmatch(r"-{3,}", following.strip()):
            section = line.strip()
        if section in FIELDS and literal < 0 and line.startswith("Source: "):
            section = "Notes"
            result += [section, "-----"]
        found = ITEM.match(line) if section in FIELDS and literal < 0 else None
        if found:
            result += [found[1], f"    {escaped(found[2])}"]
        else:
            result.append(line if literal >= 0 or line.lstrip().startswith(">>>") else escaped(line))
        if literal < 0 and line.rstrip().endswith("::"):
            literal = indent
    lines[:] = result


def signature(app: Any, what: str, name: str, obj: Any, options: Any, text: str | None, returned: str | None) -> Any:
    """Show the arguments of a class, which its `__new__` hides, and a default that attrs makes anew for each object as dots."""
    if what == "class" and text is not None:
        known = inspect.signature(obj)
        arguments = [item.replace(annotation=item.empty) for item in known.parameters.values()]
        text = str(known.replace(parameters=arguments, return_annotation=known.empty))
    return None if text is None else (re.sub(r"=\s*(NOTHING|<factory>)", "=...", text), returned)


def escaped(line: str) -> str:
    """Return the line with bars and stars outside of code made plain, but the star of an item in a list."""
    item = re.match(r"\s*\* ", line)
    if item:
        return item[0] + escaped(line[item.end():])
    return "".join(part if CODE.fullmatch(part) else re.sub(r"([|*])", r"\\\1", part) for part in CODE.split(line))


def setup(app: Any) -> dict[str, bool]:
    """Run before numpydoc, whose priority is 500."""
    app.connect("autodoc-process-docstring", plain, priority=100)
    app.connect("autodoc-process-signature", signature, priority=900)
    return {"parallel_read_safe": True}
