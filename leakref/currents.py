"""What shifts waves: currents over depth, and the Doppler shift velocity of each.

To first order in the current U(z) a wave of wavenumber k is shifted by its mean over depth, in water of depth h (Skop
1987, doi 10.1061/(ASCE)0733-950X(1987)113:2(187); Kirby and Chen 1989, doi 10.1029/JC094iC01p01013)

    c(k) = 2 k / sinh(2 k h) * integral over -h < z < 0 of U(z) cosh(2 k (z + h)) dz,

of which eq:SJ (equation 3) is the limit of deep water,

    c(k) = 2 k * integral over z < 0 of U(z) exp(2 k z) dz,

with k in rad per length, z in lengths, upwards from the surface, and U and c in lengths per time. Surface tension does
not enter. Everything here is of first order. For a linear current of shear s along the wave an exact relation exists,
sigma^2 + s sigma tanh(k h) = omega0^2 with sigma = omega - k.U(0): the first order is off from it by
(s tanh(k h))^2 / 8 omega0 k, to leading order.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, LeakrefError, finite, positive, vector
from leakref.dispersion import DEEP, Water

__all__ = [
    "Current",
    "ExponentialCurrent",
    "LinearCurrent",
    "ProfileCurrent",
    "UniformCurrent",
    "is_current",
    "shift_in",
    "weight",
]


class Current(Protocol):
    """Anything that shifts waves: a Doppler shift velocity (n, 2) for wavenumbers (n,).

    One that is used in water with a bottom takes the `water` as a second argument, see `shift_in`.
    """

    def doppler_shift_velocity(self, wavenumber: FloatArray) -> FloatArray: ...


def weight(wavenumber: npt.ArrayLike, z: npt.ArrayLike, water: Water = DEEP) -> FloatArray:
    """How much the current at height z <= 0 counts: 2 k cosh(2 k (z + h)) / sinh(2 k h), per length.

    Its integral over depth is 1. `wavenumber` and `z` of any shapes that go together; without overflow, and to all
    digits in shallow water: 2 k exp(2 k z) (1 + exp(-4 k (z + h))) / (1 - exp(-4 k h)).
    """
    k, z = np.asarray(wavenumber, dtype=np.float64), np.asarray(z, dtype=np.float64)
    return 2 * k * np.exp(2 * k * z) * (1 + np.exp(-4 * k * (z + water.depth))) / -np.expm1(-4 * k * water.depth)


def is_current(call: str, current: object) -> None:
    """Refuse what has no `doppler_shift_velocity`, in the name of `call`."""
    if not hasattr(current, "doppler_shift_velocity"):
        remedy = "give UniformCurrent((Ux, Uy)), or another one with a doppler_shift_velocity"
        raise LeakrefError(call, f"current = {current!r} is no current", remedy)


def shift_in(call: str, current: Current, wavenumber: FloatArray, water: Water) -> FloatArray:
    """The Doppler shift velocity (n, 2) of any current for wavenumbers (n,) in `water`, with the bottom it has.

    Where there is no bottom the current is asked with the wavenumbers alone. Raises LeakrefError in the name of `call`
    if it does not take the water where there is one, or gives anything but (n, 2) finite numbers.
    """
    asked = (wavenumber,) if water.depth == np.inf else (wavenumber, water)
    try:
        inspect.signature(current.doppler_shift_velocity).bind(*asked)
    except TypeError:
        fault = f"{type(current).__name__} knows no bottom, and the water is {water.depth:g} deep"
        raise LeakrefError(call, fault, "let its doppler_shift_velocity take (wavenumber, water)") from None
    shift = finite(call, "the Doppler shift velocity", current.doppler_shift_velocity(*asked))
    if shift.shape != (wavenumber.size, 2):
        fault = f"the current gave velocities of shape {shift.shape} for {wavenumber.size} wavenumbers"
        raise LeakrefError(call, fault, "give two components (x, y) for each")
    return shift


@dataclass(frozen=True)
class UniformCurrent:
    """The same `velocity` (Ux, Uy) at every depth: every wave is shifted by it."""

    velocity: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        vector("UniformCurrent", velocity=self.velocity)

    def doppler_shift_velocity(self, wavenumber: FloatArray, water: Water = DEEP) -> FloatArray:
        """(n, 2), the velocity itself whatever the wavenumber and the water."""
        return np.broadcast_to(np.asarray(self.velocity, dtype=np.float64), (np.size(wavenumber), 2))


@dataclass(frozen=True)
class LinearCurrent:
    """U(z) = surface + shear z for z <= 0; in closed form its shift is surface - shear tanh(k h) / 2k.

    `surface` in lengths per time, `shear` per time, two components (x, y) each. Raises LeakrefError otherwise.
    """

    surface: tuple[float, float]
    shear: tuple[float, float]

    def __post_init__(self) -> None:
        vector("LinearCurrent", surface=self.surface, shear=self.shear)

    def doppler_shift_velocity(self, wavenumber: FloatArray, water: Water = DEEP) -> FloatArray:
        """The integral above, (n, 2), to first order in the shear; eq:SJ, surface - shear / 2k, in deep water."""
        k = np.asarray(wavenumber, dtype=np.float64)[:, None]
        return np.asarray(self.surface) - np.asarray(self.shear) * np.tanh(k * water.depth) / (2 * k)


@dataclass(frozen=True)
class ExponentialCurrent:
    """U(z) = surface exp(z / depth); in closed form its shift in deep water is surface 2kd / (1 + 2kd).

    `surface` (x, y) in lengths per time; `depth` d, over which the current decays, in lengths: it is not that of the
    water. Raises LeakrefError for a surface that is not two numbers and a depth that is not positive.
    """

    surface: tuple[float, float]
    depth: float

    def __post_init__(self) -> None:
        vector("ExponentialCurrent", surface=self.surface)
        positive("ExponentialCurrent", depth=self.depth)

    def doppler_shift_velocity(self, wavenumber: FloatArray, water: Water = DEEP) -> FloatArray:
        """The integral above, (n, 2); eq:SJ in deep water.

        With p = 1 / d, q = 2 k and water of depth h it is the surface's velocity times

            q / sinh(q h) (p cosh(q h) - q sinh(q h) - p exp(-p h)) / (p^2 - q^2),

        which is written as a sum of positive terms, so that nothing cancels near p = q and nothing overflows:

            q h / (1 - exp(-2 q h)) (f((p + q) h) + exp(-(q + min(p, q)) h) f(|p - q| h)), f(x) = (1 - exp(-x)) / x.
        """
        kd = 2 * np.asarray(wavenumber, dtype=np.float64)[:, None] * self.depth
        if water.depth == np.inf:
            return np.asarray(self.surface) * kd / (1 + kd)
        ph = water.depth / self.depth
        qh = kd * ph
        share = _mean_decay(ph + qh) + np.exp(-(qh + np.minimum(ph, qh))) * _mean_decay(np.abs(ph - qh))
        return np.asarray(self.surface) * qh / -np.expm1(-2 * qh) * share


def _mean_decay(x: FloatArray) -> FloatArray:
    """(1 - exp(-x)) / x, the mean of exp(-x) over 0 to x: 1 at 0."""
    x = np.maximum(x, 1e-300)
    return -np.expm1(-x) / x


@dataclass(frozen=True)
class ProfileCurrent:
    """Any `profile`: heights z <= 0 (n,) to velocities (n, 2); the integral above by adaptive quadrature.

    With s = exp(2kz), or sinh(2k(z + h)) / sinh(2kh) above a bottom, the integral is that of U(z(s)) over 0 < s < 1:
    every wavenumber sees the same interval, and all are integrated together. `tolerance` is relative to velocities
    above 1, and absolute below.
    """

    profile: Callable[[FloatArray], npt.ArrayLike]
    tolerance: float = 1e-12

    def doppler_shift_velocity(self, wavenumber: FloatArray, water: Water = DEEP) -> FloatArray:
        """The integral, (n, 2). Raises LeakrefError if the profile has another shape or is not finite."""
        k = np.asarray(wavenumber, dtype=np.float64)

        def velocity(s: float) -> FloatArray:
            u = finite("ProfileCurrent", "the profile's velocity", self.profile(_height(s, k, water.depth)))
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


def _height(share: float, k: FloatArray, depth: float) -> FloatArray:
    """The z below which there is a `share` of the weight of a wave, (n,): 0 for 1, the bottom for 0.

    log(share) / 2k in deep water. Above a bottom it is asinh(share sinh(2kh)) / 2k - h, written so that sinh cannot
    overflow where 2kh is large.
    """
    double = 2 * k * depth
    half, end = -share * np.expm1(-2 * double) / 2, np.exp(-double)  # share sinh and 1, both over exp(2kh)
    shallow = np.arcsinh(share * np.sinh(np.minimum(double, 1.0))) / (2 * k) - depth
    return np.where(double < 1, shallow, np.log(half + np.hypot(half, end)) / (2 * k))
