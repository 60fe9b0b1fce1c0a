"""The spectrum without a surface: route B, the closed form of spectral leakage (sec:leakage).

A wave a cos(kx x + ky y - omega t + phase), sampled nx, ny and nt times and tapered, is in the transform at bin (i, j,
m)

    S = a / 2 exp(i phase) W(i - kx / dkx, nx) W(j - ky / dky, ny) conj W(m - omega / domega, nt) + its mirror image,

where W(v, n) = sum over s = 0 ... n - 1 of w(s) exp(-2 pi i s v / n) is the response of the window w,
`Window.response`, and the mirror image is the same wave at (-k, -omega) with phase -phase. For the box W is the
Dirichlet kernel, whose tails fall like 1 / v: that is the leakage. kx, ky in rad per length, omega in rad per time,
their bins dkx, dky, domega.
"""

from __future__ import annotations

import numpy as np

from leakref._base import ComplexArray, FloatArray, IntArray, positive
from leakref.grid import Grid
from leakref.sea import Components
from leakref.spectrum import Spectrum
from leakref.window import Window
from leakref.window import window as named_window

__all__ = ["spectrum"]

_BUFFER = 2**21  # complex numbers in a block of the kernels along omega


def spectrum(
    components: Components, grid: Grid, window: str = "hann", *, largest_wavenumber: float | None = None
) -> Spectrum:
    """The spectrum of `components` sampled on `grid`, exactly, from the kernels of its waves (sec:NSP_and_leakage).

    The transform of a finite plane wave is the product of three responses of the window, one an axis; a sum
    over waves on a lattice is then, for each frequency, `Rx A Ry^T` with A the amplitudes times the response
    along omega. What the FFT of the synthesised surface gives (route A), to rounding. Only bins with
    |kx|, |ky| <= `largest_wavenumber` (default: all) are computed.
    """
    taper = named_window(window)
    if largest_wavenumber is not None:
        positive("leakage.spectrum", largest_wavenumber=largest_wavenumber)
    i, j = (_within(grid, axis, largest_wavenumber) for axis in (0, 1))
    lattice = components.separated()
    kx, ix, ky, iy = lattice if lattice is not None else (components.kx, None, components.ky, None)
    rx, rx_mirror = _responses(taper, grid, 0, i, kx)
    ry, ry_mirror = _responses(taper, grid, 1, j, ky)
    wave = components.amplitude / 2 * np.exp(1j * components.phase)
    values = np.empty((i.size, j.size, grid.shape[2] // 2 + 1), dtype=np.complex128)
    matrix = np.zeros((kx.size, ky.size), dtype=np.complex128)

    def product(left: ComplexArray, waves: ComplexArray, right: ComplexArray) -> ComplexArray:
        if lattice is None:
            return (left * waves) @ right.T
        matrix[ix, iy] = waves
        return left @ matrix @ right.T if i.size <= j.size else left @ (matrix @ right.T)

    step = max(1, _BUFFER // wave.size)
    for start in range(0, values.shape[2], step):
        m = grid.bins(2)[start : start + step]
        rt, rt_mirror = _responses(taper, grid, 2, m, components.omega)
        for n in range(m.size):  # a cosine is two exponentials: the wave, and its mirror image at (-k, -omega)
            direct = product(rx, wave * rt[n].conj(), ry)
            values[:, :, start + n] = direct + product(rx_mirror, wave.conj() * rt_mirror[n].conj(), ry_mirror)
    return Spectrum(grid, window, i, j, values)


def _within(grid: Grid, axis: int, largest: float | None) -> IntArray:
    bins = grid.bins(axis)
    return bins if largest is None else bins[np.abs(bins) <= largest / grid.bin_widths[axis] + 1e-9]


def _responses(
    taper: Window, grid: Grid, axis: int, bins: IntArray, k: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Kernels of exp(+i k x) and of its mirror exp(-i k x) on the same bins."""
    position, size = k / grid.bin_widths[axis], grid.shape[axis]
    return taper.response(bins, position, size), taper.response(-bins, position, size).conj()
