"""The ids of all golden values, of which set each is, and in which file it stands.

An id is never given to another value: where a definition has to change, a new id supersedes the old one. `making`,
`verifying` and the checks of conformance find entries by these ids only. What belongs to which set follows from the
tables: vectors from `defined.TABLES`, realisations and ensembles from `SEAS`. To add some is to add a row.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from leakref._base import LeakrefError
from leakref.cases import CASES, PAPER_CASES, Configuration
from leakref.golden.defined import TABLES
from leakref.methods import DEFAULT, METHODS

__all__ = [
    "PAPER",
    "SEAS",
    "Seas",
    "certified_ids",
    "configuration_of",
    "ensemble_id",
    "ids",
    "methods_of",
    "together",
]


@dataclass(frozen=True)
class Seas:
    """Realisations and ensembles of some configurations by some methods, all of one golden set.

    - `number`: that of the set; `methods`: ids of `leakref.methods`.
    - `tag`: part of the ids of realisations, for configurations that have others already; empty for the first ones.
    - `certified`: numbers of the realisations that are golden one by one; ensembles have a hundred.
    """

    number: int
    configurations: tuple[Configuration, ...]
    methods: tuple[str, ...] = ("nsp", "ls")
    tag: str = ""
    certified: tuple[int, ...] = (0, 1)

    def realization(self, c: Configuration, number: int) -> str:
        """The id of one realisation, such as `realization-gamma/spread=15,peakedness=7/0`."""
        return f"realization-{c.id}/{f'{self.tag}/' if self.tag else ''}{number}"


PAPER = tuple(c for members in PAPER_CASES.values() for c in members)
"""Every configuration of the paper."""
_BESIDE = {case: (0, 1) if case in ("nsp-ls", "windows") else (0,) for case in PAPER_CASES}
"""Which realisations by the methods beside the paper's two are golden one by one: of most cases it is one, since it
takes the whole surface.
"""
SEAS = (
    Seas(1, PAPER),
    Seas(2, CASES["depth"]),
    *(
        Seas(2, PAPER_CASES[case], (name,), name, certified)
        for name in METHODS
        if name not in DEFAULT
        for case, certified in _BESIDE.items()
    ),
)
"""All that there are; no two rows have both a configuration and a method in common."""


def certified_ids(c: Configuration, method: str = "nsp") -> list[str]:
    """The ids of the realisations of a configuration that have velocities by `method`.

    Such as `realization-gamma/spread=15,peakedness=7/0`. Raises LeakrefError if there is none.
    """
    for seas in SEAS:
        if c in seas.configurations and method in seas.methods:
            return [seas.realization(c, number) for number in seas.certified]
    raise LeakrefError("golden", f"{c.id} by {method!r} is in no golden set", "add a row to golden.ids.SEAS")


def ensemble_id(c: Configuration, window: str, method: str) -> str:
    """The id of the ensemble of a configuration under a window and a method.

    Such as `ensemble-nsp-ls/hann-nsp`.
    """
    return f"ensemble-{c.id}/{window}-{method}"


def _file_of(part: str, name: str) -> str:
    return f"{part}/{name}.json"


def ids(*parts: str, number: int | None = None) -> dict[str, str]:
    """Every id that can be made, and the file it belongs in.

    `parts` are names of the folders of a set (`sets.SETS`); without any there are none. The order is that of the files.
    With a `number` those of that set alone, without what it extends.
    """
    found = {
        v.id: _file_of(part, v.stage if part == "vectors" else "windows")
        for table_number, table in TABLES.items()
        if number in (None, table_number)
        for part, vectors in table.items()
        if part in parts
        for v in vectors
    }
    for seas in (seas for seas in SEAS if number in (None, seas.number)):
        for c in seas.configurations:
            if "realizations" in parts:
                found |= {seas.realization(c, n): _file_of("realizations", c.case) for n in seas.certified}
            if "ensembles" in parts:
                found |= {ensemble_id(c, w, m): _file_of("ensembles", c.case) for w in c.windows for m in seas.methods}
    return found


def _row(identifier: str) -> tuple[Seas, Configuration]:
    """The row and the configuration of an id. Raises LeakrefError."""
    kind, _, rest = identifier.partition("-")
    name, _, last = rest.rpartition("/")
    for seas in SEAS:
        tag = f"/{seas.tag}" if seas.tag and kind == "realization" else ""
        for c in seas.configurations:
            known = kind != "ensemble" or last in {
                f"{window}-{method}" for window in c.windows for method in seas.methods
            }
            if known and f"{c.id}{tag}" == name:
                return seas, c
    raise LeakrefError("golden", f"{identifier!r} names no configuration of the sets", "ids are in the manifest")


def configuration_of(identifier: str) -> Configuration:
    """The configuration that the id of a realisation or an ensemble names.

    Raises LeakrefError for an id that names none.
    """
    return _row(identifier)[1]


def methods_of(identifier: str) -> tuple[str, ...]:
    """The methods by which the velocities of a realisation, or of an ensemble and its neighbours, are measured."""
    return _row(identifier)[0].methods


def together(identifiers: Iterable[str]) -> dict[Configuration, tuple[str, ...]]:
    """The configurations of realisations or ensembles, each with all methods by which they are asked for: what is made
    of one sea by several methods is made at once.
    """
    found: dict[Configuration, tuple[str, ...]] = {}
    for identifier in identifiers:
        c = configuration_of(identifier)
        found[c] = tuple(dict.fromkeys((*found.get(c, ()), *methods_of(identifier))))
    return found
