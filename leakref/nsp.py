"""The normalized scalar product: the current whose dispersion surface overlaps best with the spectrum.

Of a Doppler shift velocity c it is (eq:normSp, equation 16, with eq:DSVkernel, equation 14; decisions D2, D6, D18)

    N(c) = <G F> / (<G> <F>),
    G(c) = exp(-2 ((omega - omega0 - k.c) / a)^2) + exp(-2 ((omega + omega0 - k.c) / a)^2).

<.> is the mean over the bins of a shell, F their magnitude, k their wave vector in rad per length, omega their
frequency in rad per time, omega0 that of a wave of |k| in still water, and a = 4 domega the width of G, domega the
width of a bin. The velocity that is measured is the c in lengths per time where N is largest.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt
from scipy.ndimage import maximum_filter
from scipy.optimize import minimize

from leakref._base import FloatArray, positive
from leakref.dispersion import Water, law, velocity_unit
from leakref.shell import HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers, collect, nothing, shell_at
from leakref.spectrum import Spectrum

__all__ = [
    "START", "UNKNOWN", "WIDTH", "another_basin", "characteristic_function", "extract", "leaves_the_band",
    "normalized_scalar_product", "optimum", "remarks", "score_derivatives", "score_range", "tabulated",
]  # fmt: skip

WIDTH = 4.0
"""a of eq:DSVkernel in domega (sec:parameters)."""
START = 2.5e-4
"""Side of Nelder-Mead's first simplex in c0: SciPy's default for a start at zero (decision D6)."""
UNKNOWN = 1e-9
"""Curvature of the score in its soft direction over that in the stiff one: below, only rounding fixes the optimum."""
_REACH = 1.2  # in c0: other basins are looked for up to here
_SOFT = 0.05  # c0^2 times curvature over N: below, the optimum is flat
_FEW = 8


def _centres(shell: Shell, velocity: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Where the two branches of the dispersion surface cross each column, (n,) each.

    eq:SnJ, and the mirror image of it in which a real signal appears: -omega_DR(-k) = k.c - omega0 (decision
    D2; as printed the second is -omega_DR(k), which no real signal has).
    """
    u, v = np.asarray(velocity, dtype=np.float64)
    shift = shell.kx * u + shell.ky * v
    return shell.intrinsic + shift, -shell.intrinsic + shift


def leaves_the_band(centres: FloatArray, last: float) -> bool:
    """Whether most `centres` (n,) are past the `last` frequency: what G then rests on says nothing of the velocity."""
    return bool(np.mean(np.abs(centres) > last) > 0.5)


def remarks(bins: int, soft: float, score: float, unit: float, beyond: bool) -> Note:
    """What is to be said of an optimum: of so many bins in the plane, `soft` curvature, and `beyond` reach or not."""
    note = Note.TOO_FEW_BINS if bins < _FEW else Note.NONE
    note |= Note.FLAT if soft * unit**2 < _SOFT * score else Note.NONE
    return note | (Note.EDGE if beyond else Note.NONE)


def characteristic_function(shell: Shell, velocity: npt.ArrayLike, width: float) -> FloatArray:
    """G of eq:DSVkernel on the bins of the shell, (n, nw); `width` is a, in rad per unit time."""
    positive_branch, negative_branch = (
        np.exp(-2 * ((shell.omega - centre[:, None]) / width) ** 2) for centre in _centres(shell, velocity)
    )
    return positive_branch + negative_branch


def normalized_scalar_product(shell: Shell, velocity: npt.ArrayLike, width: float) -> float:
    """N of eq:normSp with means over the bins, so that it has no scale (decisions D6, D18)."""
    g = characteristic_function(shell, velocity, width)
    count = shell.kx.size * shell.weight.sum()
    overlap, total, energy = (float(np.sum(v @ shell.weight)) for v in (g * shell.magnitude, g, shell.magnitude))
    return overlap / (total * energy) * float(count) if total > 0 else 0.0  # else G has left the spectrum


def score_derivatives(shell: Shell, velocity: npt.ArrayLike, width: float) -> tuple[float, FloatArray, FloatArray]:
    """N, its gradient (2,) and its Hessian (2, 2) with respect to the velocity.

    The velocity only moves the centres of the Gaussians, by k.c: with z = (omega - centre) / a,
    dG/dc = 4 z / a G k and d2G/dc2 = (16 z^2 - 4) / a^2 G k k^T.
    """
    k = np.stack([shell.kx, shell.ky])
    top, bottom = np.zeros((3, k.shape[1])), np.zeros((3, k.shape[1]))  # sums over omega: 0th, 1st, 2nd derivative
    for centre in _centres(shell, velocity):
        z = (shell.omega - centre[:, None]) / width
        g = np.exp(-2 * z**2) * shell.weight
        for order, term in enumerate((g, 4 * z / width * g, (16 * z**2 - 4) / width**2 * g)):
            top[order] += np.einsum("nw,nw->n", term, shell.magnitude)
            bottom[order] += term.sum(axis=1)
    if not (bottom[0].any() and top[0].any()):  # G has left the spectrum, or all that is in it
        return 0.0, np.zeros(2), np.zeros((2, 2))
    norm = k.shape[1] * shell.weight.sum() / np.sum(shell.magnitude @ shell.weight)
    (a, da, dda), (b, db, ddb) = ((s[0].sum(), k @ s[1], (k * s[2]) @ k.T) for s in (top, bottom))
    n = a / b * norm
    slope = da / a - db / b  # of log N
    bend = dda / a - np.outer(da / a, da / a) - ddb / b + np.outer(db / b, db / b)
    return float(n), n * slope, n * (bend + np.outer(slope, slope))


def _ascend(shell: Shell, velocity: FloatArray, width: float, unit: float) -> tuple[FloatArray, int, bool]:
    """Newton's method to where the gradient vanishes: velocity, evaluations, and whether it got there.

    Steps go uphill in each principal direction of the Hessian, at most a quarter of the width, and not at all
    where the score does not depend on the velocity (one wave, box window).
    """
    for count in range(1, 60):
        _, gradient, hessian = score_derivatives(shell, velocity, width)
        curvature, axes = np.linalg.eigh(hessian)
        stiff = np.abs(curvature) > UNKNOWN * np.abs(curvature).max(initial=0.0)
        step = axes[:, stiff] @ ((axes.T @ gradient)[stiff] / np.abs(curvature[stiff]))
        length = float(np.hypot(*step))
        if not np.isfinite(length):
            break
        velocity = velocity + step * min(1.0, width / (4 * shell.wavenumber * max(length, 1e-300)))
        if length < 1e-13 * unit or (count > 20 and length < 1e-11 * unit):
            return velocity, count, bool(curvature.max() <= 1e-9 * np.abs(curvature).max() and curvature.min() < 0)
    return velocity, count, False


def score_range(shell: Shell, width: float, unit: float) -> float:
    """The largest |c| at which the score still means something: past it G leaves the Nyquist range."""
    return min(_REACH * unit, (float(shell.omega[-1]) - shell.frequency - 3 * width) / shell.wavenumber)


def tabulated(shell: Shell, velocities: FloatArray, width: float) -> FloatArray:
    """N, up to a factor, at many velocities (n, 2) at once, to about a percent: good enough to look for basins.

    A column's part of the products depends on the velocity only through the centre of its Gaussian, so both
    products are tabulated over the centre, an eighth of the width apart, and read off.
    """
    step, offset = width / 8, shell.omega[-1] + 5 * width
    centres = np.arange(-offset, offset + step, step)
    g = np.exp(-2 * ((shell.omega[:, None] - centres) / width) ** 2) * shell.weight[:, None]
    top, bottom = shell.magnitude @ g, g.sum(axis=0)
    column, result = np.arange(shell.kx.size), np.empty(len(velocities))
    for start in range(0, len(velocities), 256):
        c = velocities[start : start + 256]
        shift = np.outer(c[:, 0], shell.kx) + np.outer(c[:, 1], shell.ky)
        a, b = np.zeros(len(c)), np.zeros(len(c))
        for branch in (shell.intrinsic, -shell.intrinsic):
            near = np.clip(np.rint((shift + branch + offset) / step).astype(np.intp), 0, centres.size - 1)
            a += top[column, near].sum(axis=1)
            b += bottom[near].sum(axis=1)
        result[start : start + 256] = a / b
    return result


def another_basin(shell: Shell, found: FloatArray, score: float, width: float, unit: float) -> bool:
    """Whether some other maximum within reach scores higher: a search on a lattice of half widths, then Newton."""
    reach, spacing = score_range(shell, width, unit), width / (2 * shell.wavenumber)
    if reach <= 0:
        return False
    m = int(np.ceil(reach / spacing))
    lattice = np.moveaxis(np.mgrid[-m : m + 1, -m : m + 1], 0, -1) * spacing
    inside = np.hypot(lattice[..., 0], lattice[..., 1]) <= reach
    scores = np.full(inside.shape, -np.inf)
    scores[inside] = tabulated(shell, lattice[inside], width)
    own = tabulated(shell, found[None, :], width)[0]
    peaks = (scores == maximum_filter(scores, 3)) & (scores > 0.85 * own)
    peaks &= np.hypot(*np.moveaxis(lattice - found, -1, 0)) > spacing
    for index in np.argwhere(peaks)[np.argsort(-scores[peaks], kind="stable")][:6]:
        other, _, arrived = _ascend(shell, lattice[tuple(index)], width, unit)
        higher = normalized_scalar_product(shell, other, width) > score * (1 + 1e-9)
        if arrived and higher and np.hypot(*other) <= reach:
            return True
    return False


def optimum(
    shell: Shell, width: float, unit: float, *, search: bool = True, start: npt.ArrayLike = (0.0, 0.0)
) -> Optimum:
    """The maximum of N that Nelder-Mead reaches from rest, polished until the gradient vanishes (decision D6).

    `width` is a, `unit` c0, `start` another start in c0. With `search` other basins are looked for (ANOTHER_BASIN).
    """
    if shell.is_empty:
        return nothing(Note.NO_SIGNAL)
    simplex = np.array([[0.0, 0.0], [START, 0.0], [0.0, START]]) + np.asarray(start)
    options = {"initial_simplex": simplex, "xatol": 1e-8, "fatol": np.inf, "maxfev": 5000, "maxiter": 5000}
    fit = minimize(
        lambda c: -normalized_scalar_product(shell, c * unit, width), simplex[0], method="Nelder-Mead", options=options
    )
    velocity, steps, arrived = _ascend(shell, fit.x * unit, width, unit)
    evaluations = int(fit.nfev) + steps
    has_left = leaves_the_band(_centres(shell, velocity)[0], shell.omega[-1])
    if not arrived:
        return nothing(Note.EDGE if has_left else Note.UNCONVERGED, evaluations)
    score, gradient, hessian = score_derivatives(shell, velocity, width)
    soft, stiff = np.linalg.eigvalsh(-hessian)
    beyond = np.hypot(*velocity) > score_range(shell, width, unit)
    if beyond and (has_left or soft <= UNKNOWN * stiff):
        return nothing(Note.EDGE, evaluations)
    near = np.any([np.abs(shell.omega - centre[:, None]) <= width for centre in _centres(shell, velocity)], axis=0)
    note = shell.notes(near) | remarks(shell.kx.size, soft, score, unit, bool(beyond))
    if search and another_basin(shell, velocity, score, width, unit):
        note |= Note.ANOTHER_BASIN
    return Optimum(velocity, score, gradient, hessian, evaluations, note)


def extract(
    spectrum: Spectrum,
    wavenumbers: npt.ArrayLike,
    *,
    gravity: float | None = None,
    water: Water | None = None,
    peak_wavenumber: float | None = None,
    width: float = WIDTH,
    half_width: float = HALF_WIDTH,
    search: bool = True,
) -> Extraction:
    """Doppler shift velocities by the normalized scalar product (sec:NSP), one for each wavenumber (n,).

    `water` is the law of dispersion, or `gravity` that of deep water: one of them is given. `width` a in domega,
    `half_width` of a shell in dk; `peak_wavenumber` k0 sets the unit of the search (see `velocity_unit`). Shells are
    taken one at a time, so memory does not grow with their number. Raises LeakrefError.
    """
    k = checked_wavenumbers(wavenumbers, "nsp.extract")
    peak = {} if peak_wavenumber is None else {"peak_wavenumber": peak_wavenumber}
    positive("nsp.extract", width=width, half_width=half_width, **peak)
    a, water = width * spectrum.grid.frequency_resolution, law("nsp.extract", gravity, water)
    shell = partial(shell_at, spectrum, water=water, half_width=half_width)  # one at a time
    found = [optimum(shell(k_i), a, velocity_unit(k_i, water, peak_wavenumber), search=search) for k_i in k]
    return collect("nsp", k, found)
