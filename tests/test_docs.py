"""The documents: every link and picture is there, every command that they show exists, and the reference is complete."""

import re
from pathlib import Path

import pytest

import fvkit
import fvkit.testing
import fvkit_granular
from fvkit.cli import build_parser, main
from fvkit.problem import questions
from tests.pages import code_blocks

TOP = Path(__file__).parent.parent
#: Folders of docs/ that a build makes.
BUILT = {"_build", "gallery", "generated", "jupyter_execute"}
PAGES = [TOP / "README.md", TOP / "CHANGELOG.md", TOP / "CONTRIBUTING.md", TOP / "SECURITY.md", TOP / "tests" / "LOG.md",
         *(page for page in sorted((TOP / "docs").rglob("*.md")) if not BUILT & set(page.relative_to(TOP).parts))]


def name(page):
    return str(page.relative_to(TOP))


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_and_pictures_exist(page):
    for target in re.findall(r"\]\(([^)#]+)", page.read_text(encoding="utf-8")):
        assert target.startswith("http") or (page.parent / target).exists(), target


def test_the_table_of_questions_is_that_of_the_code():
    tables = {"model": questions.MODEL, "source": questions.SOURCE, "boundary": questions.BOUNDARY, "Riemann solver": questions.RIEMANN,
              "limiter": questions.LIMITER, "reconstruction": questions.RECONSTRUCTION}
    rows = [f"| {part} | `{one.call}` | {one.answers} | {one.asked_by} |" for part, table in tables.items() for one in table]
    assert "\n".join(rows) in (TOP / "docs" / "extending.md").read_text(encoding="utf-8")


#: `fvkit.where`, `fvkit.maximum` and `fvkit.minimum` are NumPy's: the page names them in a sentence. `gr.scenes` and `gr.shapes` stand
#: there as the modules that they are, scenes.library.riemann and scenes.shapes.
@pytest.mark.parametrize(("module", "besides"), [(fvkit, {"where", "maximum", "minimum"}), (fvkit_granular, {"scenes", "shapes"}), (fvkit.testing, set())],
                         ids=lambda value: getattr(value, "__name__", ""))
def test_the_reference_lists_every_public_name_once(module, besides):
    text = (TOP / "docs" / "reference" / f"{module.__name__}.md").read_text(encoding="utf-8")
    listed = re.findall(r"^   (\w+)$", text, re.MULTILINE)
    assert sorted(listed) == sorted(set(module.__all__) - besides)
    assert all(f"`{module.__name__}.{word}`" in text for word in besides)


@pytest.mark.parametrize("script", sorted((TOP / "examples").glob("*.py")), ids=lambda script: script.stem)
def test_examples_start_with_a_title_for_the_gallery(script):
    first, line, _ = script.read_text(encoding="utf-8").split("\n", 2)
    title = first.removeprefix('"""')
    assert title != first
    assert line == "=" * len(title)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_commands_parse(page):
    parser = build_parser()
    for command in re.findall(r"`fvkit ([a-z][^`]*)`", page.read_text(encoding="utf-8")):
        words = command.split()
        if not any(word.isupper() for word in words) and "--help" not in words:
            assert parser.parse_args([*words, "riemann"] if words in (["run"], ["compare"], ["advise"]) else words)


def test_the_snippets_about_channels_run(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec("\n".join(code_blocks(TOP / "docs" / "channels.md", "python")), {"__name__": "snippets"})
    highest, passed, arrived, deposit = capsys.readouterr().out.splitlines()
    assert "highest" in highest
    assert passed.startswith("passed the end: {'hs': ")
    assert 0.0 < float(arrived.split()[5]) < 90.0
    assert (tmp_path / "profile.pdf").read_bytes().startswith(b"%PDF")
    assert deposit.startswith("STOPPED at ")


@pytest.mark.filterwarnings("ignore:characteristic speeds are complex")  # films of grains that outrun their water
def test_the_channel_of_the_page_runs(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (block,) = code_blocks(TOP / "docs" / "channels.md", "toml")
    Path("channel.toml").write_text(block)
    Path("torrent.csv").write_text("distance [km], elevation [m]\n0, 40\n0.4, 0\n")
    Path("flood.csv").write_text("t [min], discharge [m2/s], phi [-]\n0, 0, 0.5\n0.5, 4, 0.5\n1, 0, 0.5\n")
    assert main(["run", "channel.toml", "--cells", "40", "--plot", "profile", "space-time", "--format", "pdf"]) == 0
    said = capsys.readouterr().out
    assert "in through the left: hs 60, hf 60 m2" in said  # the integral of the table
    assert {"profile.pdf", "space-time.pdf", "gauges.csv", "line-outlet.csv", "front.csv", "maxima.csv"} <= {
        path.name for path in next(tmp_path.glob("fvkit-run-*")).iterdir()}


def test_the_snippet_about_work_and_precision_runs(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (block,) = code_blocks(TOP / "docs" / "work_precision.md", "python")
    exec(block, {"__name__": "snippets"})
    assert "reference exact" in capsys.readouterr().out
    assert (tmp_path / "surges" / "report.csv").exists()


def test_the_snippet_about_moving_equilibria_runs():
    (block,) = code_blocks(TOP / "docs" / "moving_equilibria.md", "python")
    found = {}
    exec(block, found)
    solution = fvkit.solve(found["problem"], fvkit.WavePropagation(fvkit.Roe()), backend="numpy")
    assert abs(solution.q[-1] - found["kept"]).max() < 1e-12


def test_the_snippets_about_results_run(tmp_path, monkeypatch):
    for name in ("xarray", "h5netcdf", "h5py"):
        pytest.importorskip(name)
    monkeypatch.chdir(tmp_path)
    blocks = code_blocks(TOP / "docs" / "results.md", "python")
    assert len(blocks) == 8
    exec("\n".join(blocks), {"__name__": "snippets"})
    assert {path.name for path in tmp_path.iterdir()} == {"run.npz", "run.nc", "frames.nc", "long.npz"}


def test_the_snippets_about_terrains_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = code_blocks(TOP / "docs" / "terrain.md", "python")
    assert len(blocks) == 4
    exec("\n".join(blocks), {"__name__": "snippets"})
    said = capsys.readouterr().out
    assert "60 x 40 cells of 5 m" in said
    assert "normal to the ground" in said
    assert "hit rate" in said
    assert {path.name for path in tmp_path.iterdir()} == {"valley.asc", "release.geojson", "deepest.asc", "deepest.png"}
