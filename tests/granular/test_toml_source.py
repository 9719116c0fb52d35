"""TOML files: every mistake has its file and its key, or its line where it is no TOML."""

import pytest

from fvkit_granular.scenes.toml.table import TomlError, read_toml


@pytest.mark.parametrize(("text", "words"), [
    (b"x = \n", ("mine.toml, line 1, column", "not TOML")),
    (b"a = 1\nx = {y = 1,\n z = 2}\n", ("line 2", "one line")),
    (b"a = 1\na = 2\n", ("line 2", "not TOML")),
    (b"x = 1\ny = '\xff'\n", ("line 2", "UTF-8")),
    (b"x = " + 100_000 * b"[", ("mine.toml",)),
    (b"#" * 1_000_001, ("larger than 1 MB",)),
])
def test_what_is_no_toml_is_refused_with_its_place(text, words, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(text)
    with pytest.raises(ValueError, match=r".") as refusal:
        read_toml(path)
    for word in words:
        assert word in str(refusal.value)


def test_a_mistake_names_the_nearest_key_and_its_place(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[first]\ndepth = 1\n\n[second]\ndept = 1\n")
    table = read_toml(path).only(("first", "second"))
    assert table.inner("first").only(("depth",)).data == {"depth": 1}
    with pytest.raises(TomlError, match=r"mine.toml, second: unknown key `dept`; did you mean `depth`\? allowed: depth, width$"):
        table.inner("second").only(("depth", "width"))
    with pytest.raises(TomlError, match=r"mine.toml, second: the key `depth` is missing"):
        table.inner("second").need("depth")
    with pytest.raises(TomlError, match=r"mine.toml, first.depth: `depth` must be a text in quotes, got 1"):
        table.inner("first").text("depth")
