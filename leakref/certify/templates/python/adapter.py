"""An adapter in Python: `Code` is what leakref judges. Put your own code in place of what `extract` does here."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np


class Code:
    """What a code says of itself, and what it does."""

    def describe(self) -> dict[str, Any]:
        """Say here what your code expects and returns; leakref converts to it and back."""
        return {
            "name": "my code",
            "version": "1",
            "units": "si",  # metres and seconds; or "scaled", where gravity is 1
            "axes": "xyt",  # the order of the axes of the surface
            "y": "up",  # the second axis points upwards; or "down", as the rows of an image do
            "direction": "to",  # velocities say where the water goes to; or "from"
            "water": {"depth": "given"},  # handed over; or the one in your code, in metres; left out: deep water only
            "can": {"extract": {"methods": ["ls"], "windows": ["box", "hann"], "resolves": "wavenumber"}},
        }

    def extract(
        self, surface: Any, spacing: Sequence[float], wavenumbers: Any, *, gravity: float, depth: float, window: str
    ) -> list[tuple[float, float] | None]:
        """The current (cx, cy) that the waves near each wavenumber see, None where there is none to give.

        `surface` (nx, ny, nt) is sampled at `spacing` (dx, dy, dt); `wavenumbers` (n,) in rad per unit of length. This
        one fits the dispersion relation omega = sqrt(g k tanh(k h)) + k.c by least squares to the strong bins around
        each; `depth` h is in units of length.
        """
        if not np.isfinite(surface).all():
            raise ValueError("the surface holds values that are not finite")
        if window == "hann":
            for axis, size in enumerate(surface.shape):
                taper = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
                surface = surface * taper.reshape([-1 if other == axis else 1 for other in range(3)])
        power = np.abs(np.fft.rfftn(surface)) ** 2
        # numpy transforms forwards in time too, which puts a wave that goes along k at -k
        x, y = (-2 * np.pi * np.fft.fftfreq(size, step) for size, step in zip(surface.shape, spacing[:2], strict=False))
        omega = 2 * np.pi * np.fft.rfftfreq(surface.shape[2], spacing[2])
        kx, ky = np.meshgrid(x, y, indexing="ij")
        k = np.hypot(kx, ky)
        bin_width, nyquist = max(abs(x[1]), abs(y[1])), min(np.pi / step for step in spacing[:2])
        found: list[tuple[float, float] | None] = []
        for wavenumber in wavenumbers:
            shell = np.abs(k - wavenumber) <= 2.000001 * bin_width
            inside = wavenumber + 2 * bin_width < nyquist and power[shell].any()
            i, m = np.nonzero(power[shell] >= 0.2 * power[shell].max()) if inside else 2 * (np.zeros(0, int),)
            direction = np.stack([kx[shell][i], ky[shell][i]])
            shift = omega[m] - np.sqrt(gravity * k[shell][i] * np.tanh(k[shell][i] * depth))
            normal = direction @ direction.T
            known = np.linalg.eigvalsh(normal)
            if known[0] <= 1e-9 * known[1]:
                found.append(None)  # waves in one direction say nothing of the current across it
            else:
                cx, cy = np.linalg.solve(normal, direction @ shift)
                found.append((float(cx), float(cy)))
        return found
