"""What shifts waves: currents over depth, and the Doppler shift velocity of each.

To first order in the current U(z) a wave of wavenumber k is shifted by its mean over depth (eq:SJ, equation 3),

    c(k) = 2 k * integral over z < 0 of U(z) exp(2 k z) dz,

with k in rad per length, z in lengths, upwards from the surface, and U and c in lengths per time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, LeakrefError, finite, positive, vector

__all__ = ["Current", "ExponentialCurrent", "LinearCurrent", "ProfileCurrent", "UniformCurrent"]


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
                raise LeakrefError(
                    "ProfileCurrent",
                    f"the profile returned shape {u.shape} for {k.size} depths",
                    "return (n, 2) velocities for (n,) depths z <= 0",
                )
            return u

        from scipy.integrate import quad_vec  # for profiles alone: it takes as long to import as all the rest

        integral, error = quad_vec(velocity, 0.0, 1.0, epsabs=self.tolerance, epsrel=self.tolerance, limit=2000)
        if not error <= 100 * self.tolerance * max(1.0, float(np.abs(integral).max(initial=0.0))):
            raise LeakrefError(
                "ProfileCurrent",
                f"the integral of eq:SJ is uncertain by {error:.1e}",
                "smooth the profile or pass a larger tolerance",
            )
        return np.asarray(integral)
