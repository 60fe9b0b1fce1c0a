"""The methods by which a velocity is found in a shell, a record each. A new one is its own file and a word here.

Whoever treats methods differently asks the record: nobody else compares a name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from leakref import leastsquares, lsiterative, nsp, nspadaptive, nspgrid, pcs
from leakref._base import FloatArray, LeakrefError
from leakref.dispersion import Water
from leakref.grid import Grid
from leakref.shell import Extraction, Note, Optimum, Shell

__all__ = ["DEFAULT", "METHODS", "Method", "method"]


@dataclass(frozen=True)
class Method:
    """How velocities are found: `extract(spectrum, wavenumbers, *, water, half_width, **settings)`, as in `nsp`.

    `title` and `words` name it in figures and in prose; `settings` are those it takes beside the shell's, with their
    defaults. `score(shell, velocity, width)` says how good any velocity is, higher being better, if the method
    maximises something; `spread(grid, water, wavenumber)` by how much its width is more than that of `nsp`;
    `optimum(shell, **settings)` finds it where the shell is all that counts. Beside `silences` there is never a number.
    What certify allows: `errs_with_the_sea`, where the error in one sea may well exceed the resolution, so that others
    are allowed what the reference errs by; `backwards`, whether it can see waves that a current sweeps backwards;
    `exact_on_bins`, whether waves on bins give the current, untapered, whatever weights and shell it is made with.
    """

    id: str
    title: str
    words: str
    extract: Callable[..., Extraction]
    settings: Mapping[str, object]
    score: Callable[[Shell, FloatArray, float], float] | None = None
    silences: Note = Note.NO_SIGNAL
    errs_with_the_sea: bool = True
    backwards: bool = False
    exact_on_bins: bool = False
    spread: Callable[[Grid, Water, float], float] = field(default_factory=lambda: lambda *_: 1.0)
    optimum: Callable[..., Optimum] | None = None


METHODS = {record.id: record for record in (
    Method("nsp", "NSP", "normalized scalar product", nsp.extract,
           {"peak_wavenumber": None, "width": nsp.WIDTH, "search": True}, nsp.normalized_scalar_product,
           Note.NO_SIGNAL | Note.UNCONVERGED, errs_with_the_sea=False, backwards=True),
    Method("ls", "LS", "least squares", leastsquares.extract, {"threshold": leastsquares.THRESHOLD}, None,
           Note.NO_SIGNAL | Note.UNCONVERGED | Note.TOO_FEW_BINS, exact_on_bins=True),  # omega >= 0 only (decision D19)
    *(Method(**module.METHOD) for module in (nspgrid, nspadaptive, pcs, lsiterative)),
)}  # fmt: skip
"""Every method by id."""
DEFAULT = ("nsp", "ls")
"""The paper's own, which are meant where nothing is said."""


def method(name: str, call: str) -> Method:
    """The record of a method, or LeakrefError."""
    if name not in METHODS:
        raise LeakrefError(call, f"no method named {name!r}", f"choose one of {', '.join(METHODS)}")
    return METHODS[name]
