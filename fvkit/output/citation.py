"""Citation of the package and of the model's paper, used by files, `fvkit cite` and the documentation."""

import attrs

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


#: The paper of the two-phase model, its reduced model and its Roe solver.
MODEL = Work("article", "pelanti2008", ("M. Pelanti", "F. Bouchut", "A. Mangeney"),
             "A Roe-type scheme for two-phase shallow granular flows over variable topography",
             {"journal": "ESAIM: Mathematical Modelling and Numerical Analysis", "volume": "42", "pages": "851--885",
              "year": "2008", "doi": "10.1051/m2an:2008029"}, "M2AN 42 (2008) 851-885")


def package(version: str | None = None) -> Work:
    """Return the reference to this package, with ``version`` unless it is None."""
    return Work("software", "fvkit", (DEVELOPERS,), "fvkit: pluggable finite volumes for hyperbolic systems",
                {} if version is None else {"version": version, "license": "BSD-3-Clause"})


#: Citation text stored in files, without the version, which files store separately.
CITATION = "; ".join(work.sentence() for work in (MODEL, package()))


def bibtex(version: str) -> str:
    """Return the BibTeX entries of this version of the package and of the paper of the two-phase model, as text."""
    return "\n\n".join(work.bibtex() for work in (package(version), MODEL))
