"""The normalized scalar product from the best point of a lattice of velocities, in place of zero current.

N(c) is that of `nsp` (eq:normSp with eq:DSVkernel, a = 4 domega; domega is the width of a bin in rad per time). Of the
velocities

    c = c0 (i / 10, j / 10),    i, j = -10 ... 10,    |c| within `nsp.score_range`,

the one with the largest N is where Nelder-Mead starts, and from there all is as in `nsp`. c0 is the phase velocity at
the peak (`dispersion.velocity_unit`), velocities are in lengths per time.

The public code of the paper's co-author (B. K. Smeltzer, Current_Inversion_NTNU), which starts its simplex at the best
of -1 ... 1 m/s in steps of 0.1 m/s; of its score see Smeltzer, Aesoy, Adnoy and Ellingsen 2019, doi
10.1029/2019JC015202. What is open in it is in decision D35.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import nsp
from leakref._base import FloatArray, positive
from leakref.dispersion import Water, law, velocity_unit
from leakref.shell import HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers, collect, nothing, shell_at
from leakref.spectrum import Spectrum

__all__ = ["LATTICE", "METHOD", "SAME", "WORTH", "extract", "optimum", "slowest", "start"]

LATTICE: FloatArray = np.stack(np.meshgrid(*2 * [np.arange(-10, 11) / 10], indexing="ij"), axis=-1).reshape(-1, 2)
"""Velocities in c0, (441, 2)."""
SAME = 1e-9
"""Relative: scores as near are equal, and of such the slowest velocity counts, the first of several (decision D35)."""
WORTH = 0.7
"""Of the best tabulated score, which is good to some percent: what is below is not looked at closely."""


def start(shell: Shell, width: float, unit: float) -> FloatArray:
    """Where the search starts, in c0 (2,): the best point of the lattice. `width` is a, `unit` c0."""
    lattice = LATTICE[np.hypot(*LATTICE.T) * unit <= nsp.score_range(shell, width, unit)]
    if not len(lattice):
        return np.zeros(2)
    table = nsp.tabulated(shell, lattice * unit, width)
    lattice = lattice[table >= WORTH * table.max()]
    return slowest(lattice, np.array([nsp.normalized_scalar_product(shell, c, width) for c in lattice * unit]))


def slowest(lattice: FloatArray, scores: FloatArray) -> FloatArray:
    """Of the velocities (n, 2) with the best of the `scores` (n,) the slowest."""
    best = lattice[scores >= scores.max() * (1 - SAME)]
    first: FloatArray = best[np.hypot(*best.T).round(9).argmin()]
    return first


def optimum(shell: Shell, width: float, unit: float, *, search: bool = True) -> Optimum:
    """As `nsp.optimum`, from `start`."""
    if shell.is_empty:
        return nothing(Note.NO_SIGNAL)
    return nsp.optimum(shell, width, unit, search=search, start=start(shell, width, unit))


def extract(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    peak_wavenumber: float | None = None,
    width: float = nsp.WIDTH,
    half_width: float = HALF_WIDTH,
    search: bool = True,
) -> Extraction:
    """Doppler shift velocities, one for each wavenumber (n,); all as in `nsp.extract`. Raises LeakrefError."""
    k = checked_wavenumbers(wavenumbers, "nspgrid.extract")
    peak = {} if peak_wavenumber is None else {"peak_wavenumber": peak_wavenumber}
    positive("nspgrid.extract", width=width, half_width=half_width, **peak)
    a, water = width * spectrum.grid.frequency_resolution, law("nspgrid.extract", gravity, water)
    shell = partial(shell_at, spectrum, water=water, half_width=half_width)
    found = [optimum(shell(k_i), a, velocity_unit(k_i, water, peak_wavenumber), search=search) for k_i in k]
    return collect("nsp-grid", k, found)


METHOD: dict[str, Any] = {
    "id": "nsp-grid", "title": "NSP, lattice start", "words": "normalized scalar product from a lattice",
    "extract": extract, "settings": {"peak_wavenumber": None, "width": nsp.WIDTH, "search": True},
    "score": nsp.normalized_scalar_product, "silences": Note.NO_SIGNAL | Note.UNCONVERGED, "errs_with_the_sea": False,
    "backwards": True,
}  # fmt: skip
"""The record of the register (`methods`)."""
