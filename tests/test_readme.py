"""What README says is true: its code and its scene run as printed."""

import shutil
from pathlib import Path

import pytest

import fvkit_granular as gr
from tests.pages import code_blocks

TOP = Path(__file__).parent.parent
SAMPLE = TOP / "fvkit_granular" / "scenes" / "samples" / "torrent"
BLOCKS = code_blocks(TOP / "README.md", "python")
(MOUNTAIN,) = code_blocks(TOP / "README.md", "toml")


@pytest.mark.parametrize("code", BLOCKS, ids=["library", "model"])
def test_code_of_the_readme_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "block.py"
    file.write_text(code)
    exec(compile(code, str(file), "exec"), {"__name__": "__main__"})
    assert "FINISHED" in capsys.readouterr().out or "steps, largest slip" in code


def test_the_mountain_of_the_readme_is_a_scene(tmp_path):
    shutil.copy(SAMPLE / "terrain.asc", tmp_path / "dem.asc")
    release = (SAMPLE / "release.geojson").read_text(encoding="utf-8")
    (tmp_path / "release.geojson").write_text(release.replace('"thickness"', '"drawn"').replace('"phi"', '"by"'), encoding="utf-8")
    (tmp_path / "torrent.toml").write_text(MOUNTAIN, encoding="utf-8")
    scene = gr.load_scene(tmp_path / "torrent.toml")
    assert (scene.t_end, scene.gamma, len(scene.sources)) == (120.0, 0.42, 2)
    start = scene.problem(gr.TwoPhase)
    assert start.model.slope == "steep"
    assert start.q0[0].sum() / (start.q0[0] + start.q0[3]).sum() == pytest.approx(0.6)


def test_lengths_of_the_headings():
    mountain, library, model = (len([line for line in code.splitlines() if line.strip()]) for code in (MOUNTAIN, *BLOCKS))
    assert mountain <= 10
    assert library <= 15
    assert model <= 30
