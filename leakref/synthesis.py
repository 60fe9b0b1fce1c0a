"""From waves to a surface, as matrix products.

eta(x, y, t) = sum over waves of a cos(kx x + ky y - omega t + phase) has one term for each wave and sample, far too
many to form. On a lattice of waves the sum over ky is one product of matrices for each kx, and that over kx another.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, LeakrefError, finite
from leakref.sea import Components

__all__ = ["synthesize"]

_BUFFER = 2**24  # complex numbers held besides the surface itself


def synthesize(
    components: Components, x: npt.ArrayLike, y: npt.ArrayLike, t: npt.ArrayLike, *, out: FloatArray | None = None
) -> FloatArray:
    """The surface eta[x, y, t] = sum of a cos(kx x + ky y - omega t + phase), shape (nx, ny, nt), float64.

    `x`, `y`, `t` are the coordinates of the samples, (nx,), (ny,), (nt,). The sum over ky is a matrix product
    for each kx and block of times, that over kx a real one (the imaginary part is not wanted). Memory: the
    surface (`out`, if given, for instance memory-mapped) and a buffer of some hundred MB at most.
    """
    x, y, t = (finite("synthesize", name, v, 1) for name, v in (("x", x), ("y", y), ("t", t)))
    shape = (x.size, y.size, t.size)
    if not all(shape):
        raise LeakrefError("synthesize", f"no samples along one of {shape}", "give at least one x, y and t")
    eta = np.empty(shape) if out is None else out
    if eta.shape != shape or eta.dtype != np.float64:
        raise LeakrefError("synthesize", f"out has shape {eta.shape} of {eta.dtype}", f"pass shape {shape} of float64")
    waves = components.amplitude * np.exp(1j * components.phase)
    lattice = components.separated()
    kx, i, ky, j = lattice if lattice is not None else (components.kx, None, components.ky, None)
    ex, ey = np.exp(1j * np.outer(x, kx)), np.exp(1j * np.outer(y, ky))
    ex_real = np.hstack([ex.real, -ex.imag])
    step = max(1, _BUFFER // (kx.size * max(2 * y.size, ky.size if lattice else 1)))
    for start in range(0, t.size, step):
        times = t[start : start + step]
        moving = waves[:, None] * np.exp(-1j * np.outer(components.omega, times))
        if lattice is None:  # every wave has a kx of its own
            along_y = ey.T[:, :, None] * moving[:, None, :]
        else:
            matrix = np.zeros((kx.size, ky.size, times.size), dtype=np.complex128)
            matrix[i, j] = moving
            along_y = ey @ matrix
        stacked = np.concatenate([along_y.real, along_y.imag]).reshape(2 * kx.size, -1)
        eta[:, :, start : start + step] = (ex_real @ stacked).reshape(x.size, y.size, -1)
    return eta
