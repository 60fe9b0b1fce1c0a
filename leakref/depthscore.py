# mypy: disallow-untyped-defs=False
"""N over a current and a depth, compiled, with its derivatives, and how to climb it: the equation of `depth`.

    N(c, h) = <G F> / (<G> <F>),    G(c, h) = the sum over both signs of exp(-2 ((omega -+ omega0(k; h) - k.c) / a)^2)

over the bins of a shell, however wide; derivatives are with respect to (cx, cy, ln h). omega0^2 is a function of k
times tanh(k h), whatever gravity and surface tension, so that

    d omega0 / d ln h = omega0 r,    r = k h / sinh(2 k h),    d ln r / d ln h = 1 - 2 k h / tanh(2 k h).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from leakref._base import FloatArray, positive
from leakref._caches import njit
from leakref.dispersion import Water
from leakref.nsp import UNKNOWN
from leakref.shell import Shell

__all__ = ["Score", "depth_resolutions", "derivatives"]

_CUT = 4.25  # widths, where the Gaussian ends: 1e-15 of it is left
_COARSE = 0.25  # step of a scan in ln h where waves hardly feel the bottom
_STRONGEST = 400  # columns that choose where to start
_STEPS = 80
_AWAY = 3.0  # in ln h from where it began: a climb that goes as far has left for where no bottom is felt
_compiled: Any = njit(nogil=True, error_model="numpy")


def depth_resolutions(
    wavenumber: npt.ArrayLike, wavenumber_resolution: float, frequency_resolution: float, water: Water
) -> tuple[FloatArray, FloatArray]:
    """By what part of itself h changes where the dispersion surface moves by one bin: eq:dcdwk for a depth.

    domega / (d omega0 / d ln h) from frequency, and (d omega0 / d k) dk / (d omega0 / d ln h) from wavenumber, each of
    the shape of `wavenumber`. Raises LeakrefError.
    """
    k = np.asarray(wavenumber, dtype=np.float64)
    positive("depth_resolutions", wavenumber=k.ravel(), depth=water.depth)
    slope = _frequencies(k.ravel(), water)[1].reshape(k.shape)
    return frequency_resolution / slope, water.group_velocity(k) * wavenumber_resolution / slope


def _frequencies(wavenumber: FloatArray, water: Water) -> tuple[FloatArray, FloatArray, FloatArray]:
    """omega0 (n,) and its first and second derivatives with respect to ln h.

    omega0^2 is a function of k times tanh(k h), so that d ln omega0 / d ln h = k h / sinh(2 k h) = r, whatever gravity
    and tension, and d ln r / d ln h = 1 - 2 k h / tanh(2 k h).
    """
    omega, twice = water.frequency(wavenumber), np.clip(2 * wavenumber * water.depth, 1e-9, 700.0)
    r = twice / (2 * np.sinh(twice))
    return omega, omega * r, omega * r * (r + 1 - twice / np.tanh(twice))


@_compiled
def _sums(magnitude, weight, kx, ky, still, slope, bend, c, width, out):
    """Sums over all bins of G F and of G, (2, 10) each row the value, its gradient (3) and second derivatives (6).

    With respect to (cx, cy, ln h), in the order xx, xy, yy, xh, yh, hh. Frequencies are counted in bins; a Gaussian
    moved by t changes as dG/dt = 4 z / a G and d2G/dt2 = (16 z^2 - 4) / a^2 G, z being the distance over the width a.
    Along the bins G follows from its neighbour by two products.
    """
    out[:] = 0.0
    last = magnitude.shape[1] - 1
    for n in range(kx.size):
        for sign in (1.0, -1.0):
            centre = sign * still[n] + kx[n] * c[0] + ky[n] * c[1]
            first = max(0, int(np.ceil(centre - _CUT * width)))
            end = min(last, int(np.floor(centre + _CUT * width)))
            if first > end:
                continue
            z = (first - centre) / width
            g, rise, turn = np.exp(-2 * z * z), np.exp(-(4 * z + 2 / width) / width), np.exp(-4 / width**2)
            a = da = dda = b = db = ddb = 0.0
            for m in range(first, end + 1):
                z = (m - centre) / width
                one = g * weight[m]
                moved, twice = 4 * z / width * one, (16 * z * z - 4) / width**2 * one
                f = magnitude[n, m]
                a, da, dda = a + one * f, da + moved * f, dda + twice * f
                b, db, ddb = b + one, db + moved, ddb + twice
                g *= rise
                rise *= turn
            u, v, h = kx[n], ky[n], sign * slope[n]
            for row, s, d, dd in ((0, a, da, dda), (1, b, db, ddb)):
                out[row, 0] += s
                out[row, 1] += d * u
                out[row, 2] += d * v
                out[row, 3] += d * h
                out[row, 4] += dd * u * u
                out[row, 5] += dd * u * v
                out[row, 6] += dd * v * v
                out[row, 7] += dd * u * h
                out[row, 8] += dd * v * h
                out[row, 9] += dd * h * h + d * sign * bend[n]


class Score:
    """N over (cx, cy, ln h) on the columns of a shell, and how to climb it; `water` gives gravity and tension.

    Velocities are in `unit`, so that the three arguments are of one size; inside, frequencies are in bins.
    """

    def __init__(self, shell: Shell, water: Water, width: float, unit: float) -> None:
        self.water, self.unit, self.step = water, unit, float(shell.omega[1] - shell.omega[0])
        self.k, self.width = np.hypot(shell.kx, shell.ky), width / self.step
        self.kx, self.ky = (k * unit / self.step for k in (shell.kx, shell.ky))
        self.magnitude, self.weight = np.ascontiguousarray(shell.magnitude), shell.weight
        self.energy = self.magnitude @ self.weight
        self.norm = self.k.size * self.weight.sum() / max(float(self.energy.sum()), 1e-300)
        self.evaluations = 0

    def strongest(self) -> Score:
        """Of the columns with most in them only: good enough to choose where to start."""
        if self.k.size <= _STRONGEST:
            return self
        kept, few = np.sort(np.argsort(-self.energy, kind="stable")[:_STRONGEST]), object.__new__(Score)
        few.__dict__.update(self.__dict__)
        for name in ("k", "kx", "ky", "magnitude", "energy"):
            setattr(few, name, getattr(self, name)[kept])
        few.norm = kept.size * self.weight.sum() / max(float(few.energy.sum()), 1e-300)
        return few

    def waters(self, log_depth: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """omega0 of the columns and its derivatives with respect to ln h, in bins, (n,) each."""
        omega, slope, bend = _frequencies(self.k, replace(self.water, depth=float(np.exp(log_depth))))
        return omega / self.step, slope / self.step, bend / self.step

    def at(self, x: FloatArray, waters: tuple[FloatArray, FloatArray, FloatArray] | None = None) -> tuple[Any, ...]:
        """N, its gradient (3,) and Hessian (3, 3) at x = (cx, cy, ln h)."""
        self.evaluations += 1
        out = np.empty((2, 10))
        _sums(self.magnitude, self.weight, self.kx, self.ky, *(waters or self.waters(x[2])), x[:2], self.width, out)
        (a, b), square = out[:, 0], [[4, 5, 7], [5, 6, 8], [7, 8, 9]]
        if not (a > 0 and b > 0):  # G has left the spectrum, or all that is in it
            return 0.0, np.zeros(3), np.zeros((3, 3))
        da, db = out[0, 1:4] / a, out[1, 1:4] / b
        slope, n = da - db, a / b * self.norm
        bend = out[0][square] / a - np.outer(da, da) - out[1][square] / b + np.outer(db, db)
        return float(n), n * slope, n * (bend + np.outer(slope, slope))

    def climb(self, x: FloatArray, free: slice, close: float = 0.0) -> tuple[FloatArray, float, bool]:
        """Newton's method uphill from x in the arguments `free`: where it ends, N before the last step, and whether a
        maximum is there.

        No step moves the surface at any column by more than a quarter of the width, or h by more than a third; and none
        goes where the score does not depend on what is free. It ends where the gradient vanishes, or once a step moves
        the surface by less than `close` widths.
        """
        x, waters, n = x.copy(), None if free.stop == 3 else self.waters(x[2]), 0.0
        begun = x[2]
        for count in range(_STEPS):
            now = waters or self.waters(x[2])
            n, gradient, hessian = self.at(x, now)
            curvature, axes = np.linalg.eigh(hessian[free, free])
            stiff = np.abs(curvature) > UNKNOWN * np.abs(curvature).max(initial=0.0)
            step = np.zeros(3)
            step[free] = axes[:, stiff] @ ((axes.T @ gradient[free])[stiff] / np.abs(curvature[stiff]))
            size = float(np.abs(step).max())
            if not np.isfinite(size):
                break
            moved = float(np.abs(self.kx * step[0] + self.ky * step[1] + now[1] * step[2]).max())
            x += step * min(1.0, self.width / (4 * max(moved, 1e-300)), 1 / (3 * max(abs(step[2]), 1e-300)))
            if moved < close * self.width or abs(x[2] - begun) > _AWAY:
                break
            if size < 1e-13 or (count > 20 and size < 1e-11):
                return x, n, bool(curvature.max() <= 1e-9 * np.abs(curvature).max() and curvature.min() < 0)
        return x, n, False

    def scan(self, low: float, high: float, widths: float) -> FloatArray:
        """Values of ln h from `low` to `high`: from one to the next the surface moves by at most so many widths."""
        places = [low]
        while places[-1] < high:
            steepest = float(self.waters(places[-1])[1].max())
            places.append(places[-1] + min(_COARSE, widths * self.width / max(steepest, 1e-300)))
        return np.array([*places[:-1], high])


def derivatives(
    shell: Shell, water: Water, velocity: npt.ArrayLike, *, width: float
) -> tuple[float, FloatArray, FloatArray]:
    """N of the module's first equation at `velocity` (2,) and the depth of `water`; gradient (3,) and Hessian (3, 3).

    With respect to (cx, cy, ln h); `width` is a in rad per time.
    """
    x = np.array([*np.asarray(velocity, dtype=np.float64), np.log(water.depth)])
    n, gradient, hessian = Score(shell, water, width, 1.0).at(x)
    return n, gradient, hessian
