"""Faults of a generator of random seas: leakref's own with one thing wrong.

They are kept apart from those of the chain: what they make is judged by the family `sea` alone, and by chance, so that
none is a hypothesis about velocities.
"""

from __future__ import annotations

from typing import Any

from leakref.altered import Change
from leakref.certify.strength.fault import Fault
from leakref.generator import Generator

__all__ = ["SEA_FAULTS"]

_ENERGY = "energy *= variance / energy.sum()"
_DENSITY = "density = jonswap(still.frequency(scaled) / still.frequency(1.0), peakedness)"
_OMEGA = "omega = water.frequency(k) + kx * current[0] + ky * current[1]"
_PHASE = "phase = uniform_phases(seed, i, j)"
_GIVEN = "np.degrees(np.arctan2(ky, kx)), direction, spread)\n    inside = (k > 0) & (k <= LARGEST_WAVENUMBER * peak"
_AMPLITUDE = "return Components(kx, ky, omega, np.sqrt(2 * energy), phase)"


def _sea(identifier: str, words: str, *changes: tuple[str, str]) -> Fault:
    altered = tuple(Change("generator", old, new) for old, new in changes)
    return Fault(f"sea-{identifier}", "sea", "sea", words, altered)


def _spreading(new: str) -> tuple[str, str]:
    return _GIVEN, _GIVEN.replace("direction, spread", new)


class Unrepeatable(Generator):
    """Takes a seed and counts its calls."""

    def __init__(self) -> None:
        self.calls = 0

    def sea(self, *grid: Any, variance: float, peak_wavenumber: float, peakedness: float, direction: float,
            spread: float, current: tuple[float, float], gravity: float, depth: float, surface_tension: float = 0.0,
            seed: int) -> Any:  # fmt: skip
        """A surface, (nx, ny, nt), another one with each call."""
        self.calls += 1
        return super().sea(*grid, variance=variance, peak_wavenumber=peak_wavenumber, peakedness=peakedness,
                           direction=direction, spread=spread, current=current, gravity=gravity, depth=depth,
                           surface_tension=surface_tension, seed=seed + 7919 * self.calls)  # fmt: skip


SEA_FAULTS = (
    _sea("two-thirds-energy", "the seas hold 2/3 of the energy asked for", (_ENERGY, f"{_ENERGY} * 2 / 3")),
    _sea("height-for-deviation", "the significant height is taken for the deviation", (_ENERGY, f"{_ENERGY} * 16")),
    _sea("one-sided", "a one-sided spectrum is taken for a two-sided one: half of the energy",
         (_ENERGY, f"{_ENERGY} / 2")),
    _sea("peakedness-ignored", "the peakedness is not used, and is 1 for all seas",
         (_DENSITY, _DENSITY.replace("peakedness", "1.0"))),
    _sea("peak-in-hertz", "the density is taken at a frequency in Hz where one in rad/s is meant",
         (_DENSITY, _DENSITY.replace("(scaled)", "(scaled) / (2 * np.pi)"))),
    _sea("jacobian-missing", "the density over frequencies is taken for one over wavenumbers",
         ("energy = still.density_factor(scaled) * density * f\n    energy *= variance",
          "energy = density * f\n    energy *= variance")),
    _sea("from-for-to", "the waves go where they should come from", _spreading("direction + 180, spread")),
    _sea("exchanged-axes", "x and y exchanged in the directions of the waves", _spreading("90 - direction, spread")),
    _sea("degrees-for-radians", "the direction is put into cos and sin in degrees",
         _spreading("np.degrees(np.degrees(direction)), spread")),
    _sea("twice-the-width", "the width of the spreading is taken for half of it", _spreading("direction, 2 * spread")),
    _sea("half-the-width", "half of the width is taken for the width of the spreading",
         _spreading("direction, spread / 2")),
    _sea("both-ways", "each wave runs both ways", ("return Components(kx, ky, omega, np.sqrt(2 * energy), phase)",
         "both = [np.concatenate(pair) for pair in ((kx, -kx), (ky, -ky), (omega, omega), (energy / 2, energy / 2), "
         "(phase, -phase))]\n    return Components(both[0], both[1], both[2], np.sqrt(2 * both[3]), both[4])")),
    _sea("current-sign", "the current has the wrong sign", (_OMEGA, _OMEGA.replace("+", "-"))),
    _sea("current-left-out", "the current is not used", (_OMEGA, "omega = water.frequency(k)")),
    _sea("depth-ignored", "the water is deep whatever the depth",
         (_OMEGA, _OMEGA.replace("water.frequency(k)", "Water(water.gravity).frequency(k)"))),
    _sea("one-seed", "the seed is not used: all seas are one", (_PHASE, _PHASE.replace("seed", "0"))),
    _sea("half-phases", "phases are drawn from half of the circle", (_PHASE, f"{_PHASE} / 2")),
    _sea("one-phase", "all waves of a sea have one phase", (_PHASE, f"{_PHASE}[:1] + 0 * k")),
    _sea("few-seeds", "the seed is cut to three bits", (_PHASE, _PHASE.replace("seed", "seed % 8"))),
    _sea("amplitudes-drawn", "amplitudes are drawn though they are declared fixed",
         (_AMPLITUDE, "drawn = -np.log(1 - uniform_phases(seed + 2**40, i, j) / (2 * np.pi))\n    "
          + _AMPLITUDE.replace("energy", "energy * drawn"))),
    Fault("sea-unrepeatable", "sea", "sea", "one seed gives another sea each time", instead=Unrepeatable),
)  # fmt: skip
"""Every fault of a generator."""
