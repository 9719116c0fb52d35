"""The documents: every link and picture is there, and every command that they show exists."""

import re
from pathlib import Path

import pytest

from fvkit.cli import build_parser
from tests.pages import code_blocks

TOP = Path(__file__).parent.parent
PAGES = [TOP / "README.md", TOP / "CHANGELOG.md", *sorted((TOP / "docs").glob("*.md")),
         *sorted((TOP / "docs" / "tutorials").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_exist(page):
    for target in re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8")):
        assert target.startswith("http") or (page.parent / target).exists(), target


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_parse(page):
    parser = build_parser()
    for command in re.findall(r"`fvkit ([a-z][^`]*)`", page.read_text(encoding="utf-8")):
        words = command.split()
        if not any(word.isupper() for word in words) and "--help" not in words:
            assert parser.parse_args([*words, "riemann"] if words in (["run"], ["compare"]) else words)


def test_the_snippets_about_channels_run(capsys):
    exec("\n".join(code_blocks(TOP / "docs" / "channels.md", "python")), {"__name__": "snippets"})
    highest, deposit = capsys.readouterr().out.splitlines()
    assert "highest" in highest
    assert deposit.startswith("STOPPED at ")


def test_the_snippets_about_results_run(tmp_path, monkeypatch):
    for name in ("xarray", "h5netcdf", "h5py"):
        pytest.importorskip(name)
    monkeypatch.chdir(tmp_path)
    blocks = code_blocks(TOP / "docs" / "results.md", "python")
    assert len(blocks) == 8
    exec("\n".join(blocks), {"__name__": "snippets"})
    assert {path.name for path in tmp_path.iterdir()} == {"run.npz", "run.nc", "frames.nc", "long.npz"}
