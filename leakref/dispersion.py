"""The dispersion relation of water, its units, and what resolution allows.

Waves of wave vector k are seen at omega = omega0(|k|) + k.c (eq:SnJ, equation 1), with c the Doppler shift velocity
(`currents`) and omega0 the frequency in still water of depth h and surface tension S (over density),

    omega0(k) = sqrt((g k + S k^3) tanh(k h)),

rad per time for k in rad per length: sqrt(g k) in the paper's deep water. `Water` is the only place in the package that
knows omega0(k): it travels wherever waves are looked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, LeakrefError, finite, number, positive

__all__ = ["DEEP", "Scales", "Water", "law", "velocity_resolutions", "velocity_unit"]

_BOTTOMLESS = 1e200  # a depth that no wave feels: k times it is 0 for k = 0, and never infinite
_LAW = ("gravity", "depth", "frequency", "phase_velocity", "group_velocity", "density_factor", "depth_factor")


@dataclass(frozen=True)
class Water:
    """Still water of a `depth` h and a `surface_tension` S over density (sec:theory): deep and without, by default.

    `gravity` g in length / time^2, `depth` in lengths, `surface_tension` in length^3 / time^2. All methods take
    wavenumbers of any shape, rad per length, and lose no digits however small or large k h is. Another law is a class
    derived from this one. Raises LeakrefError for a gravity or depth not above zero or a tension below it.
    """

    gravity: float
    depth: float = np.inf
    surface_tension: float = 0.0

    def __post_init__(self) -> None:
        number("Water", gravity=self.gravity, depth=self.depth, surface_tension=self.surface_tension)
        depth, tension = 1.0 if self.depth == np.inf else self.depth, self.surface_tension or 1.0
        positive("Water", gravity=self.gravity, depth=depth, surface_tension=tension)

    def frequency(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """omega0(k) = sqrt((g k + S k^3) tanh(k h)), rad per time: sqrt(g k) in deep water."""
        return np.sqrt(self.gravity * np.asarray(wavenumber, dtype=np.float64)) * self._factors(wavenumber)[0]

    def phase_velocity(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """omega0 / k = sqrt((g / k + S k) tanh(k h)): sqrt(g / k) in deep water."""
        return np.sqrt(self.gravity / np.asarray(wavenumber, dtype=np.float64)) * self._factors(wavenumber)[0]

    def group_velocity(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """d omega0 / d k = omega0 / 2k ((g + 3 S k^2) / (g + S k^2) + 2 k h / sinh(2 k h)): sqrt(g / k) / 2 if deep."""
        return self.phase_velocity(wavenumber) / 2 * self._factors(wavenumber)[1]

    def density_factor(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """From a density over frequencies to one over the plane, 2 (d omega0 / d k) / k: sqrt(g) k^-3/2 if deep."""
        falling: FloatArray = np.asarray(wavenumber, dtype=np.float64) ** -1.5
        omega, group, _ = self._factors(wavenumber)
        return falling * float(np.sqrt(self.gravity)) * omega * group

    def depth_factor(self, wavenumber: npt.ArrayLike) -> FloatArray:
        """What a bottom leaves of a density over frequencies, tanh^2(k h) / (1 + 2 k h / sinh(2 k h)): 1 if deep.

        The factor of the TMA spectrum (Bouws et al. 1985, doi 10.1029/JC090iC01p00975; decision D28).
        """
        return self._factors(wavenumber)[2]

    def _factors(self, wavenumber: npt.ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What bottom and tension make of omega0, of the group velocity beside it and of a density: 1 in deep water."""
        if self.depth == np.inf and self.surface_tension == 0:
            return (one := np.ones(np.shape(wavenumber))), one, one
        k = np.asarray(wavenumber, dtype=np.float64)
        kh, tension = k * min(self.depth, _BOTTOMLESS), k**2 * self.surface_tension / self.gravity
        twice = np.clip(2 * kh, 1e-300, 700.0)  # where 2 k h / sinh(2 k h) is 1, or nothing beside 1
        tanh, ratio = np.tanh(kh), twice / np.sinh(twice)
        return np.sqrt((1 + tension) * tanh), (1 + 3 * tension) / (1 + tension) + ratio, tanh**2 / (1 + ratio)

    def to_units(self, scales: Scales) -> Water:
        """From scaled units, in which `depth` is k0 h and `surface_tension` S k0^2 / g, to those of `scales`."""
        g, length = scales.gravity, scales.length
        return Water(self.gravity * g, self.depth * length, self.surface_tension * g * length**2)

    def to_scaled(self, scales: Scales) -> Water:
        """From the units of `scales` to scaled ones, in which gravity is 1 if it is that of `scales`."""
        return self.to_units(Scales(1 / scales.peak_wavenumber, 1 / scales.gravity))


DEEP = Water(1.0)
"""The paper's water, in its scaled units."""


def law(call: str, gravity: float | None, water: Water | None) -> Water:
    """The `water` that was given, or deep water of some `gravity`; LeakrefError for neither, or if they differ."""
    if water is None:
        if gravity is None:
            raise LeakrefError(call, "there is neither gravity nor water", "give it: 9.81 for metres and seconds")
        positive(call, gravity=gravity)
        return Water(gravity)
    if isinstance(water, type) or not all(hasattr(water, name) for name in _LAW):
        remedy = "give leakref.Water(gravity, depth), or one of a class derived from it"
        raise LeakrefError(call, f"water = {water!r} is no law of dispersion", remedy)
    if gravity not in (None, water.gravity):
        raise LeakrefError(call, f"gravity = {gravity}, and that of water is {water.gravity}", "give the water alone")
    return water


def velocity_resolutions(
    wavenumber: npt.ArrayLike, wavenumber_resolution: float, frequency_resolution: float, water: Water
) -> tuple[FloatArray, FloatArray]:
    """The two Doppler shift resolutions of eq:dcdwk at each wavenumber, in units of velocity.

    Returns (from frequency: domega / k, from wavenumber: d omega0 / d k * dk / k). Raises LeakrefError.
    """
    k = finite("velocity_resolutions", "wavenumber", wavenumber)
    dk, domega = wavenumber_resolution, frequency_resolution
    positive("velocity_resolutions", wavenumber=k.ravel(), wavenumber_resolution=dk, frequency_resolution=domega)
    return domega / k, water.group_velocity(k) * dk / k


def velocity_unit(wavenumber: float, water: Water, peak_wavenumber: float | None) -> float:
    """The phase velocity at k0: the unit in which the search starts and flags are judged, c0 if the water is deep.

    Without a peak k0 = 1 if scaled (gravity 1, k from 1/4 to 4), else k, which is the same at every scale (D21, D29).
    """
    is_scaled = water.gravity == 1 and 0.25 <= wavenumber <= 4  # so that the unit is within twice and half of its own
    return float(water.phase_velocity(peak_wavenumber or (1.0 if is_scaled else wavenumber)))


@dataclass(frozen=True)
class Scales:
    """From the paper's scaled units (k0 = g = 1, sec:dimensions) to any others, and back, whatever the depth.

    Multiply a scaled quantity by the scale of its kind; divide to go back; of water see `Water.to_units`. The units of
    time and velocity are those of deep water, 1 / sqrt(g k0) and sqrt(g / k0), in every water (decision D26).
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
        """sqrt(g k0), rad per time: omega0 of the peak in deep water."""
        return float(Water(self.gravity).frequency(self.peak_wavenumber))

    @property
    def length(self) -> float:
        """1 / k0."""
        return 1 / self.wavenumber

    @property
    def time(self) -> float:
        """1 / sqrt(g k0)."""
        return 1 / self.frequency

    @property
    def velocity(self) -> float:
        """c0 = sqrt(g / k0), the phase velocity at the peak in deep water."""
        return self.frequency / self.wavenumber
