"""The spectrum and its sign: route A, by the fast Fourier transform.

Of a surface eta at positions x (lengths) and times t the spectrum is, with the weights w of a window,

    S(k, omega) = sum over all samples of w eta exp(-i (k.x - omega t)), and its power P = |S|^2:

a wave cos(k.x - omega t) appears at its own k (rad per length) and omega (rad per time), and mirrored at (-k, -omega).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import fft

from leakref._base import ComplexArray, FloatArray, IntArray, LeakrefError, finite
from leakref.grid import Grid
from leakref.window import window as named_window

__all__ = ["Spectrum", "fourier"]


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The transform of a tapered surface: a wave is at its own (+k, +omega).

    `values` is complex (len(i), len(j), nt // 2 + 1), unnormalised, at bins `i` along kx, `j` along ky (signed
    numbers, any subset) and 0 ... nt // 2 along omega: the half omega >= 0 says all of a real signal.
    """

    grid: Grid
    window: str
    i: IntArray
    j: IntArray
    values: ComplexArray

    @property
    def kx(self) -> FloatArray:
        """Wavenumbers of the bins along x, (len(i),)."""
        return self.i * self.grid.bin_widths[0]

    @property
    def ky(self) -> FloatArray:
        """Wavenumbers of the bins along y, (len(j),)."""
        return self.j * self.grid.bin_widths[1]

    @property
    def omega(self) -> FloatArray:
        """Frequencies of the bins, (nt // 2 + 1,), from 0 to the Nyquist frequency."""
        return self.grid.bins(2) * self.grid.frequency_resolution

    @property
    def half_weight(self) -> FloatArray:
        """What a bin of the half space counts for in a sum over the whole one, halved (decision D5)."""
        m = self.grid.bins(2)
        return np.where((m == 0) | (2 * m == self.grid.shape[2]), 0.5, 1.0)

    @cached_property
    def strongest(self) -> tuple[float, tuple[int, int, int]]:
        """The largest |S| and the bin numbers (i, j, m) where it is."""
        peaks = [np.abs(plane).max() for plane in self.values]  # plane by plane: no second copy of it all
        a = int(np.argmax(peaks))
        b, m = np.unravel_index(np.argmax(np.abs(self.values[a])), self.values.shape[1:])
        return float(peaks[a]), (int(self.i[a]), int(self.j[b]), int(m))

    def whole(self) -> ComplexArray:
        """Both halves: (nx, ny, nt) in the order of numpy's fftfreq, ascending in +k, +omega."""
        if self.values.shape[:2] != self.grid.shape[:2]:
            fault = f"only {self.values.shape[:2]} of {self.grid.shape[:2]} bins are here"
            raise LeakrefError("Spectrum.whole", fault, "make the spectrum with all its bins")
        nt = self.grid.shape[2]
        mirrored = np.conj(self.values[np.ix_(-self.i, -self.j)])[:, :, nt - nt // 2 - 1 : 0 : -1]
        half = self.values[:, :, : nt - nt // 2]
        nyquist = self.values[:, :, nt // 2 : nt // 2 + 1 - nt % 2]  # of even nt; fftfreq counts it as negative
        return np.concatenate([half, nyquist, mirrored], axis=2)


def fourier(
    surface: npt.ArrayLike, grid: Grid, window: str = "hann", *, workers: int | None = None, **sampling: Any
) -> Spectrum:
    """Taper and transform a surface eta[x, y, t] of shape `grid.shape`: the spectrum on all bins (sec:leakage).

    A forward transform in time would put a wave at (k, -omega); taking the conjugate between the
    transforms of time and space makes it exp(+i omega t). `workers` threads (default: all); `sampling` goes to
    Window.samples. The surface is not touched. Raises LeakrefError for a wrong shape or samples not finite.
    """
    eta = finite("fourier", "surface", surface, 3)
    if eta.shape != grid.shape:
        remedy = "pass the grid the surface was sampled on, axes in the order x, y, t"
        raise LeakrefError("fourier", f"the surface has shape {eta.shape}, the grid {grid.shape}", remedy)
    wx, wy, wt = (named_window(window).samples(n, **sampling) for n in grid.shape)
    threads = -1 if workers is None else workers
    tapered = eta * wt
    tapered *= (wx[:, None] * wy)[:, :, None]
    values = fft.rfft(tapered, axis=2, workers=threads)
    del tapered
    np.conj(values, out=values)
    values = fft.fft2(values, axes=(0, 1), workers=threads, overwrite_x=True)
    return Spectrum(grid, window, grid.bins(0), grid.bins(1), values)
