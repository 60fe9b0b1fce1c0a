"""Tables never cut a number, whatever width there is."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

import leakref
from leakref import runs
from leakref._tables import Table
from leakref.cases import CASES
from leakref.paper import reproduce

WIDTHS = (60, 80, 100)
NUMBER = re.compile(r"\d[\d.,±e+-]*")


def rendered(table, width):
    console = Console(width=width, color_system=None, legacy_windows=False)
    with console.capture() as caught:
        console.print(table)
    return caught.get()


def words_of(table):
    """Each number in headings and cells, and each word without a space."""
    cells = [str(cell) for heading, _ in table.columns for cell in [heading]]
    cells += [str(cell) for row, _ in table.rows for cell in row]
    plain = (re.sub(r"\[/?[a-z ]*\]", "", cell) for cell in cells)
    return {word for cell in plain for word in cell.split() if any(letter.isdigit() for letter in word)}


def assert_whole(table, width):
    said = rendered(table, width)
    assert "…" not in said
    assert max(map(len, said.splitlines())) <= width
    lines = {word for line in said.splitlines() for word in re.split(r"[\s│┃|]+", line)}
    missing = words_of(table) - lines
    assert not missing, (missing, said)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("columns", [1, 3, 8, 20])
def test_every_number_of_a_table_is_whole(width, columns):
    rng = np.random.default_rng(columns)
    table = Table(
        title="Velocities in metres a second, of a title that is longer than sixty letters", caption="said below"
    )
    table.add_column("wavenumber (rad/m)", justify="right")
    for n in range(columns):
        table.add_column(f"a heading of four words {n}", justify="right" if n % 2 else "left")
    for k in range(5):
        cells = [f"{v:.4f}±{abs(v) / 7:.3f}" for v in 10.0 ** rng.uniform(-3, 6, columns)]
        table.add_row(f"{k / 7:.6g}", *cells, style="red" if k == 2 else None)
    assert_whole(table, width)


@pytest.mark.parametrize("width", WIDTHS)
def test_words_are_wrapped_between_words_and_long_names_keep_every_letter(width):
    table = Table("family", "what it says", "figure")
    table.add_row(
        "metamorphic", "a sentence that needs to be wrapped, since it is far longer than a line of sixty", "402174"
    )
    table.add_row("a.module.with.a.very.long.dotted.name:and_a_function_in_it", "[red]no[/red]", "1.5e-12")
    assert_whole(table, width)
    said = rendered(table, width)
    assert "metamorphic" in said
    assert "a.module.with.a.very.long" in said.replace("\n", "")[:4000] or "a.module.with.a.very.lon" in said


def test_what_does_not_fit_side_by_side_stands_below_with_its_key():
    table = Table(title="T", caption="C")
    for name in ("k", "first", "second", "third"):
        table.add_column(name)
    table.add_row("0.5", *("1" * 20 for _ in range(3)))
    said = rendered(table, 40)
    assert said.count("0.5") == 3
    assert (said.count(" T"), said.count(" C")) == (1, 1)
    assert said.index("first") < said.index("second") < said.index("third")
    assert rendered(table, 120).count("0.5") == 1
    narrow = rendered(table, 15)  # not one column fits: lines
    assert "first:" in narrow


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("case", ["windows", "nsp-ls"])
def test_the_table_of_a_case_is_whole(width, case):
    """`reproduce windows` in 80 columns printed nothing but "0.0…"."""
    small = [type(c)(c.case, length=3, duration=5, windows=c.windows, varied=c.varied) for c in CASES[case]]
    (found,) = runs.run(small, realizations=2)
    assert_whole(reproduce.table(found), width)


def test_columns_without_a_heading_come_with_the_rows():
    table = Table(box=None, show_header=False)
    table.add_row("data", "your own cubes")
    assert "your own cubes" in rendered(table, 60)


def test_no_other_tables_are_used():
    house = Path(leakref.__file__).parent
    using = [p.name for p in house.rglob("*.py") if "rich.table" in p.read_text(encoding="utf-8")]
    assert using == ["_tables.py"]
