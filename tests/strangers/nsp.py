"""The normalised scalar product of Weichert, Smeltzer and Ellingsen (arXiv 2311.01265), written from the paper alone.

Metres and seconds, a cube eta[x, y, t]. The transform is real and forward along all three axes, so that a wave
cos(k.x - omega t), omega > 0, is seen at (-k, +omega): the wavenumbers are given the opposite sign instead.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft
from scipy.optimize import minimize

WINDOWS = {"box": (1.0, 0.0), "hann": (0.5, 0.5)}
SHELL_HALF_WIDTH = 2.0  # in bins, appendix A 1
GAUSSIAN_WIDTH = 4.0  # a, in bins, appendix A 2
EDGE = 1 + 1e-9  # a bin on the edge of a shell belongs to it, however it was rounded
FIRST_STEP = 1e-3  # of the phase speed: a search that begins with long steps leaps over the nearest maximum
TOLERANCE = 1e-7


@dataclass
class Spectrum:
    """Magnitude |FFT| (m, nw) at wave vectors (m,) and frequencies (nw,) >= 0, and the widths of bins."""

    kx: np.ndarray
    ky: np.ndarray
    omega: np.ndarray
    magnitude: np.ndarray
    weight: np.ndarray
    dk: float
    domega: float
    k_nyquist: float

    @property
    def k(self):
        return np.hypot(self.kx, self.ky)


def cosine_window(name, size):
    """Periodic: sample j is at j / size of the window's length (eq:hann)."""
    mean, swing = WINDOWS[name]
    phase = 2 * np.pi * np.arange(size) / size
    return mean - swing * np.cos(phase)


def signed(size):
    """0, 1, ..., -2, -1: the numbers of bins in the order of the transform."""
    number = np.arange(size)
    return np.where(number < (size + 1) // 2, number, number - size)


def transformed(surface, spacing, window):
    eta = np.array(surface, dtype=float)
    if not np.isfinite(eta).all():
        raise ValueError("the surface has gaps (NaN or infinity): fill them first")
    nx, ny, nt = eta.shape
    dx, dy, dt = spacing
    length_x, length_y, duration = nx * dx, ny * dy, nt * dt
    dkx, dky, domega = 2 * np.pi / length_x, 2 * np.pi / length_y, 2 * np.pi / duration
    eta *= cosine_window(window, nx)[:, None, None]
    eta *= cosine_window(window, ny)[None, :, None]
    eta *= cosine_window(window, nt)[None, None, :]
    bins = fft.rfftn(eta)
    power = np.abs(bins) ** 2
    kx = -dkx * signed(nx)
    ky = -dky * signed(ny)
    omega = domega * np.arange(nt // 2 + 1)
    weight = np.ones(omega.size)  # of the half space: every bin stands for two, but for omega = 0 and Nyquist's
    weight[0] = 0.5
    weight[-1] = 0.5 if nt % 2 == 0 else 1.0
    kx, ky = (component.ravel() for component in np.meshgrid(kx, ky, indexing="ij"))
    magnitude = np.sqrt(power).reshape(kx.size, omega.size)
    nyquist = np.pi / max(dx, dy)
    return Spectrum(kx, ky, omega, magnitude, weight, max(dkx, dky), domega, nyquist)


def overlap_of_shell(spectrum, wavenumber, gravity):
    """The function N(c) (eq:normSp) of one shell; None where there is nothing to fit."""
    half_width = SHELL_HALF_WIDTH * spectrum.dk
    ring = np.abs(spectrum.k - wavenumber) <= half_width * EDGE
    k, kx, ky = spectrum.k[ring], spectrum.kx[ring], spectrum.ky[ring]
    magnitude = spectrum.magnitude[ring] * spectrum.weight
    if wavenumber > spectrum.k_nyquist or magnitude.sum() == 0:
        return None
    omega = spectrum.omega[None, :]
    intrinsic = np.sqrt(gravity * k)
    width = GAUSSIAN_WIDTH * spectrum.domega

    def overlap(velocity):
        u, v = velocity
        shift = kx * u + ky * v
        waves = np.exp(-2 * ((omega - (intrinsic + shift)[:, None]) / width) ** 2)
        mirrored = np.exp(-2 * ((omega + (intrinsic - shift)[:, None]) / width) ** 2)  # of a real signal
        characteristic = waves + mirrored
        mean = (characteristic * spectrum.weight).mean() * magnitude.mean()
        return (characteristic * magnitude).mean() / mean if mean > 0 else 0.0

    return overlap


def best_velocity(overlap, unit):
    """Nelder-Mead from still water, in units of `unit`."""
    start = np.array([[0.0, 0.0], [FIRST_STEP, 0.0], [0.0, FIRST_STEP]])
    options = {"initial_simplex": start, "xatol": TOLERANCE, "fatol": 1e-13, "maxfev": 2000}
    found = minimize(lambda c: -overlap(unit * c), start[0], method="Nelder-Mead", options=options)
    return unit * found.x


class Extractor:
    def describe(self):
        can = {"extract": {"methods": ["nsp"], "windows": ["box", "hann"]}}
        return {"name": "stranger, NSP", "version": "1", "units": "si", "can": can}

    def extract(self, surface, spacing, wavenumbers, *, gravity, window):
        spectrum = transformed(surface, spacing, window)
        velocities = []
        for wavenumber in np.asarray(wavenumbers, dtype=float):
            overlap = overlap_of_shell(spectrum, wavenumber, gravity)
            if overlap is None:
                velocities.append(None)
                continue
            phase_speed = np.sqrt(gravity / wavenumber)
            east, north = best_velocity(overlap, phase_speed)
            velocities.append([east, north])
        return velocities
