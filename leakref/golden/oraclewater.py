"""The high-precision oracle of water: dispersion and the Doppler shift over a depth, part of `golden.oracle`.

It shares only the formulas of the papers with the chain, and writes them otherwise: the group velocity is the
derivative of omega0, the depth factor its definition by two spectra, and a Doppler shift an integral over depth.
Numbers are mpmath's, at the precision that is set by the caller; a `depth` of None is water without a bottom.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mpmath import mp, mpf

__all__ = ["depth_factor", "dispersion", "doppler", "group_velocity"]

Number = Any  # mpf or mpc


def dispersion(k: Number, gravity: Number = 1, depth: Number | None = None, surface_tension: Number = 0) -> Number:
    """omega0 of sec:theory. omega0^2 = g k in deep water, else (g k + S k^3) tanh(k h) with S over density."""
    k = mpf(k)
    deep = mpf(gravity) * k + mpf(surface_tension) * k**3
    if depth is None:
        return mp.sqrt(deep)
    falling = mp.exp(-2 * k * mpf(depth))
    return mp.sqrt(deep * (1 - falling) / (1 + falling))


def group_velocity(k: Number, *water: Any) -> Number:
    """d omega0 / d k, differentiated numerically. `water` is what `dispersion` takes after k."""
    k = mpf(k)
    return mp.diff(lambda s: dispersion(k * s, *water), 1) / k  # in units of k, so that steps suit every k


def depth_factor(k: Number, depth: Number | None) -> Number:
    """Bouws et al. 1985. k^-3 dk / domega with the bottom over the same without, both at omega0(k) of gravity waves.

    Spectra of one shape over wavenumbers, k^-3, are what is compared; gravity drops out.
    """
    if depth is None:
        return mpf(1)
    omega = dispersion(k, 1, depth)
    without = omega**2  # the wavenumber that has this frequency in deep water
    return (mpf(k) ** -3 / group_velocity(k, 1, depth)) / (without**-3 / group_velocity(without, 1))


def doppler(current: Mapping[str, Any], k: Number, depth: Number | None = None) -> tuple[Number, Number]:
    """eq:SJ, 2k times the integral of U(z) exp(2kz) over z <= 0, by quadrature; or above a bottom, of U(z) cosh(2k(z +
    h)) over -h < z < 0, over the integral of the cosh alone.

    Substituted is s = exp(2 k z) without a bottom, so that the half line becomes 0 to 1; with one nothing is.
    """
    k = mpf(k)

    def component(axis: int) -> Number:
        if depth is not None:
            h = mpf(depth)
            pieces = [-h, *(-min(h, n / k) * mpf(9) / 10 for n in (8, 4, 2, 1, mpf(1) / 4)), 0]
            pieces = sorted(set(pieces))
            seen = [
                mp.quad(lambda z, u=u: u(z) * mp.cosh(2 * k * (z + h)) / mp.cosh(2 * k * h), pieces)
                for u in (lambda z: _profile(current, z)[axis], lambda z: mpf(1))
            ]
            return seen[0] / seen[1]
        pieces = [0, mpf(1) / 1000, mpf(1) / 20, mpf(1) / 2, 1]
        return mp.quad(lambda s: _profile(current, mp.log(s) / (2 * k))[axis], pieces)

    return component(0), component(1)


def _profile(current: Mapping[str, Any], z: Number) -> tuple[Number, Number]:
    """U(z), z <= 0, of the kinds described in golden/README.md."""
    u, v = (mpf(value) for value in current.get("velocity", (0, 0)))
    su, sv = (mpf(value) for value in current.get("shear", (0, 0)))
    layers = [(mpf(a), mpf(b), mpf(depth)) for a, b, depth in current.get("layers", ())]
    return (
        u + su * z + mp.fsum(a * mp.exp(z / d) for a, _, d in layers),
        v + sv * z + mp.fsum(b * mp.exp(z / d) for _, b, d in layers),
    )
