"""TOML files whose mistakes are told with file, key and nearest match."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import attrs

from fvkit import validation
from fvkit_granular.csv_table import text_of

#: Larger files are refused, bytes: Python reads about 1 MB of TOML in a second.
LARGEST = 1_000_000


class TomlError(ValueError):
    """A mistake in a TOML file; the message names the file and the key, such as `sources[1].nu`."""


@attrs.frozen(eq=False)
class Table:
    """A table of a TOML file, named ``path``, with its place in the file: names of keys, and indices in lists."""

    path: Path
    place: tuple[str | int, ...] = ()
    data: Mapping[str, Any] = attrs.field(factory=dict)

    def only(self, allowed: Iterable[str]) -> "Table":
        """Return this table if all its keys are allowed, or raise at the first that is not, with the nearest match."""
        known = list(allowed)
        for key in self.data:
            if key not in known:
                nearest = _nearest(key, known)
                hint = f"did you mean `{nearest}`? " if nearest else ""
                raise self.error(f"unknown key `{validation.one_line(key)}`; {hint}allowed: {', '.join(known)}")
        return self

    def error(self, message: str, *inside: str | int) -> TomlError:
        """Return the error of a mistake in this table, or at a key in it."""
        steps = (f"[{step}]" if isinstance(step, int) else f".{step}" for step in (*self.place, *inside))
        return TomlError(f"{self.path}, {key}: {message}" if (key := "".join(steps)[1:]) else f"{self.path}: {message}")

    @contextmanager
    def located(self, *inside: str | int) -> Iterator[None]:
        """Turn errors about values into those of this table: at a key, or at the first one that the message names."""
        try:
            yield
        except TomlError:
            raise
        except (ValueError, TypeError, OSError, OverflowError) as error:
            here: Any = self.data
            for key in inside:
                here = here[key]
            named = [word for word in re.findall(r"`(\w+)", str(error)) if isinstance(here, dict) and word in here]
            raise self.error(str(error), *inside, *named[:1]) from None

    def need(self, key: str) -> Any:
        """Return the value of a key, or raise where it is missing."""
        if key not in self.data:
            raise self.error(f"the key `{key}` is missing")
        return self.data[key]

    def text(self, key: str, default: str | None = None) -> str:
        """Return the text at a key, or the default where there is one."""
        value = self.need(key) if default is None else self.data.get(key, default)
        if not isinstance(value, str):
            raise self.error(f"`{key}` must be a text in quotes, got {value!r}", key)
        return value

    def choice(self, key: str, known: Iterable[str]) -> str:
        """Return the text at a key, one of ``known``."""
        with self.located(key):
            return str(validation.choice(self.text(key), key, known))

    def inner(self, *inside: str | int) -> "Table":
        """Return the table at a key, or at an element of the list at a key."""
        data: Any = self.data
        for step in inside:
            data = self.need(str(step)) if data is self.data else data[step]
        if not isinstance(data, dict):
            raise self.error(f"`{inside[0]}` must be a table, got {data!r}", *inside)
        return attrs.evolve(self, place=(*self.place, *inside), data=data)

    def part(self, word: str, kinds: Mapping[str, type]) -> Any:
        """Return an instance of the class that the key ``word`` names, its fields read from the other keys."""
        kind: Any = kinds[self.choice(word, kinds)]
        known = sorted(attrs.fields(kind), key=lambda field: field.kw_only)
        fields = {field.alias: field.default is attrs.NOTHING for field in known if field.init}
        self.only((word, *fields))
        values = {name: self.need(name) if needed else self.data[name] for name, needed in fields.items()
                  if needed or name in self.data}
        with self.located():
            return kind(**values)


def _nearest(key: str, known: Iterable[str]) -> str | None:
    """The most similar of the known keys, whatever the case; names of two letters may differ by one."""
    if len(key) > validation.LONGEST:
        return None
    lower = {name.lower(): name for name in known}
    found = get_close_matches(key.lower(), lower, n=1, cutoff=0.5)
    return lower[found[0]] if found else None


def toml_text(path: Path) -> str:
    """Return the text of a TOML file, or raise where reading it as TOML would take too long."""
    text = text_of(path, LARGEST)
    if re.search(r"(?:\.[ \t]*[^\s.=\[\]{},#]+[ \t]*){100}", text):
        raise TomlError(f"{path} is nested too deeply")
    return text


def read_toml(path: str | Path) -> Table:
    """Return a TOML file of at most 1 MB as a table; a TomlError where it is no TOML, with the line."""
    place = validation.file(path, "path")
    text = toml_text(place)
    try:
        return Table(place, (), tomllib.loads(text))
    except RecursionError:
        raise TomlError(f"{place} is nested too deeply") from None
    except ValueError as error:
        raise TomlError(_not_toml(place, str(error))) from None


def _not_toml(path: Path, message: str) -> str:
    found = re.search(r" \(at line (\d+), (column \d+)\)$", message)
    where, said = (f", line {found[1]}, {found[2]}", message[:found.start()]) if found else ("", message)
    inline = "key part" in said or "inline table" in said
    hint = " (a table in braces must be on one line, without a comma at its end)" if inline else ""
    return f"{path}{where}: this is not TOML: {said}{hint}"
