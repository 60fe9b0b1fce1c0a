"""The ids of all golden values, and in which file each stands.

An id is never given to another value: where a definition has to change, a new id supersedes the old one. `making`,
`verifying` and the checks of conformance find entries by these ids only.
"""

from __future__ import annotations

from leakref._base import LeakrefError
from leakref.cases import CASES, Configuration
from leakref.golden.vectors import VECTORS
from leakref.methods import METHODS

__all__ = ["CERTIFIED", "configuration_of", "ensemble_id", "ids", "realization_id"]

CERTIFIED = (0, 1)
"""Realisations of every configuration that are golden one by one."""


def realization_id(c: Configuration, number: int) -> str:
    """The id of one realisation of a configuration.

    Such as `realization-gamma/spread=15,peakedness=7/0`.
    """
    return f"realization-{c.id}/{number}"


def ensemble_id(c: Configuration, window: str, method: str) -> str:
    """The id of the ensemble of a configuration under a window and a method.

    Such as `ensemble-nsp-ls/hann-nsp`.
    """
    return f"ensemble-{c.id}/{window}-{method}"


def _file_of(part: str, name: str) -> str:
    return f"{part}/{name}.json"


def ids(*parts: str) -> dict[str, str]:
    """Every id that can be made, and the file it belongs in.

    `parts` are names of the folders of a set (`sets.SETS`); without any there are none. The order is that of the files.
    """
    found = {
        v.id: _file_of(part, v.stage if part == "vectors" else "windows")
        for part, vectors in VECTORS.items()
        for v in vectors
        if part in parts
    }
    for c in (c for members in CASES.values() for c in members):
        if "realizations" in parts:
            found |= {realization_id(c, n): _file_of("realizations", c.case) for n in CERTIFIED}
        if "ensembles" in parts:
            found |= {ensemble_id(c, w, m): _file_of("ensembles", c.case) for w in c.windows for m in METHODS}
    return found


def configuration_of(identifier: str) -> Configuration:
    """The configuration that the id of a realisation or an ensemble names.

    Raises LeakrefError for an id that names none.
    """
    name = identifier.partition("-")[2].rpartition("/")[0]
    for members in CASES.values():
        for c in members:
            if c.id == name:
                return c
    raise LeakrefError("golden", f"{identifier!r} names no configuration of the paper", "ids are in the manifest")
