"""Sampling: a box of samples eta[x, y, t] and the bins of its transform.

A grid has nx, ny and nt samples at spacings dx, dy (lengths) and dt (time). Its sides are n d, never (n - 1) d, so that
a wave with a whole number of wavelengths in nx dx lies on a bin: bins are 2 pi / (nx dx) wide in kx, 2 pi / (ny dy) in
ky and 2 pi / (nt dt) in omega. dk, the unit of shells, is the larger of the first two: nothing assumes a square.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leakref._base import FloatArray, IntArray, LeakrefError, finite, integer, positive

__all__ = ["SPACING", "TIME_STEP", "Grid"]

SPACING = 1 / 28
"""Spacing of samples in peak wavelengths (sec:parameters)."""
TIME_STEP = 1 / 14
"""Spacing of samples in peak periods (sec:parameters)."""


@dataclass(frozen=True)
class Grid:
    """Samples at x = i dx, y = j dy, t = m dt. Nothing is square by assumption.

    `shape` is (nx, ny, nt), each at least 2; `spacing` is (dx, dy, dt), positive, in any consistent
    units. Lengths and the duration are n d, never (n - 1) d: the sample after the last is the first
    of the next period. Raises LeakrefError.
    """

    shape: tuple[int, int, int]
    spacing: tuple[float, float, float]

    def __post_init__(self) -> None:
        try:
            shape = tuple(integer("Grid", "shape", n, 2) for n in self.shape)
            if len(shape) != 3:
                raise TypeError
        except (TypeError, LeakrefError):
            fault = f"shape = {self.shape} is not three sizes of at least 2"
            raise LeakrefError("Grid", fault, "give (nx, ny, nt) with two samples or more along every axis") from None
        spacing = finite("Grid", "spacing", self.spacing)
        if spacing.shape != (3,):
            raise LeakrefError("Grid", f"spacing = {self.spacing} is not three numbers", "give (dx, dy, dt)")
        positive("Grid", spacing=spacing)
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "spacing", tuple(spacing.tolist()))

    @classmethod
    def scaled(cls, length: float, duration: float) -> Grid:
        """The paper's square domain in scaled units: `length` L wavelengths, `duration` T periods.

        Spacings are those of sec:parameters, so L = 10, T = 20 has 280 samples along each axis.
        """
        positive("Grid.scaled", length=length, duration=duration)
        nx, nt = round(length / SPACING), round(duration / TIME_STEP)
        dx, dt = 2 * np.pi * length / max(nx, 1), 2 * np.pi * duration / max(nt, 1)
        return cls((nx, nx, nt), (dx, dx, dt))

    @property
    def lengths(self) -> tuple[float, float, float]:
        """Extent n d along x, y and t."""
        nx, ny, nt = self.shape
        dx, dy, dt = self.spacing
        return nx * dx, ny * dy, nt * dt

    @property
    def bin_widths(self) -> tuple[float, float, float]:
        """(dkx, dky, domega) = 2 pi / (n d), rad per unit."""
        x, y, t = self.lengths
        return 2 * np.pi / x, 2 * np.pi / y, 2 * np.pi / t

    @property
    def wavenumber_resolution(self) -> float:
        """dk: the coarser of dkx and dky (decision D20), so that a shell is closed in both directions."""
        return max(self.bin_widths[:2])

    @property
    def frequency_resolution(self) -> float:
        """domega, rad per unit time."""
        return self.bin_widths[2]

    @property
    def nyquist(self) -> tuple[float, float, float]:
        """Nyquist wavenumbers and frequency pi / d."""
        dx, dy, dt = self.spacing
        return np.pi / dx, np.pi / dy, np.pi / dt

    def samples(self, axis: int) -> FloatArray:
        """Coordinates of the samples along x (0), y (1) or t (2)."""
        return np.arange(self.shape[axis]) * self.spacing[axis]

    def bins(self, axis: int) -> IntArray:
        """Signed bin numbers along x (0) or y (1) in the order of the FFT; along t (2) 0 ... nt // 2.

        Of the frequencies only the half with omega >= 0 is kept: P(-k, -omega) = P(k, omega).
        """
        n = self.shape[axis]
        if axis == 2:
            return np.arange(n // 2 + 1)
        return (np.arange(n) + n // 2) % n - n // 2
