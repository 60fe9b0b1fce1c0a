"""Is there a dispersion shell in a spectrum at all, and does it lie where gravity and the steps put it?

Waves on water lie on a surface, omega = omega0(k) + k.c; noise, still pictures and what has leaked from a swell do not.
Two figures say how much of the energy does:

- the contrast at a wavenumber, the energy near the surface that was fitted there over the energy beside it;
- the share of the band, that part of the energy of all shells with signal which one common current brings onto the
  surface. A step, a gravity or a unit that is wrong moves the surface to F omega0(k): each shell by itself makes up
  for that with a current of its own, but no common current does, and the share is larger at F than at 1.

Only bins that rise above the noise of their ring count, and every ring counts the same. The limits are calibrated on
the seas of the paper, on noise, on still frames and on swell alone (tests/test_contrast.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from leakref._base import FloatArray
from leakref.dispersion import Water
from leakref.nsp import WIDTH
from leakref.shell import shell_at
from leakref.spectrum import Spectrum

__all__ = ["CONTRAST", "GAIN", "MISPLACED", "NEAR", "SHARE", "SUSPECT", "Band", "Found", "band", "contrasts"]

SHARE = 0.2
"""Of the energy in the band: less than this near the surface is no shell. Seas reach 0.3 to 0.9, still frames 0."""
CONTRAST = 1.0
"""A shell needs this at more than half of the wavenumbers. Seas have 2 to 1e5, leaks from a swell 0.2 to 0.8."""
GAIN = 0.01
"""How much larger, in itself, the share must be at another factor F for that to mean anything: in the paper's seas, at
the right factor, it is 0.0025 at most.
"""
SUSPECT, MISPLACED = 0.07, 0.15
"""How far from 1 such a factor must be, in its logarithm, to be mentioned, and for the surface to be called misplaced.
Between the two a strong shear does the same: U that falls by 0.1 c0 over a depth of 1 / k0 looks like F = 0.9.
"""
NEAR = (0.8, 0.9, 1.0, 1.12, 1.25)
"""Factors from which the best one nearby is looked for."""
_SIGNIFICANT = 12.0  # times the floor of a ring: one bin of noise in 160 000
_POINTS = 1500
_NARROW = 2.5  # half width of the surface in domega, at which it weighs exp(-2)
_REACH = 0.6  # of the phase velocity: currents are looked for up to here
_FEW = 12  # bins below which there is nothing to judge


def _floor(power: FloatArray) -> float:
    """The mean power of the noise among bins that also hold waves: exponential noise has its median at log 2 of it."""
    return float(np.median(power) / np.log(2)) if power.size else 0.0


def contrasts(spectrum: Spectrum, wavenumbers: FloatArray, velocities: FloatArray, water: Water) -> list[float | None]:
    """Energy near the fitted surface over energy beside it, at each wavenumber; n numbers, None where there is none.

    Near is within the width of eq:DSVkernel of one of the branches. `velocities` (n, 2) are what was fitted; where they
    are NaN there is nothing to compare. Of both energies what noise of the shell's own floor holds there is left out; a
    shell of nothing but noise has a contrast of 0.
    """
    found: list[float | None] = []
    width = WIDTH * spectrum.grid.frequency_resolution
    for wavenumber, velocity in zip(wavenumbers, velocities, strict=True):
        if np.isnan(velocity).any():
            found.append(None)
            continue
        shell = shell_at(spectrum, float(wavenumber), water=water)
        power = shell.magnitude**2 * shell.weight
        shift = shell.kx * velocity[0] + shell.ky * velocity[1]
        off = [np.abs(shell.omega - (sign * shell.intrinsic + shift)[:, None]) for sign in (1, -1)]
        near = np.minimum(*off) <= width
        counted = np.where(power > _SIGNIFICANT * _floor(power), power, 0.0)
        on, beside = float(counted[near].sum()), float(counted[~near].sum())
        found.append(min(on / beside, 1e6) if beside else 1e6 if on else 0.0)
    return found


@dataclass(frozen=True)
class Found:
    """What one common current brings onto the surface F omega0(k): the share, F, and the current (2,)."""

    share: float
    factor: float
    current: FloatArray


@dataclass(frozen=True, eq=False)
class Band:
    """The strongest significant bins of all rings: n points with `kx`, `ky`, `omega` and `energy`, of `total`.

    `rings` is the number of wavenumbers that they come from; `step` is domega. Units are those of the spectrum.
    """

    kx: FloatArray
    ky: FloatArray
    omega: FloatArray
    energy: FloatArray
    total: float
    rings: int
    step: float
    last: float
    water: Water

    @property
    def is_empty(self) -> bool:
        """Whether nothing rises above noise."""
        return self.energy.size < _FEW

    @property
    def wavenumber(self) -> float:
        """The mean wavenumber of the energy."""
        return float(np.sum(self.energy * np.hypot(self.kx, self.ky)) / self.energy.sum())

    def share(self, factor: float, current: FloatArray, width: float = _NARROW) -> float:
        """The part of the energy that lies at `factor` omega0(k) + k.c, as a Gaussian of `width` domega weighs it."""
        centre = factor * self.water.frequency(np.hypot(self.kx, self.ky))
        off = (self.omega - centre - self.kx * current[0] - self.ky * current[1]) / (width * self.step)
        return float(np.exp(-2 * off**2) @ self.energy) / self.total

    def at(self, factor: float) -> Found:
        """The current that brings most onto the surface at one factor: a lattice, then Nelder-Mead from its best."""
        if self.is_empty:
            return Found(0.0, factor, np.zeros(2))
        k = self.wavenumber
        reach = _REACH * factor * float(self.water.phase_velocity(k))
        apart = max(2 * _NARROW * self.step / k, reach / 14)
        line = np.arange(-np.ceil(reach / apart), np.ceil(reach / apart) + 1) * apart
        lattice = np.stack(np.meshgrid(line, line, indexing="ij"), -1).reshape(-1, 2)
        lattice = lattice[np.hypot(*lattice.T) <= reach]
        wide = max(_NARROW, apart * k / self.step)  # what falls between two points of the lattice is seen from both
        start = lattice[int(np.argmax([self.share(factor, c, wide) for c in lattice]))]
        return self._refined(factor, start, apart, reach)

    def _refined(self, factor: float, start: FloatArray, apart: float, reach: float) -> Found:
        """Nelder-Mead over the current, within reach."""
        fit = minimize(
            lambda c: -self.share(factor, c) * (np.hypot(*c) <= 1.2 * reach),
            start,
            method="Nelder-Mead",
            options={"initial_simplex": start + apart / 2 * np.array([[0, 0], [1, 0], [0, 1.0]]), "maxfev": 90},
        )
        return Found(float(-fit.fun), factor, fit.x)

    def best(self, factors: Sequence[float]) -> Found:
        """The factor at which most of the energy lies on the surface, among `factors` and near the best of them."""
        found = max((self.at(factor) for factor in factors), key=lambda one: one.share)
        for spread in (0.06, 0.02):
            near = [found.factor * (1 + spread * m / 2) for m in (-2, -1, 1, 2)]
            found = max([found, *(self.at(factor) for factor in near)], key=lambda one: one.share)
        return found

    @property
    def tells_the_factor(self) -> bool:
        """Whether the rings are many and far enough apart to tell a factor from a current."""
        k = np.hypot(self.kx, self.ky)
        return self.rings >= 6 and k.max(initial=0.0) >= 2 * k.min(initial=np.inf)

    def everywhere(self) -> list[float]:
        """Factors, a twelfth apart, at which the surface crosses the frequencies of the spectrum in the whole band.

        The first is 1; of a few frames there are no others.
        """
        k = np.hypot(self.kx, self.ky)
        low = 3 * self.step / float(self.water.frequency(k.max()))
        high = self.last / float(self.water.frequency(k.min()))
        return [1.0, *np.exp(np.arange(np.log(low), np.log(high), 1 / 12)).tolist()]


def band(spectrum: Spectrum, wavenumbers: FloatArray, water: Water) -> Band:
    """The significant bins in rings of one dk around the `wavenumbers` (n,), each ring of the same energy.

    The spectrum is a tapered one. At most `_POINTS` bins are kept, the strongest; `total` counts them all.
    """
    dk = spectrum.grid.wavenumber_resolution
    k = np.hypot(*np.meshgrid(spectrum.kx, spectrum.ky, indexing="ij"))
    parts: list[tuple[FloatArray, ...]] = []
    for wavenumber in wavenumbers:
        a, b = np.nonzero(np.abs(k - wavenumber) <= dk / 2)
        power = np.abs(spectrum.values[a, b]) ** 2
        n, m = np.nonzero(power > max(_SIGNIFICANT * _floor(power), 1e-300))
        if n.size:
            energy = power[n, m] / power[n, m].sum()
            parts.append((spectrum.kx[a[n]], spectrum.ky[b[n]], spectrum.omega[m], energy))
    whole = np.concatenate([np.stack(part) for part in parts], axis=1) if parts else np.zeros((4, 0))
    energy = whole[3]
    kept = whole[:, np.argsort(energy)[-_POINTS:]]
    return Band(
        kx=kept[0],
        ky=kept[1],
        omega=kept[2],
        energy=kept[3],
        total=max(float(energy.sum()), 1e-300),
        rings=len(parts),
        step=spectrum.grid.frequency_resolution,
        last=float(spectrum.omega[-1]),
        water=water,
    )
