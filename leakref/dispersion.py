"""The dispersion relation of water, its units, and what resolution allows.

Waves of wave vector k are seen at omega = omega0(|k|) + k.c (eq:SnJ, equation 1): omega0 is the frequency in still
water, rad per time for k in rad per length, and c the Doppler shift velocity (`currents`). `Water` is the only place in
the package that knows omega0(k): it travels wherever waves are looked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, LeakrefError, finite, positive

__all__ = ["DEEP", "Scales", "Water", "law", "velocity_resolutions"]


@dataclass(frozen=True)
class Water:
    """Deep, still water of some gravity (sec:theory); another law of dispersion is another class with these methods.

    All take wavenumbers of any shape, rad per length. Raises LeakrefError for a gravity that is not positive.
    """

    gravity: float = 1.0

    def __post_init__(self) -> None:
        positive("Water", gravity=self.gravity)

    def frequency(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """omega0(k) = sqrt(g k), rad per time."""
        return np.sqrt(self.gravity * np.asarray(wavenumber, dtype=np.float64))

    def phase_velocity(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """omega0 / k = sqrt(g / k)."""
        return np.sqrt(self.gravity / np.asarray(wavenumber, dtype=np.float64))

    def group_velocity(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """d omega0 / d k = sqrt(g / k) / 2."""
        return self.phase_velocity(wavenumber) / 2

    def density_factor(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """The factor from a density over frequencies to one over the plane, 2 (d omega0 / d k) / k = sqrt(g) k^-3/2."""
        falling: FloatArray = np.asarray(wavenumber, dtype=np.float64) ** -1.5
        return falling * float(np.sqrt(self.gravity))


DEEP = Water()
"""The paper's water, in its scaled units."""


def law(call: str, gravity: float | None, water: Water | None) -> Water:
    """The `water` that was given, or deep water of some `gravity`; LeakrefError in the name of `call` for neither."""
    if water is None and gravity is None:
        remedy = "give it in the units of the surface: 9.81 for metres and seconds, 1 for the paper's scaled units"
        raise LeakrefError(call, "there is neither gravity nor water", remedy)
    if water is None:
        assert gravity is not None
        positive(call, gravity=gravity)
        return Water(gravity)
    if isinstance(water, type):
        raise LeakrefError(call, f"water = {water.__name__} is a class", "give one of it, such as Water(9.81)")
    lacking = [
        name for name in ("gravity", "frequency", "phase_velocity", "group_velocity") if not hasattr(water, name)
    ]
    if lacking:
        remedy = "give leakref.Water(gravity), or another class with its methods"
        raise LeakrefError(call, f"water = {water!r} is no law of dispersion: it has no {lacking[0]}", remedy)
    return water


def velocity_resolutions(
    wavenumber: npt.ArrayLike, wavenumber_resolution: float, frequency_resolution: float, water: Water = DEEP
) -> tuple[FloatArray, FloatArray]:
    """The two Doppler shift resolutions of eq:dcdwk at each wavenumber, in units of velocity.

    Returns (from frequency: domega / k, from wavenumber: d omega0 / d k * dk / k). Raises LeakrefError.
    """
    k = finite("velocity_resolutions", "wavenumber", wavenumber)
    dk, domega = wavenumber_resolution, frequency_resolution
    positive("velocity_resolutions", wavenumber=k.ravel(), wavenumber_resolution=dk, frequency_resolution=domega)
    return domega / k, water.group_velocity(k) * dk / k


@dataclass(frozen=True)
class Scales:
    """From the paper's scaled units (k0 = omega0 = g = 1, sec:dimensions) to any others, and back.

    Multiply a scaled quantity by the scale of its kind; divide to go back.
    """

    peak_wavenumber: float = 1.0
    gravity: float = 1.0

    def __post_init__(self) -> None:
        positive("Scales", peak_wavenumber=self.peak_wavenumber, gravity=self.gravity)

    @property
    def wavenumber(self) -> float:
        """k0, rad per length."""
        return self.peak_wavenumber

    @property
    def frequency(self) -> float:
        """omega0 = sqrt(g k0), rad per time."""
        return float(Water(self.gravity).frequency(self.peak_wavenumber))

    @property
    def length(self) -> float:
        """1 / k0."""
        return 1 / self.wavenumber

    @property
    def time(self) -> float:
        """1 / omega0."""
        return 1 / self.frequency

    @property
    def velocity(self) -> float:
        """c0 = omega0 / k0, the phase velocity at the peak."""
        return self.frequency / self.wavenumber
