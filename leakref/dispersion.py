"""The dispersion relation, the Doppler shift of a current, and what resolution allows.

Waves of wavenumber k on a current U(z) are seen at omega = omega0(k) + k.c (eq:SnJ, equation 1): omega0 is that of
still water, and c the Doppler shift velocity, to first order in U the mean over depth of eq:SJ (equation 3),

    c(k) = 2 k * integral over z < 0 of U(z) exp(2 k z) dz.

Here k is in rad per length, omega in rad per time, z in lengths, upwards from the surface, and U and c in lengths per
time. `Water` is the only place in the package that knows omega0(k): it travels wherever waves are looked for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy.integrate import quad_vec

from leakref._base import FloatArray, LeakrefError, finite, positive, vector

__all__ = ["DEEP", "Current", "ExponentialCurrent", "LinearCurrent", "ProfileCurrent", "Scales", "UniformCurrent",
           "Water", "velocity_resolutions"]


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


def velocity_resolutions(wavenumber: npt.ArrayLike, wavenumber_resolution: float, frequency_resolution: float,
                         water: Water = DEEP) -> tuple[FloatArray, FloatArray]:
    """The two Doppler shift resolutions of eq:dcdwk at each wavenumber, in units of velocity.

    Returns (from frequency: domega / k, from wavenumber: d omega0 / d k * dk / k). Raises LeakrefError.
    """
    k = finite("velocity_resolutions", "wavenumber", wavenumber)
    positive("velocity_resolutions", wavenumber=k.ravel(), wavenumber_resolution=wavenumber_resolution,
             frequency_resolution=frequency_resolution)
    return frequency_resolution / k, water.group_velocity(k) * wavenumber_resolution / k


class Current(Protocol):
    """Anything that shifts waves: a Doppler shift velocity (n, 2) for wavenumbers (n,)."""

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray: ...


@dataclass(frozen=True)
class UniformCurrent:
    """The same `velocity` (Ux, Uy) at every depth: every wave is shifted by it."""

    velocity: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        vector("UniformCurrent", velocity=self.velocity)

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray:
        """(n, 2), the velocity itself whatever the wavenumber."""
        return np.broadcast_to(np.asarray(self.velocity, dtype=np.float64), (np.size(wavenumber), 2))


@dataclass(frozen=True)
class LinearCurrent:
    """U(z) = surface + shear z for z <= 0; eq:SJ in closed form: surface - shear / 2k."""

    surface: tuple[float, float]
    shear: tuple[float, float]

    def __post_init__(self) -> None:
        vector("LinearCurrent", surface=self.surface, shear=self.shear)

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray:
        """eq:SJ, (n, 2)."""
        k = np.asarray(wavenumber, dtype=np.float64)[:, None]
        return np.asarray(self.surface) - np.asarray(self.shear) / (2 * k)


@dataclass(frozen=True)
class ExponentialCurrent:
    """U(z) = surface exp(z / depth); eq:SJ in closed form: surface 2kd / (1 + 2kd)."""

    surface: tuple[float, float]
    depth: float

    def __post_init__(self) -> None:
        vector("ExponentialCurrent", surface=self.surface)
        positive("ExponentialCurrent", depth=self.depth)

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray:
        """eq:SJ, (n, 2)."""
        kd = 2 * np.asarray(wavenumber, dtype=np.float64)[:, None] * self.depth
        return np.asarray(self.surface) * kd / (1 + kd)


@dataclass(frozen=True)
class ProfileCurrent:
    """Any `profile`: depths z <= 0 (n,) to velocities (n, 2); eq:SJ by adaptive quadrature.

    With s = exp(2kz) the integral of eq:SJ is that of U(log(s) / 2k) over 0 < s < 1: every wavenumber
    sees the same interval, and all are integrated together.
    """

    profile: Callable[[FloatArray], npt.ArrayLike]
    tolerance: float = 1e-12

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray:
        """eq:SJ, (n, 2). Raises LeakrefError if the profile has another shape or is not finite."""
        k = np.asarray(wavenumber, dtype=np.float64)

        def velocity(s: float) -> FloatArray:
            u = finite("ProfileCurrent", "the profile's velocity", self.profile(np.log(s) / (2 * k)))
            if u.shape != (k.size, 2):
                raise LeakrefError("ProfileCurrent", f"the profile returned shape {u.shape} for {k.size} depths",
                                   "return (n, 2) velocities for (n,) depths z <= 0")
            return u

        integral, error = quad_vec(velocity, 0.0, 1.0, epsabs=self.tolerance, epsrel=self.tolerance, limit=2000)
        if not error <= 100 * self.tolerance * max(1.0, float(np.abs(integral).max(initial=0.0))):
            raise LeakrefError("ProfileCurrent", f"the integral of eq:SJ is uncertain by {error:.1e}",
                               "smooth the profile or pass a larger tolerance")
        return np.asarray(integral)


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
