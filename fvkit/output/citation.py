"""Citations: works that parts name, and the package; files, `fvkit cite` and the documents take them from here."""

from collections.abc import Iterable, Iterator
from typing import Any

import attrs

from fvkit.pointwise.part import Part

#: Version of both packages, as in pyproject.toml and CITATION.cff.
VERSION = "0.1.0"

#: Authors of the package, as in CITATION.cff.
DEVELOPERS = "The fvkit developers"


@attrs.frozen
class Work:
    """Bibliographic reference.

    Parameters
    ----------
    kind : type of the BibTeX entry, ``"article"`` or ``"software"``.
    key : key of the BibTeX entry.
    authors : names, initials first.
    title : title of the work.
    fields : further fields of the BibTeX entry, {name: text}.
    where : journal, volume, year and pages as one text; empty for software.
    """

    kind: str
    key: str
    authors: tuple[str, ...]
    title: str
    fields: dict[str, str] = attrs.field(factory=dict, hash=False)
    where: str = ""

    def sentence(self) -> str:
        """Return authors, title and journal as one text, separated by commas."""
        return ", ".join(filter(None, [*self.authors, self.title, self.where]))

    def bibtex(self) -> str:
        """Return the BibTeX entry as text."""
        # Braces stop BibTeX from splitting an organisation's name into first and last names.
        authors = " and ".join(f"{{{name}}}" if name == DEVELOPERS else name for name in self.authors)
        lines = [f"  {name} = {{{text}}}" for name, text in {"author": authors, "title": self.title, **self.fields}.items()]
        return f"@{self.kind}{{{self.key},\n" + ",\n".join(lines) + "\n}"


def package(version: str | None = None) -> Work:
    """Return the reference to this package, with ``version`` unless it is None."""
    return Work("software", "fvkit", (DEVELOPERS,), "fvkit: pluggable finite volumes for hyperbolic systems",
                {} if version is None else {"version": version, "license": "BSD-3-Clause"})


def cited(parts: Iterable[Any]) -> tuple[Work, ...]:
    """Return the works that parts name in ``cite``, each once, in the order of the parts."""
    return tuple(dict.fromkeys(work for part in parts for work in part.cite))


def sentence(parts: Iterable[Any]) -> str:
    """Return the citations that files contain: the works of the parts of a run, and the package without its version."""
    return "; ".join(work.sentence() for work in (*cited(parts), package()))


def bibtex(version: str) -> str:
    """Return the BibTeX entries to cite: the package of that version, and the works that the loaded parts name."""
    return "\n\n".join(work.bibtex() for work in (package(version), *cited(_loaded(Part))))


def _loaded(kind: type[Part]) -> Iterator[type[Part]]:
    """Yield all classes that derive from a class, in the order of their definition."""
    for heir in kind.__subclasses__():
        yield heir
        yield from _loaded(heir)
