"""What README says is true: its code runs as printed."""

from pathlib import Path

import pytest

from tests.pages import code_blocks

BLOCKS = code_blocks(Path(__file__).parent.parent / "README.md", "python")


@pytest.mark.parametrize("code", BLOCKS, ids=["library", "two-axes", "model"])
def test_code_of_the_readme_runs(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "block.py"
    file.write_text(code)
    exec(compile(code, str(file), "exec"), {"__name__": "__main__"})
    assert "FINISHED" in capsys.readouterr().out or "steps, largest slip" in code


def test_lengths_that_the_readme_promises():
    library, _, model = (len([line for line in code.splitlines() if line.strip()]) for code in BLOCKS)
    assert library <= 15
    assert model <= 30
