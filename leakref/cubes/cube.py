"""A cube: samples of a surface on a grid, with what is known about them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from leakref._base import FloatArray, vector
from leakref.cubes.asked import Assumed, in_words
from leakref.dispersion import Water
from leakref.grid import Grid
from leakref.sea import Components

__all__ = ["UNITS", "Cube"]

UNITS = {"si": "m/s", "scaled": "c0", "given": "the file's units of length / time"}
"""Of a velocity, by the units a file states: SI, the paper's scaled ones (k0 = omega0 = g = 1), or nothing."""


@dataclass(frozen=True)
class Cube:
    """A surface eta[x, y, t] (array, or memory-mapped) on `grid`, and what its file says about it.

    `units`: "si", "scaled" or "given" (the file does not say). `components` and `current` (2,) are the truth, if the
    file has it. `notes` say what was done to the samples on the way.

    - `surface`: (nx, ny, nt), float64, or the type in the file if it is memory-mapped.
    - `gravity`, `depth` (infinite in deep water) and `surface_tension` over density: in the units of length and time
      of the grid.
    - `peak_wavenumber`: rad per length, None if the file does not say.
    - `lost_frames`: how many seem to be lost, by how the waves move on, though the file does not say so.
    - `components`, `current`: None without a truth; the current is along x and y, going to.
    - `assumed`: what was taken for granted when the file was read, None for a cube that comes from no file.

    A current that is not two finite numbers is refused with a LeakrefError, as are a gravity, depth or tension that are
    none.
    """

    surface: Any
    grid: Grid
    gravity: float
    units: str = "given"
    components: Components | None = None
    current: FloatArray | None = None
    peak_wavenumber: float | None = None
    notes: tuple[str, ...] = ()
    assumed: Assumed | None = None
    depth: float = np.inf
    surface_tension: float = 0.0
    lost_frames: int = 0

    def __post_init__(self) -> None:
        if self.current is not None:
            vector("Cube", current=self.current)
        _ = self.water

    @cached_property
    def water(self) -> Water:
        """The law of dispersion in which its waves are looked for."""
        return Water(self.gravity, self.depth, self.surface_tension)

    @property
    def water_words(self) -> str:
        """Its depth and surface tension, for lines and titles."""
        return in_words(self.depth, self.surface_tension, self.units)
