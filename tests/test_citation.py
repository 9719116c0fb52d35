"""What to cite: one source for the command, the files, CITATION.cff and the documents."""

import re
from importlib.metadata import version
from pathlib import Path

import fvkit
import fvkit_granular as gr
from fvkit.cli import SUCCESS, main
from fvkit.output.citation import Work, bibtex, package
from fvkit_granular.models.literature import PELANTI_2008

TOP = Path(__file__).parent.parent
CFF = (TOP / "CITATION.cff").read_text(encoding="utf-8")


def test_the_command_prints_the_package_with_its_version_and_the_paper(capsys):
    assert main(["cite"]) == SUCCESS
    printed = capsys.readouterr().out
    assert re.findall(r"^@(\w+)\{(\w+),$", printed, re.MULTILINE) == [("software", "fvkit"), ("article", "pelanti2008")]
    assert f"  version = {{{fvkit.__version__}}}" in printed
    assert printed.count("{") == printed.count("}")
    assert "author = {{The fvkit developers}}" in printed
    assert "doi" not in package("1.0").bibtex()


def test_entries_have_no_comma_after_their_last_field():
    work = Work("article", "key", ("A. Author", "B. Author"), "A title", {"year": "2000"})
    assert work.bibtex() == "@article{key,\n  author = {A. Author and B. Author},\n  title = {A title},\n  year = {2000}\n}"
    assert work.sentence() == "A. Author, B. Author, A title"


def test_citation_cff_says_the_same():
    fields = dict(re.findall(r"^([\w-]+): (.+)$", CFF, re.MULTILINE))
    assert fields["version"] == fvkit.__version__ == version("fvkit")
    assert fields["cff-version"] == "1.2.0"
    assert fields["title"].strip('"') == package().title
    assert f"doi: {PELANTI_2008.fields['doi']}" in CFF
    assert PELANTI_2008.title in CFF
    names = re.findall(r"family-names: (\w+)\n +given-names: (.+)", CFF)
    assert [f"{given} {family}" for family, given in names] == list(PELANTI_2008.authors)


def test_the_bibliography_of_the_documents_holds_the_printed_entry():
    assert PELANTI_2008.bibtex() in (TOP / "docs" / "references.bib").read_text(encoding="utf-8")
    assert PELANTI_2008.bibtex() in bibtex(fvkit.__version__)


def test_files_name_the_package_and_the_work_of_the_model_that_was_used():
    burgers = fvkit.Problem(fvkit.Burgers(), fvkit.Grid(0.0, 1.0, 10), lambda x: [x], 0.1)
    alone = fvkit.solve(burgers, backend="numpy").configuration["citation"]
    both = fvkit.solve(gr.scene("riemann").problem(gr.TwoPhase, 10), backend="numpy").configuration["citation"]
    assert alone == package().sentence()
    assert both == f"{PELANTI_2008.sentence()}; {package().sentence()}"
