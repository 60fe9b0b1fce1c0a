"""What the right codes have in common: reading a cube, a spectrum, a shell, the overlap, a straight fit.

A spectrum holds omega >= 0, where a wave stands at its own (+k, +omega); the other half is its mirror image.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import fft
from scipy.optimize import minimize

COSINES = {"box": (1.0,), "hann": (0.5, -0.5), "blackman": (0.42, -0.5, 0.08)}


@dataclass(frozen=True)
class Spectrum:
    """Power (m, nw) at kx, ky (m,) and omega (nw,), all widths of bins, and numbers of samples (nx, ny, nt)."""

    kx: np.ndarray
    ky: np.ndarray
    omega: np.ndarray
    power: np.ndarray
    widths: tuple[float, float, float]
    shape: tuple[int, int, int]

    @property
    def k(self):
        return np.hypot(self.kx, self.ky)

    @property
    def dk(self):
        return max(self.widths[:2])

    @property
    def domega(self):
        return self.widths[2]

    @property
    def once(self):
        """1/2 for the frequencies that are their own mirror image, (nw,)."""
        own = (np.arange(self.omega.size) == 0) | (2 * np.arange(self.omega.size) == self.shape[2])
        return np.where(own, 0.5, 1.0)

    def shell(self, wavenumber, half_width=2.0):
        """The bins within half_width bins of a wavenumber."""
        near = np.abs(self.k - wavenumber) <= (half_width + 1e-9) * self.dk
        return replace(self, kx=self.kx[near], ky=self.ky[near], power=self.power[near])

    def reaches(self, wavenumber):
        """Whether it is below Nyquist's on both axes, and something is there."""
        return wavenumber < min(n // 2 * w for n, w in zip(self.shape, self.widths[:2], strict=False))

    def points(self):
        """kx, ky, omega and power of all bins, both halves, on the one branch omega0 + k.c: (4, 2 m nw)."""
        kx, ky = (np.repeat(component, self.omega.size) for component in (self.kx, self.ky))
        omega, power = np.tile(self.omega, self.kx.size), self.power.ravel()
        return np.stack([np.r_[kx, -kx], np.r_[ky, -ky], np.r_[omega, -omega], np.r_[power, power]])


def read(surface):
    eta = np.array(surface, dtype=float)
    if not np.isfinite(eta).all():
        raise ValueError("the cube holds NaN or infinity")
    return eta


def cosines(name, size):
    return sum(a * np.cos(2 * np.pi * j * np.arange(size) / size) for j, a in enumerate(COSINES[name]))


def spectrum_of(eta, spacing, tapers):
    """Of a cube times one window for each axis."""
    eta = eta * tapers[0][:, None, None] * tapers[1][:, None] * tapers[2]
    widths = tuple(2 * np.pi / (n * d) for n, d in zip(eta.shape, spacing, strict=True))
    nx, ny, nt = eta.shape
    values = fft.rfftn(eta)  # at (-k, +omega), since forward in time as well
    kx, ky = np.meshgrid(
        -np.fft.fftfreq(nx, 1 / nx) * widths[0], -np.fft.fftfreq(ny, 1 / ny) * widths[1], indexing="ij"
    )
    omega = np.arange(nt // 2 + 1) * widths[2]
    power = (np.abs(values) ** 2).reshape(-1, omega.size)
    return Spectrum(kx.ravel(), ky.ravel(), omega, power, widths, eta.shape)


def overlap_in(shell, gravity, width, magnitude=None, weight=None):
    """N(c) of a shell for a velocity (2,); the magnitude is the root of the power where none is given."""
    weight = shell.once if weight is None else weight
    magnitude = np.sqrt(shell.power) if magnitude is None else magnitude
    total, weighted, intrinsic = (magnitude * weight).sum(), magnitude * weight, np.sqrt(gravity * shell.k)[:, None]

    def overlap(velocity):
        shift = (shell.kx * velocity[0] + shell.ky * velocity[1])[:, None]
        near = [np.exp(-2 * ((shell.omega - shift + sign * intrinsic) / width) ** 2) for sign in (-1, 1)]
        both = near[0] + near[1]
        return (both * weighted).sum() / ((both * weight).sum() * total + 1e-300) * weight.sum() * len(both)

    return overlap


def climb(overlap, unit, start=(0.0, 0.0), step=1e-3):
    """The maximum next to a start, by Nelder and Mead in units of a speed."""
    simplex = np.array(start) / unit + step * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    options = {"initial_simplex": simplex, "xatol": 1e-7, "fatol": 1e-13, "maxfev": 2000}
    return unit * minimize(lambda c: -overlap(unit * c), simplex[0], method="Nelder-Mead", options=options).x


def straight_fit(kx, ky, doppler, weight=1.0):
    """The velocity of least squares, (2,), or None where the wave vectors lie on one line."""
    k = np.stack([kx, ky])
    normal = (k * weight) @ k.T
    if np.linalg.det(normal) <= 1e-9 * np.trace(normal) ** 2:
        return None
    return np.linalg.solve(normal, (k * weight) @ doppler)


def strong_fit(shell, gravity, share=0.2):
    """A first guess: least squares over the strong bins with omega >= 0."""
    at, m = np.nonzero(shell.power >= share * shell.power.max(initial=0.0))
    return straight_fit(shell.kx[at], shell.ky[at], shell.omega[m] - np.sqrt(gravity * shell.k[at]))


def gated(shell, gravity, velocity, gate, share):
    """kx, ky, Doppler shift and power of bins of both halves near the branch at a velocity, and above a share of the
    largest power: (4, n)."""
    kx, ky, omega, power = shell.points()
    doppler = omega - np.sqrt(gravity * np.hypot(kx, ky))
    near = np.abs(doppler - kx * velocity[0] - ky * velocity[1]) <= gate * shell.domega
    return np.stack([kx, ky, doppler, power])[:, near & (power >= share * power.max(initial=0.0))]
