"""Generators of random seas that share nothing with leakref's: other waves, other laws, other frames."""

from __future__ import annotations

import numpy as np

G = 9.81


def spectrum(f, peak, gamma):
    """JONSWAP over frequencies in Hz, of no particular energy."""
    with np.errstate(divide="ignore", over="ignore"):
        sigma = np.where(f <= peak, 0.07, 0.09)
        return np.where(
            f > 0.3 * peak,
            f**-5.0 * np.exp(-1.25 * (peak / f) ** 4) * gamma ** np.exp(-((f - peak) ** 2) / (2 * (sigma * peak) ** 2)),
            0.0,
        )


def wavenumber(omega, depth):
    """Of waves of that frequency, by Newton's method on omega^2 = g k tanh k h."""
    k = np.maximum(omega**2 / G, omega / np.sqrt(G * depth))
    for _ in range(50):
        t = np.tanh(np.minimum(k * depth, 300.0))
        k -= (G * k * t - omega**2) / (G * t + G * k * depth * (1 - t**2))
    return k


class Drawn:
    """As many waves as wanted, each of the same energy, their frequencies and directions drawn from the spectrum: a
    normal law of directions, frames first, rows downwards, waves given by where they come from, heights and Hz."""

    def describe(self):
        return {
            "name": "drawn", "units": "si", "axes": "tyx", "y": "down", "direction": "from",
            "can": {"sea": {}},
        }  # fmt: skip

    def sea(self, shape, spacing, *, height, peak_period, peakedness, direction, deviation, current, depth, seed):
        rng, n = np.random.default_rng(seed), 600
        f = np.linspace(0.3, 2.4, 4000) / peak_period
        density = spectrum(f, 1 / peak_period, peakedness) * self.depth_factor(2 * np.pi * f, depth)
        omega = 2 * np.pi * np.interp(rng.random(n), np.cumsum(density) / density.sum(), f)
        towards = np.radians(direction + 180 + deviation * rng.standard_normal(n))
        k = wavenumber(omega, depth)
        kx, ky = k * np.cos(towards), k * np.sin(towards)
        omega = omega - (kx * current[0] + ky * current[1])  # a current given by where it comes from
        a = height / 4 * np.sqrt(2 / n)
        x, y, t = (np.arange(m) * d for m, d in zip(shape, spacing, strict=True))
        wave = np.exp(1j * np.outer(t, -omega)) * (a * np.exp(2j * np.pi * rng.random(n)))
        along = np.exp(1j * np.outer(kx, x))
        down = np.exp(1j * np.outer(y, ky))
        return np.stack([((row * down) @ along).real for row in wave])

    def depth_factor(self, omega, depth):
        """Of Bouws and others, Phi = tanh(kh)^2 / (1 + 2kh / sinh 2kh)."""
        kh = wavenumber(omega, depth) * depth
        kh = np.minimum(kh, 300.0)
        return np.tanh(kh) ** 2 / (1 + 2 * kh / np.sinh(2 * kh))


class Gaussian:
    """Normal amplitudes on the bins of the cube, by an inverse transform for each frame, in deep water and SI."""

    def describe(self):
        return {"name": "gaussian", "units": "si", "can": {"sea": {"amplitudes": "random"}}}

    def sea(self, shape, spacing, *, variance, peak_frequency, peakedness, direction, spread, current, seed):
        rng, (nx, ny, nt) = np.random.default_rng([seed, 5]), shape
        kx, ky = np.meshgrid(
            *(2 * np.pi * np.fft.fftfreq(n, d) for n, d in zip(shape[:2], spacing[:2], strict=True)), indexing="ij"
        )
        k = np.hypot(kx, ky)
        k[0, 0] = 1.0
        omega = np.sqrt(G * k)
        off = (np.degrees(np.arctan2(ky, kx)) - direction + 180) % 360 - 180
        law = np.where(np.abs(off) < spread / 2, np.cos(np.pi * off / spread) ** 2, 0.0)
        energy = spectrum(omega / 2 / np.pi, peak_frequency / 2 / np.pi, peakedness) * law * omega / k**2
        energy[0, 0] = 0.0
        energy[k > 16 * peak_frequency**2 / G] = 0.0
        energy *= variance / energy.sum()
        drawn = np.sqrt(energy) * (rng.standard_normal((nx, ny)) + 1j * rng.standard_normal((nx, ny)))
        moving = omega + kx * current[0] + ky * current[1]
        frames = [np.fft.ifft2(drawn * np.exp(-1j * moving * m * spacing[2])).real * nx * ny for m in range(nt)]
        return np.stack(frames, axis=2)


GENERATORS = {"drawn": Drawn, "gaussian": Gaussian}
