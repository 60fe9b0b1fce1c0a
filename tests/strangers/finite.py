"""The two extractors in water with a bottom and a surface tension, right and with the mistakes that people make.

A law of dispersion is a function of gravity, wavenumber, depth and surface tension (over density), and all that is
wrong with a code is wrong in it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from strangers import leastsquares, nsp

Law = Callable[[float, np.ndarray, float, float], np.ndarray]
RHO = 1000.0


def right(g, k, h, s):
    return np.sqrt((g * k + s * k**3) * np.tanh(k * h))


def group(g, k, h, s):
    tension = s * k**2 / g
    return right(g, k, h, s) * ((1 + 3 * tension) / (1 + tension) / 2 + k * h / np.sinh(np.minimum(2 * k * h, 700.0)))


def imaginary(g, k, h, s):
    return np.sqrt((g * k * np.tanh(-k * h)).astype(complex)).real


MISTAKES: dict[str, tuple[Law, str]] = {
    # what it does, and what the explanation must say of it: a fault's id, or words
    "tanh-outside-root": (lambda g, k, h, s: np.sqrt(g * k + s * k**3) * np.tanh(k * h), "tanh-outside-root"),
    "deep-whatever-is-given": (lambda g, k, h, s: np.sqrt(g * k + s * k**3), "depth-ignored"),
    "ten-metres-by-default": (lambda g, k, h, s: right(g, k, 10.0, s), "depth of 10 m"),
    "cycles": (lambda g, k, h, s: right(g, k, h / (2 * np.pi), s), "depth-in-cycles"),
    "feet": (lambda g, k, h, s: right(g, k, 0.3048 * h, s), "depth-in-feet"),
    "negative": (imaginary, "depth-unused"),
    "k-over-h": (
        lambda g, k, h, s: np.sqrt((g * k + s * k**3) * np.tanh(k / h)),
        "",
    ),  # a tenth of its NSP's answers are elsewhere
    "group-for-phase": (group, "group-velocity"),
    "no-tension": (lambda g, k, h, s: right(g, k, h, 0.0), "tension-ignored"),
    "density-twice": (lambda g, k, h, s: right(g, k, h, s / RHO), "tension-per-density"),
    "k-squared": (lambda g, k, h, s: np.sqrt((g * k + s * k**2) * np.tanh(k * h)), "tension-k-squared"),
}


class Finite:
    """NSP and least squares by one law of dispersion, in metres and seconds, told the depth and the tension."""

    def __init__(self, law: Law = right) -> None:
        self.law = law

    def describe(self) -> dict[str, Any]:
        can = {"extract": {"methods": ["nsp", "ls"], "windows": ["box", "hann"]}}
        return {"name": "stranger in finite depth", "version": "1", "units": "si", "can": can}

    def extract(self, surface, spacing, wavenumbers, *, gravity, depth, surface_tension, window, method):
        if method == "nsp":
            spectrum, fit = nsp.transformed(surface, spacing, window), self._nsp
        else:
            movie = np.asarray(surface, dtype=float).transpose(2, 1, 0)
            if not np.isfinite(movie).all():
                raise ValueError("NaN or infinity in the video")
            spectrum, fit = leastsquares.power_spectrum(movie, spacing, window), self._ls

        def still(k):
            return self.law(gravity, np.asarray(k, dtype=float), depth, surface_tension)

        limit = np.pi / max(spacing[:2])
        return [None if k > limit else fit(spectrum, float(k), still, gravity) for k in wavenumbers]

    def _nsp(self, spectrum, wavenumber, still, gravity):
        ring = np.abs(spectrum.k - wavenumber) <= nsp.SHELL_HALF_WIDTH * spectrum.dk * nsp.EDGE
        kx, ky, omega0 = spectrum.kx[ring], spectrum.ky[ring], still(spectrum.k[ring])
        magnitude, width = spectrum.magnitude[ring] * spectrum.weight, nsp.GAUSSIAN_WIDTH * spectrum.domega
        if not magnitude.sum():
            return None

        def overlap(velocity):
            shift = (kx * velocity[0] + ky * velocity[1])[:, None]
            g = sum(np.exp(-2 * ((spectrum.omega - shift - s * omega0[:, None]) / width) ** 2) for s in (1, -1))
            mean = (g * spectrum.weight).mean() * magnitude.mean()
            return (g * magnitude).mean() / mean if mean > 0 else 0.0

        return nsp.best_velocity(overlap, np.sqrt(gravity / wavenumber)).tolist()

    def _ls(self, spectrum, wavenumber, still, gravity):
        kx, ky, omega = leastsquares.strong_bins(*spectrum, wavenumber)
        return leastsquares.solve(kx, ky, omega - still(np.hypot(kx, ky))) if omega.size else None
