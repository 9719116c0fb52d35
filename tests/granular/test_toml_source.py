"""TOML with positions: every key gets its line, and every mistake its file and line."""

import tomllib

import pytest

from fvkit_granular.scenes.toml.positions import key_lines
from fvkit_granular.scenes.toml.table import TomlError, read_toml

TRICKY = '''# a comment with key = 1
title = "no # comment, \\" no = key"   # real comment
'quoted key' = 'C:\\'
a.b.c = 1
  long = """
x = 1
[not.a.table]
"ends with quotes"""""
raw = \'\'\'
y = 2 \'\'\'\'\'
numbers = [
  1, # one
  2e3,
  [3, 4],

  {p = 1, q = {r = "]"}}, {p = 2},
]

[table]   # comment
"dotted"."key" = 1979-05-27T07:32:00Z
[table.inner]
z = -inf
[[list]]
n = 1
[list.inner]
n = 10
[[list]]

n = 2
[[list.deep]]
m = 1
[[list.deep]]
m = 2
'''

LINES = {("title",): 2, ("quoted key",): 3, ("a", "b", "c"): 4, ("long",): 5, ("raw",): 9, ("numbers",): 11, ("numbers", 0): 12,
         ("numbers", 2, 1): 14, ("numbers", 3, "q", "r"): 16, ("numbers", 4, "p"): 16, ("table",): 19, ("table", "dotted", "key"): 20,
         ("table", "inner", "z"): 22, ("list", 0): 23, ("list", 0, "inner", "n"): 26, ("list", 1): 27, ("list", 1, "n"): 29,
         ("list", 1, "deep", 0, "m"): 31, ("list", 1, "deep", 1, "m"): 33}


def places(data, place=()):
    """Every place of the data, from the data itself."""
    yield place
    steps = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for step, value in steps:
        yield from places(value, (*place, step))


@pytest.mark.parametrize("text", [TRICKY, TRICKY.replace("\n", "\r\n"), TRICKY.rstrip()])
def test_every_place_of_the_data_has_its_line(text):
    found = key_lines(text)
    assert set(found) == set(places(tomllib.loads(text)))
    assert {place: found[place] for place in LINES} == LINES


@pytest.mark.parametrize("text", ["", "# nothing\n", "[empty]\n", "x = 1", "x = []", "x = {}", "[a]\n[a.b]\n"])
def test_small_texts(text):
    assert set(key_lines(text)) == set(places(tomllib.loads(text)))


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


def test_a_mistake_names_the_nearest_key_and_the_line(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text("[first]\ndepth = 1\n\n[second]\ndept = 1\n")
    table = read_toml(path).only(("first", "second"))
    assert table.inner("first").only(("depth",)).data == {"depth": 1}
    with pytest.raises(TomlError, match=r"mine.toml, line 5: unknown key `dept`; did you mean `depth`\? allowed: depth, width$"):
        table.inner("second").only(("depth", "width"))
    with pytest.raises(TomlError, match=r"line 4: the key `depth` is missing in \[second\]"):
        table.inner("second").need("depth")
    with pytest.raises(TomlError, match="line 2: `depth` must be a text in quotes, got 1"):
        table.inner("first").text("depth")
