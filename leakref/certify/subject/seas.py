"""A random sea as a generator is asked for it: parameters in its own units, frame and words.

Generators are told of a sea in many ways, so that every parameter is there in all of them: the energy as a variance and
as a significant height, the peak as a wavenumber, a frequency and a period, the spread as a full width and as a
deviation. A code takes what it knows; what it takes in no form is fixed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from leakref.certify.subject.declaration import Declaration
from leakref.dispersion import Water
from leakref.grid import Grid

__all__ = ["FORMS", "Sea"]

FORMS: Mapping[str, tuple[str, ...]] = {
    "energy": ("variance", "height"),
    "peak": ("peak_wavenumber", "peak_frequency", "peak_period"),
    "peakedness": ("peakedness",),
    "direction": ("direction",),
    "spread": ("spread", "deviation"),
    "current": ("current",),
    "seed": ("seed",),
}
"""The parameters of a sea, and the forms in which each is handed over."""
_DEVIATION = float(np.sqrt(1 / 12 - 1 / (2 * np.pi**2)))  # of the cosine square, in full widths


@dataclass(frozen=True)
class Sea:
    """A JONSWAP sea on a `grid` in scaled units, in the frame of the checks.

    `direction` (going-to) and `spread` (full width of the cosine square) in degrees, `peakedness` gamma, `variance` the
    mean square elevation, `current` uniform, `water` in scaled units.
    """

    grid: Grid
    direction: float
    spread: float
    peakedness: float
    variance: float
    current: tuple[float, float]
    water: Water

    @property
    def deviation(self) -> float:
        """The standard deviation of directions, in degrees."""
        return _DEVIATION * self.spread

    def parameters(self, declared: Declaration, seed: int) -> dict[str, Any]:
        """What is handed over, but for depth and tension: in the units and the frame that are declared."""
        scales = declared.scales()
        length, time = scales.length, scales.time
        down, come_from = declared.y == "down", declared.direction == "from"
        direction = (-self.direction if down else self.direction) + 180 * come_from
        u, v = (component * (-1 if come_from else 1) * length / time for component in self.current)
        peak = float(self.water.frequency(1.0)) / time
        steps = (self.grid.spacing[0] * length, self.grid.spacing[1] * length, self.grid.spacing[2] * time)
        deviation = float(np.sqrt(self.variance)) * length
        return {
            "shape": list(self.grid.shape),
            **dict(zip(("dx", "dy", "dt"), steps, strict=True)),
            "variance": deviation**2,
            "height": 4 * deviation,
            "peak_wavenumber": 1 / length,
            "peak_frequency": peak,
            "peak_period": 2 * np.pi / peak,
            "peakedness": self.peakedness,
            "direction": float((direction + 180) % 360 - 180),
            "spread": self.spread,
            "deviation": self.deviation,
            "current": [u, -v if down else v],
            "gravity": scales.gravity,
            "seed": seed,
        }
