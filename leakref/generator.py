"""A generator of random seas from parameters, and as something that can be judged: the stage `sea` of the protocol.

The seas of the chain are lists of waves (`sea.SeaState`), so that what is right is known wave by wave. Many generators
take no such list; this one is theirs in short, with the law of `sea` (eq:JONSWAP, eq:angularspread, eq:amplitudes).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from leakref._base import FloatArray, LeakrefError, positive
from leakref.dispersion import DEEP, Scales, Water
from leakref.grid import Grid
from leakref.sea import LARGEST_WAVENUMBER, Components, directional_spreading, jonswap, uniform_phases
from leakref.synthesis import synthesize

__all__ = ["Generator", "generator", "random_sea"]


def random_sea(
    grid: Grid,
    seed: int,
    *,
    variance: float,
    peak_wavenumber: float,
    peakedness: float = 3.3,
    direction: float = 0.0,
    spread: float = 60.0,
    current: Sequence[float] = (0.0, 0.0),
    water: Water = DEEP,
) -> Components:
    """A JONSWAP sea from parameters, its waves on the bins of a `grid` up to 3.5 times the peak's wavenumber.

    `variance` is the mean square elevation, which the waves hold together; phases are uniform and follow from the
    `seed` alone, amplitudes are those of the spectrum. Lengths, `current` (2,) and `water` are in one system of units,
    `direction` (going-to) and `spread` (full width) in degrees. Raises LeakrefError where no bin lies within it.
    """
    positive("random_sea", variance=variance, peak_wavenumber=peak_wavenumber, peakedness=peakedness, spread=spread)
    i, j = (index.ravel() for index in np.meshgrid(*(np.arange(-((n - 1) // 2), (n + 1) // 2) for n in grid.shape[:2])))
    kx, ky = i * grid.bin_widths[0], j * grid.bin_widths[1]
    k, f = np.hypot(kx, ky), directional_spreading(np.degrees(np.arctan2(ky, kx)), direction, spread)
    inside = (k > 0) & (k <= LARGEST_WAVENUMBER * peak_wavenumber) & (f > 0)
    i, j, kx, ky, k, f = (values[inside] for values in (i, j, kx, ky, k, f))
    if not k.size:
        raise LeakrefError("random_sea", f"no bin within {spread} degrees", "widen the spread or enlarge the grid")
    scales = Scales(peak_wavenumber, water.gravity)
    still, scaled = water.to_scaled(scales), k / peak_wavenumber
    density = jonswap(still.frequency(scaled) / still.frequency(1.0), peakedness) * still.depth_factor(scaled)
    energy = still.density_factor(scaled) * density * f
    energy *= variance / energy.sum()
    omega = water.frequency(k) + kx * current[0] + ky * current[1]
    phase = uniform_phases(seed, i, j)
    return Components(kx, ky, omega, np.sqrt(2 * energy), phase)


class Generator:
    """leakref's own random seas as something that can be judged: the stage `sea` and no other."""

    def describe(self) -> Mapping[str, object]:
        """What it declares of itself (guide protocol, section 3): no amplitude is drawn."""
        from leakref import __version__

        return {"name": "leakref's seas", "version": __version__, "can": {"sea": {"amplitudes": "fixed"}}}

    def sea(self, shape: tuple[int, int, int], spacing: tuple[float, float, float], *, variance: float,
            peak_wavenumber: float, peakedness: float, direction: float, spread: float, current: tuple[float, float],
            gravity: float, depth: float, surface_tension: float = 0.0, seed: int) -> FloatArray:  # fmt: skip
        """A surface, (nx, ny, nt)."""
        grid, water = Grid(shape, spacing), Water(gravity, depth, surface_tension)
        waves = random_sea(grid, seed, variance=variance, peak_wavenumber=peak_wavenumber, peakedness=peakedness,
                           direction=direction, spread=spread, current=current, water=water)  # fmt: skip
        return synthesize(waves, *(grid.samples(axis) for axis in range(3)))


generator = Generator()
"""The built-in generator of random seas, `leakref.generator.generator`."""
