"""What to cite for results: the one place from which files, `fvkit cite` and the documents take it."""

import attrs

#: Version of both packages, as in pyproject.toml and CITATION.cff.
VERSION = "0.1.0"

#: Authors of the package, as in CITATION.cff.
DEVELOPERS = "The fvkit developers"


@attrs.frozen
class Work:
    """A work to cite.

    Parameters
    ----------
    kind : type of the BibTeX entry, ``"article"`` or ``"software"``.
    key : of the BibTeX entry.
    authors : names, initials first.
    title : of the work.
    fields : further fields of the BibTeX entry, {name: text}.
    where : journal, volume, year and pages in a sentence; empty for software.
    """

    kind: str
    key: str
    authors: tuple[str, ...]
    title: str
    fields: dict[str, str] = attrs.field(factory=dict, hash=False)
    where: str = ""

    def sentence(self) -> str:
        """Return authors, title and where it appeared, separated by commas."""
        return ", ".join(filter(None, [*self.authors, self.title, self.where]))

    def bibtex(self) -> str:
        """Return the entry for a BibTeX file."""
        # A name of more words than one person's is kept whole by braces.
        authors = " and ".join(f"{{{name}}}" if name == DEVELOPERS else name for name in self.authors)
        lines = [f"  {name} = {{{text}}}" for name, text in {"author": authors, "title": self.title, **self.fields}.items()]
        return f"@{self.kind}{{{self.key},\n" + ",\n".join(lines) + "\n}"


#: The paper of the two-phase model, its reduced model and its Roe solver.
MODEL = Work("article", "pelanti2008", ("M. Pelanti", "F. Bouchut", "A. Mangeney"),
             "A Roe-type scheme for two-phase shallow granular flows over variable topography",
             {"journal": "ESAIM: Mathematical Modelling and Numerical Analysis", "volume": "42", "pages": "851--885",
              "year": "2008", "doi": "10.1051/m2an:2008029"}, "M2AN 42 (2008) 851-885")


def package(version: str | None = None) -> Work:
    """Return this package as a work; with its version where one is given."""
    return Work("software", "fvkit", (DEVELOPERS,), "fvkit: pluggable finite volumes for hyperbolic systems",
                {} if version is None else {"version": version, "license": "BSD-3-Clause"})


#: What files carry: in words, without a version, which stands beside it there.
CITATION = "; ".join(work.sentence() for work in (MODEL, package()))


def bibtex(version: str) -> str:
    """Return the BibTeX entries to cite: the package of that version, and the paper of the two-phase model."""
    return "\n\n".join(work.bibtex() for work in (package(version), MODEL))
