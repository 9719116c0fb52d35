"""Lines of keys in a TOML text, which `tomllib` does not tell."""

import tomllib

#: A place in the data: names of keys, and indices in lists.
Place = tuple[str | int, ...]


def key_lines(text: str) -> dict[Place, int]:
    """Return {place: line, counted from 1} of every key, table and element of a list.

    Parameters
    ----------
    text : TOML that `tomllib` accepts; of another text the result means nothing.
    """
    return _Scanner(text.replace("\r\n", "\n") + "\n").lines


class _Scanner:
    """Walks through a valid text once and notes where things stand."""

    def __init__(self, text: str) -> None:
        self.text, self.at, self.line = text, 0, 1
        self.lines: dict[Place, int] = {(): 1}
        self.counts: dict[Place, int] = {}
        table: Place = ()
        while self.skip(" \t\n"):
            if self.text[self.at] != "[":
                self.pair(table)
                continue
            several = self.text.startswith("[[", self.at)
            self.move(2 if several else 1)
            table = self.header(self.key(), several)
            self.move(2 if several else 1)

    def skip(self, blank: str) -> bool:
        """Go to what is neither blank nor a comment; return whether there is anything."""
        while self.at < len(self.text) and (self.text[self.at] in blank or self.text[self.at] == "#"):
            self.move((self.text.index("\n", self.at) - self.at) if self.text[self.at] == "#" else 1)
        return self.at < len(self.text)

    def move(self, count: int) -> None:
        self.line += self.text.count("\n", self.at, self.at + count)
        self.at += count

    def note(self, place: Place) -> Place:
        self.lines.setdefault(place, self.line)
        return place

    def header(self, names: list[str], several: bool) -> Place:
        """Return the place of the table of a header; names that stand for lists mean their last element."""
        place: Place = ()
        for k, name in enumerate(names):
            place = self.note((*place, name))
            if several and k == len(names) - 1:
                self.counts[place] = self.counts.get(place, -1) + 1
            if place in self.counts:
                place = self.note((*place, self.counts[place]))
        return place

    def key(self) -> list[str]:
        """Read a key, dotted or not, and what is blank behind it."""
        names = []
        while True:
            self.skip(" \t")
            start = self.at
            if self.text[start] in "\"'":
                self.string()
                names.append(tomllib.loads(f"k = {self.text[start:self.at]}")["k"])
            else:
                while self.text[self.at] not in " \t.=]":
                    self.at += 1
                names.append(self.text[start:self.at])
            self.skip(" \t")
            if self.text[self.at] != ".":
                return names
            self.move(1)

    def pair(self, table: Place) -> None:
        place = table
        for name in self.key():
            place = self.note((*place, name))
        self.move(1)
        self.skip(" \t")
        self.value(place)

    def value(self, place: Place) -> None:
        first = self.text[self.at]
        if first in "\"'":
            self.string()
        elif first in "[{":
            self.move(1)
            count = 0
            while self.skip(" \t\n,") and self.text[self.at] not in "]}":
                if first == "{":
                    self.pair(place)
                else:
                    self.value(self.note((*place, count)))
                    count += 1
            self.move(1)
        else:
            while self.text[self.at] not in ",]}\n#":
                self.at += 1

    def string(self) -> None:
        """Go behind a string."""
        quote = self.text[self.at]
        mark = 3 * quote if self.text.startswith(3 * quote, self.at) else quote
        self.move(len(mark))
        while not self.text.startswith(mark, self.at):
            self.move(2 if quote == '"' and self.text[self.at] == "\\" else 1)
        # Up to two quotes may stand before the three that end a long string.
        while len(mark) == 3 and self.text.startswith(mark, self.at + 1):
            self.move(1)
        self.move(len(mark))
