"""Tapers and their transforms: what leakage looks like along one axis.

A window is a sum of cosines over the duration T, w(t) = a_0 - a_1 cos(2 pi t / T) + a_2 cos(4 pi t / T) - ... (eq:hann,
equation 6, for Hann's with a = 1/2, 1/2), or Kaiser-Bessel's. What it makes of a wave along one axis is its discrete
transform, W(v, n) = sum over s < n of w(s / n) exp(-2 pi i s v / n), at v bins from the wave: for the box the Dirichlet
kernel, for a sum of cosines a stencil over shifted ones. Everything that leaks is made of this one function.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import i0

from leakref._base import ComplexArray, FloatArray, IntArray, LeakrefError, integer

__all__ = ["KAISER_SHAPE", "WINDOWS", "Window", "dirichlet", "window"]

KAISER_SHAPE = float(np.pi * np.sqrt(3))
"""b of the Kaiser-Bessel window (decision D14): its first zero is then at two bins, as is Hann's."""


def dirichlet(bins: npt.ArrayLike, position: npt.ArrayLike, size: int) -> ComplexArray:
    """sum over m < size of exp(-2 pi i m (n - u) / size), (nb, nc), for bins n (nb,) and positions u (nc,).

    The transform of a wave at u bins, box window (sec:leakage). u is split into its nearest bin and the
    remainder r before anything is subtracted, so that waves within rounding of a bin lose no digits.
    """
    u = np.atleast_1d(np.asarray(position, dtype=np.float64))
    nearest = np.rint(u)
    r = u - nearest
    d = np.atleast_1d(np.asarray(bins))[:, None] - nearest
    d -= size * np.rint(d / size)
    with np.errstate(divide="ignore", invalid="ignore"):
        cot = 1 / np.tan(np.pi * (d - r) / size)
        kernel = -np.exp(1j * np.pi * r) * np.sin(np.pi * r) * (cot + 1j)
    return np.where(r == 0, np.where(d == 0, size, 0), kernel)


@dataclass(frozen=True)
class Window:
    """A taper over one axis: `w(t) = sum of (-1)^j a_j cos(2 pi j t / T)`, or Kaiser-Bessel if no `a` is given.

    `title` is its name in figures.
    """

    name: str
    title: str = ""
    coefficients: tuple[float, ...] = ()

    def samples(self, size: int, *, symmetric: bool = False) -> FloatArray:
        """w at n = 0 ... size - 1, (size,): periodic, n / size (decision D1), or n / (size - 1) if `symmetric`."""
        size = integer("Window.samples", "size", size, 2)
        s = np.arange(size) / (size - 1 if symmetric else size)
        if not self.coefficients:
            return np.asarray(i0(KAISER_SHAPE * np.sqrt(1 - (2 * s - 1) ** 2)) / i0(KAISER_SHAPE))
        return sum(((-1) ** j * a * np.cos(2 * np.pi * j * s) for j, a in enumerate(self.coefficients)), np.zeros(size))

    def _stencil(self) -> list[tuple[int, float]]:
        """The window as weights of bins: its discrete transform has 2 len(a) - 1 lines."""
        one_sided = [(j, (-1) ** j * a / 2) for j, a in enumerate(self.coefficients) if j]
        return [(0, self.coefficients[0]), *one_sided, *((-j, weight) for j, weight in one_sided)]

    def transform(self, offset: npt.ArrayLike) -> FloatArray:
        """The continuous transform at `offset` bins, over the duration, window centred on 0 (fig:leakage_lobes).

        Real: a_0 sinc(v) + sum of a_j / 2 (sinc(v - j) + sinc(v + j)); Kaiser-Bessel in closed form. Not
        normalised: the value at 0 is the mean of the window.
        """
        v = np.asarray(offset, dtype=np.float64)
        if not self.coefficients:
            z = np.sqrt((KAISER_SHAPE**2 - (np.pi * v) ** 2).astype(np.complex128))
            small = np.abs(z) < 1e-6
            return np.asarray(np.where(small, 1.0, (np.sinh(z) / np.where(small, 1.0, z)).real) / i0(KAISER_SHAPE))
        return sum(((-1) ** j * weight * np.sinc(v - j) for j, weight in self._stencil()), np.zeros(v.shape))

    def response(self, bins: npt.ArrayLike, position: npt.ArrayLike, size: int) -> ComplexArray:
        """The discrete transform of a wave at `position` bins (nc,), seen at `bins` (nb,): complex (nb, nc).

        A cosine sum is a stencil over Dirichlet kernels; Kaiser-Bessel is summed numerically (D14).
        """
        n = np.atleast_1d(np.asarray(bins, dtype=np.int64))
        if self.coefficients:
            lines = (weight * dirichlet(n - j, position, size) for j, weight in self._stencil())
            return sum(lines, np.zeros((), np.complex128))
        u = np.atleast_1d(np.asarray(position, dtype=np.float64))
        m = np.arange(size)
        forward = np.exp(-2j * np.pi / size * (np.outer(n, m) % size))
        return np.asarray((forward * self.samples(size)) @ np.exp(2j * np.pi * np.outer(m, u / size)))

    def sidelobe_envelope(self, distance: IntArray, size: int) -> FloatArray:
        """How much of a wave's largest bin can be seen `distance` bins (n,) away, at most; distances wrap at `size`.

        The worst of 33 offsets from the bin, and a tenth more for those in between.
        """
        offsets = np.linspace(-0.5, 0.5, 33)
        seen = np.abs(self.response(distance, offsets, size)) / np.abs(self.response([0], offsets, size))
        return np.where(np.asarray(distance) % size == 0, 1.0, 1.1 * seen.max(axis=1))


WINDOWS = {w.name: w for w in (
    Window("box", "no window", (1.0,)),
    Window("hann", "Hann", (0.5, 0.5)),
    Window("blackman", "Blackman", (0.42, 0.5, 0.08)),
    Window("kaiser-bessel", "Kaiser-Bessel"),
)}  # fmt: skip
"""The windows of the paper by name: eq:hann and app:window_comparison."""


def window(name: str) -> Window:
    """The window of that name. Raises LeakrefError with the list of names."""
    if not isinstance(name, str) or name not in WINDOWS:
        raise LeakrefError("window", f"no window named {name!r}", f"choose one of {', '.join(WINDOWS)}")
    return WINDOWS[name]
