"""A flight: a configuration whose area need not be square, with its own sampling, and what it costs to simulate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from leakref._base import FloatArray
from leakref.cases import SHELLS, Configuration
from leakref.chain import shell_wavenumbers
from leakref.grid import SPACING, TIME_STEP, Grid
from leakref.shell import EDGE_MARGIN, HALF_WIDTH

__all__ = ["Flight", "default_realizations", "work"]

_ENOUGH, _LEAST, _USUAL = 20e6, 8, 30  # bins in all realisations together; realisations at least, and at most


@dataclass(frozen=True)
class Flight(Configuration):
    """A configuration whose area need not be square and whose sampling is its own, in scaled units.

    `sides` of the area and `pixel` in peak wavelengths, `frame` between two images in peak periods; `length` is the
    longer side, which sets the lattice of the waves. Sides and duration are kept, samples are fitted into them.

    The product of sides and duration decides the cost (`work`). It has the same waves as a paper case with this length.
    """

    sides: tuple[float, float] = (10.0, 10.0)
    pixel: float = SPACING
    frame: float = TIME_STEP

    @cached_property
    def grid(self) -> Grid:
        """Samples at the nearest spacing that divides the sides and the duration."""
        nx, ny = (round(side / self.pixel) for side in self.sides)
        nt = round(self.duration / self.frame)
        dx, dy = (2 * np.pi * side / max(n, 1) for side, n in zip(self.sides, (nx, ny), strict=True))
        return Grid((nx, ny, nt), (dx, dy, 2 * np.pi * self.duration / max(nt, 1)))

    @property
    def wavenumbers(self) -> FloatArray:
        """Those of the paper's shells (decision D9) that lie within the Nyquist wavenumber, (n,)."""
        k, dk = shell_wavenumbers(self.grid, *SHELLS), self.grid.wavenumber_resolution
        return k[k + HALF_WIDTH * dk < min(self.grid.nyquist[:2]) * (1 - EDGE_MARGIN)]


def work(flight: Flight) -> float:
    """Bins of the spectrum that one realisation needs: what its time and memory are proportional to. The spectrum is
    needed up to 3.9 `k0`, at half of the frequencies: pi 3.9^2 times the area, times half the frames.
    """
    x, y = flight.sides
    return float(np.pi * 3.9**2 * x * y * flight.duration / flight.frame / 2)


def default_realizations(flight: Flight) -> int:
    """As many as take seconds: 30 of the paper's L = 10, T = 20, and at least 8 whatever the size."""
    return int(np.clip(_ENOUGH / work(flight), _LEAST, _USUAL))
