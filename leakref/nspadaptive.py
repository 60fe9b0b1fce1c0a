"""The normalized scalar product with a width that grows with the group velocity, one for each shell.

N(c) is that of `nsp` (eq:normSp with eq:DSVkernel), and so is the search. But what leaks along k by a bin is seen off
the dispersion surface by cg dk, as what leaks along omega is by domega. So the width of G in rad per time is

    a(k) = 4 sqrt(domega^2 + (cg(k) dk)^2),

cg = d omega0 / d k the group velocity in still water at the shell's own wavenumber, in lengths per time, and dk and
domega the widths of a bin in rad per length and per time. Where cg dk is nothing beside domega that is the paper's own.

A possible improvement by the paper's own words (app:numdetails): an a that increases with |d omega / d k|. How it does
is left open there: decision D36. Weichert, Smeltzer and Ellingsen 2023, doi 10.48550/arXiv.2311.01265.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref import nsp
from leakref._base import positive
from leakref.dispersion import Water, law, velocity_unit
from leakref.grid import Grid
from leakref.shell import HALF_WIDTH, Extraction, Note, checked_wavenumbers, collect, shell_at
from leakref.spectrum import Spectrum

__all__ = ["METHOD", "extract", "spread"]


def spread(grid: Grid, water: Water, wavenumber: float) -> float:
    """By how much a(k) exceeds that of `nsp`: sqrt(1 + (cg dk / domega)^2), at `wavenumber` in rad per length."""
    along_k = float(water.group_velocity(wavenumber)) * grid.wavenumber_resolution
    return float(np.hypot(1.0, along_k / grid.frequency_resolution))


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
    """Doppler shift velocities, one for each wavenumber (n,). Raises LeakrefError.

    All as in `nsp.extract`, but that `width` stands for the 4 above.
    """
    call, grid = "nspadaptive.extract", spectrum.grid
    k = checked_wavenumbers(wavenumbers, call)
    peak = {} if peak_wavenumber is None else {"peak_wavenumber": peak_wavenumber}
    positive(call, width=width, half_width=half_width, **peak)
    a, law_ = width * grid.frequency_resolution, law(call, gravity, water)
    shell = partial(shell_at, spectrum, water=law_, half_width=half_width)
    unit = partial(velocity_unit, water=law_, peak_wavenumber=peak_wavenumber)
    found = [nsp.optimum(shell(k_i), a * spread(grid, law_, k_i), unit(k_i), search=search) for k_i in k]
    return collect("nsp-adaptive", k, found)


METHOD: dict[str, Any] = {
    "id": "nsp-adaptive", "title": "NSP, adaptive width", "words": "normalized scalar product of adaptive width",
    "extract": extract, "settings": {"peak_wavenumber": None, "width": nsp.WIDTH, "search": True},
    "score": nsp.normalized_scalar_product, "spread": spread, "silences": Note.NO_SIGNAL | Note.UNCONVERGED,
    "errs_with_the_sea": False, "backwards": True,
}  # fmt: skip
"""The record of the register (`methods`)."""
