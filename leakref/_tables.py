"""Tables that never cut a number: what does not fit side by side is laid out otherwise.

A table is laid out in the width that there is, on a terminal, in a pipe or in a log. If its columns fit it is one
table, with words wrapped where they must be. If they do not, it becomes several, one below the other, each with the
first column, by which its rows are told apart, and as many of the others as fit whole. If not even one fits beside it,
each row becomes lines, a heading and its cell on each.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from rich.console import Console, ConsoleOptions
from rich.measure import Measurement
from rich.table import Table as Plain
from rich.text import Text

__all__ = ["Table"]

_LONGEST = 24  # letters of a word without a digit from which it may be broken, as the names of files are


class Table:
    """A table for rich consoles, filled as `rich.table.Table` is.

    `headings` are those of plain columns, if there are any; more columns are added by `add_column`. `keys` is the
    number of first columns that are repeated wherever the table is broken. `settings` are those of `rich.table.Table`.
    """

    def __init__(self, *headings: str, keys: int = 1, **settings: Any) -> None:
        self.keys, self.settings = keys, settings
        self.columns: list[tuple[Any, dict[str, Any]]] = [(heading, {}) for heading in headings]
        self.rows: list[tuple[tuple[Any, ...], dict[str, Any]]] = []

    def add_column(self, heading: Any = "", **settings: Any) -> None:
        """A column with its heading; `settings` are those of rich, such as `justify` and `style`."""
        self.columns.append((heading, settings))

    def add_row(self, *cells: Any, **settings: Any) -> None:
        """A row of as many cells as there are columns, or fewer; of more, columns without a heading are added."""
        self.columns += [("", {}) for _ in range(len(self.columns), len(cells))]
        self.rows.append((cells, settings))

    def add_section(self) -> None:
        """A line below the last row."""
        if self.rows:
            self.rows[-1][1]["end_section"] = True

    def _cells(self, n: int) -> list[Any]:
        """The heading of a column and all that stands below it."""
        return [self.columns[n][0], *(cells[n] for cells, _ in self.rows if n < len(cells))]

    def _widths(self, console: Console, n: int) -> tuple[int, int]:
        """What a column needs at least, so that nothing in it is cut, and what it would take if it had room. Cells that
        stand to the right hold figures, which are not wrapped either.
        """
        least = most = 1
        figures = self.columns[n][1].get("justify") == "right"
        for row, cell in enumerate(self._cells(n)):
            text = Text.from_markup(cell) if isinstance(cell, str) else cell
            if not isinstance(text, Text):
                measured = Measurement.get(console, console.options, text)
                least, most = max(least, measured.minimum), max(most, measured.maximum)
                continue
            for word in text.plain.split():
                whole = len(word) <= _LONGEST or any(letter.isdigit() for letter in word)
                least = max(least, Text(word).cell_len if whole else _LONGEST)
            longest = max(Text(line).cell_len for line in text.plain.split("\n"))
            most = max(most, longest)
            least = max(least, longest) if figures and row else least
        if self.columns[n][1].get("no_wrap"):
            least = most
        return least, max(least, most)

    def _plain(self, chosen: Sequence[int], widths: Sequence[int], **settings: Any) -> Plain:
        """A plain table of some of the columns, each of its width."""
        table = Plain(**{**self.settings, **settings})
        for n, width in zip(chosen, widths, strict=True):
            heading, own = self.columns[n]
            table.add_column(heading, **{"overflow": "fold", **own, "width": width, "no_wrap": False})
        for cells, own in self.rows:
            table.add_row(*(cells[n] if n < len(cells) else "" for n in chosen), **own)
        return table

    def _taken(self, console: Console, chosen: Sequence[int], widths: Sequence[int]) -> int:
        """How wide a table of these columns is, with its borders and the room between the columns."""
        bare = self._plain(chosen, widths, title=None, caption=None)
        return Measurement.get(console, console.options.update(max_width=10_000), bare).maximum

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[Any]:
        """One table, several, or lines, by the width that there is."""
        available = options.max_width
        needs = [self._widths(console, n) for n in range(len(self.columns))]
        keys = list(range(min(self.keys, len(self.columns))))
        parts: list[list[int]] = [list(keys)]
        for n in range(len(keys), len(self.columns)):
            wider = [*parts[-1], n]
            if self._taken(console, wider, [needs[m][0] for m in wider]) > available and len(parts[-1]) > len(keys):
                parts.append([*keys, n])
            else:
                parts[-1].append(n)
        if any(self._taken(console, part, [needs[m][0] for m in part]) > available for part in parts):
            yield from self._lines()
            return
        for at, part in enumerate(parts):
            settings = {} if at == 0 else {"title": None}
            settings |= {} if at == len(parts) - 1 else {"caption": None}
            yield self._plain(part, self._spread(console, part, needs, available), **settings)

    def _spread(
        self, console: Console, part: Sequence[int], needs: Sequence[tuple[int, int]], available: int
    ) -> list[int]:
        """The widths of columns side by side: what each needs, and the room that is left to those that want more."""
        widths = [needs[n][0] for n in part]
        room = available - self._taken(console, part, widths)
        while room > 0:
            wanting = [i for i, n in enumerate(part) if widths[i] < needs[n][1]]
            if not wanting:
                break
            narrowest = min(wanting, key=lambda i: widths[i])
            widths[narrowest] += 1
            room -= 1
        return widths

    def _lines(self) -> Iterator[Text]:
        """A row as lines, each with a heading and what stands below it, wrapped between words."""
        if self.settings.get("title"):
            yield Text.from_markup(str(self.settings["title"]))
        for cells, _ in self.rows:
            for (heading, _own), cell in zip(self.columns, cells, strict=False):
                name = " ".join(Text.from_markup(str(heading)).plain.split())
                line = Text(f"{name}: " if name else "")
                line.append_text(Text.from_markup(cell) if isinstance(cell, str) else Text(str(cell)))
                yield line
            yield Text("")
        if self.settings.get("caption"):
            yield Text.from_markup(str(self.settings["caption"]))
