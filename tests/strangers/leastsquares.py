"""The least squares of Weichert, Smeltzer and Ellingsen (arXiv 2311.01265, eq:LS1), written from the paper alone.

Metres and seconds, a video movie[t, y, x] with rows counted from the top; velocities are pixels' own, x to the right
and y downwards. The spectrum is that of numpy.fft.fftn brought into ascending order; since its transform is a forward
one in time as well, frequencies are given the opposite sign.
"""

from __future__ import annotations

import numpy as np

SHARE_OF_PEAK = 0.2  # weaker bins are left out
BINS_TO_EITHER_SIDE = 2
ROUNDING = 1e-9
LEAST_DETERMINANT = 1e-9  # of the normal equations, relative: below it the bins lie on one line


def taper(name, n):
    """Samples of the window (eq:hann)."""
    if name == "box":
        return np.ones(n)
    if name != "hann":
        raise NotImplementedError(f"no window {name}")
    return np.sin(np.pi * np.arange(n) / n) ** 2


def ascending(n, spacing):
    """Angular wavenumbers or frequencies of the bins after fftshift."""
    first = -(n // 2)
    return 2 * np.pi / (n * spacing) * (first + np.arange(n))


def power_spectrum(movie, spacing, window):
    """Power (nt, ny, nx) and its axes omega, ky, kx."""
    frames, rows, columns = movie.shape
    dx, dy, dt = spacing
    in_time = taper(window, frames)
    down = taper(window, rows)
    across = taper(window, columns)
    tapered = movie * in_time[:, None, None]
    tapered = tapered * down[:, None]
    tapered = tapered * across
    transform = np.fft.fftn(tapered)
    transform = np.fft.fftshift(transform)
    power = transform.real**2 + transform.imag**2
    kx = ascending(columns, dx)
    ky = ascending(rows, dy)
    omega = -ascending(frames, dt)
    return power, omega, ky, kx


def strong_bins(power, omega, ky, kx, wavenumber):
    """kx, ky and omega of the bins of a shell that the fit is made to."""
    dk = max(kx[1] - kx[0], ky[1] - ky[0])
    across, down = np.meshgrid(kx, ky)
    length = np.sqrt(across**2 + down**2)
    distance = np.abs(length - wavenumber) / dk
    shell = distance <= BINS_TO_EITHER_SIDE + ROUNDING
    forward = omega >= 0
    inside = power[forward][:, shell]
    level = SHARE_OF_PEAK * inside.max(initial=0.0)
    frequency, place = np.nonzero((inside >= level) & (inside > 0))
    return across[shell][place], down[shell][place], omega[forward][frequency]


def solve(kx, ky, doppler):
    """The velocity that minimises the sum of (k.c - doppler)^2, by Cramer's rule; None where it is not determined."""
    xx = np.sum(kx * kx)
    yy = np.sum(ky * ky)
    xy = np.sum(kx * ky)
    x = np.sum(kx * doppler)
    y = np.sum(ky * doppler)
    determinant = xx * yy - xy * xy
    if determinant <= LEAST_DETERMINANT * (xx + yy) ** 2:
        return None
    u = (yy * x - xy * y) / determinant
    v = (xx * y - xy * x) / determinant
    return u, v


class Extractor:
    def describe(self):
        return {
            "name": "stranger, least squares",
            "version": "1",
            "units": "si",
            "axes": "tyx",
            "y": "down",
            "can": {"extract": {"methods": ["ls"], "windows": ["box", "hann"]}},
        }

    def extract(self, surface, spacing, wavenumbers, *, gravity, window):
        movie = np.asarray(surface, dtype=float)
        if not np.all(np.isfinite(movie)):
            raise ValueError("NaN or infinity in the video")
        power, omega, ky, kx = power_spectrum(movie, spacing, window)
        limit = np.pi / max(spacing[0], spacing[1])
        velocities = []
        for wavenumber in wavenumbers:
            kx_j, ky_j, omega_j = strong_bins(power, omega, ky, kx, wavenumber)
            if wavenumber > limit or omega_j.size == 0:
                velocities.append(None)
                continue
            k_j = np.hypot(kx_j, ky_j)
            still = np.sqrt(gravity * k_j)
            doppler = omega_j - still
            velocity = solve(kx_j, ky_j, doppler)
            velocities.append(velocity)
        return velocities
