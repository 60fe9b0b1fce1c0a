# mypy: disallow-untyped-defs=False
"""Climbing the score of a shell, compiled: part of `leakref.fast`.

Around one velocity the score is a polynomial in the two components of the velocity. One pass over the columns of a
shell gives its coefficients (`_expand`); after that an evaluation costs the same whatever the size of the shell, so
that SciPy's Nelder-Mead can be followed step by step (`climb`). Frequencies are counted in bins, wavenumbers in bins
per velocity.

Why that is right: a Gaussian moved by t is a power series in t whose coefficients are Hermite functions (`hermite`),
and t is linear in the velocity. A moment of a column is therefore a sum over its bins that does not depend on the
velocity, and the score a quotient of two polynomials, good to 2e-11 within `_RADIUS` standard deviations. Beyond
that another expansion is made; moments are remembered by column and cell, and serve all shells that share the column.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from leakref._base import FloatArray, IntArray
from leakref._caches import njit

__all__ = ["DENSE", "ORDER", "Models", "Ring", "climb", "hermite", "models", "outdone", "principal", "scores"]

ORDER = 12  # of an expansion of the score: powers of the velocity below it
_MOMENTS = 16  # of a column around the middle of a cell: to rounding within the cell, to 2e-11 another _RADIUS away
_CELLS = 16  # of each column whose moments are remembered
_RADIUS = 0.3  # how far an expansion holds, to 2e-11, in standard deviations of the Gaussian
_CLOSE = 1e-4  # the same for one of order 4, to rounding; and the step in c0 after which Newton's method asks for one
DENSE = 3.0  # bins: from this width on the sampled Gaussian has a constant sum
_LOST = 1e-3  # what is left of G, below which the tails that `_CUT` cuts would decide
_CHUNK = 64  # columns at a time
_KEPT = 64  # expansions of one shell
_compiled: Any = njit(nogil=True, error_model="numpy")
_summing: Any = njit(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


class Ring(NamedTuple):
    """The columns of one shell and what is needed to sum over them. Frequencies in bins, k in bins per velocity."""

    magnitude: FloatArray  # F of all columns of the disc, (all, nw)
    columns: IntArray  # (n,): which of them
    kx: FloatArray
    ky: FloatArray
    centre: FloatArray  # omega0(k), (n,)
    largest: float  # of |k|
    wavenumber: float  # of the shell
    frequency: float  # omega0 there
    unit: float  # c0
    width: float
    even: bool  # whether the last bin is the Nyquist frequency, half of it a mirror image
    taps: FloatArray  # see `hermite`, (cells in a bin, 2 half + 1, _MOMENTS)
    binomials: FloatArray  # (ORDER, ORDER)


@_compiled
def _bins(ring, column, m, out):
    """F at the bins m ... m + len(out) - 1 of a column, negative ones from its mirror image; 1 for `column` < 0.

    The whole space, with the + branch only: the same sums as the half space with both (decision D5).
    """
    f = ring.magnitude
    top = f.shape[1] - 1
    for j in range(out.size):
        n = abs(m + j)
        if n > top:
            out[j] = 0.0
        else:
            out[j] = 1.0 if column < 0 else f[column if m + j >= 0 else f.shape[0] - 1 - column, n]
            if n == top and ring.even:
                out[j] *= 0.5


def hermite(width: float, half: int) -> FloatArray:
    """exp(-u^2 / 2) He_q(u) / q! at bins u, in deviations, from a cell's middle: (cells, 2 half + 1, _MOMENTS).

    The Gaussian at u - t is the sum over q of t^q times these. A cell is at most a quarter of the width.
    """
    cells = max(1, int(np.ceil(4 / width - 1e-9)))
    u = 2 / width * (np.arange(-half, half + 1) - np.arange(cells)[:, None] / cells)
    values = [np.exp(-(u**2) / 2), u * np.exp(-(u**2) / 2)]
    for q in range(2, _MOMENTS):
        values.append((u * values[-1] - values[-2]) / q)
    return np.ascontiguousarray(np.stack(values, axis=-1))


@_summing
def _moments(f, first, taps, out):
    """Sums of f[first + j] times each of taps[j], (n, _MOMENTS), five rows at a time to keep them in registers.

    It is a product of a vector and a matrix, written out, because it is called for single columns: too small for BLAS.
    """
    out[:] = 0.0
    for j in range(0, taps.shape[0], 5):
        a, b, c, d, e = f[first + j], f[first + j + 1], f[first + j + 2], f[first + j + 3], f[first + j + 4]
        for q in range(_MOMENTS):
            out[q] += (
                (a * taps[j, q] + b * taps[j + 1, q]) + (c * taps[j + 2, q] + d * taps[j + 3, q]) + e * taps[j + 4, q]
            )


@_summing
def _gather(moments, s, kx, ky, n, order, total):
    """Add to total[q, p] the sums over columns of kx^q ky^p times the coefficient of t^(q + p), q + p < `order`.

    `moments` (_MOMENTS + 2, n) are the coefficients around the middles of cells, and zeros, s the way from there to the
    centres. They are lost.

    The first loop moves the origin of each column's series from the middle of its cell to the centre of its Gaussian,
    by repeated Horner steps in place, and over many columns at once so that they vectorise. The second forms the sums.
    """
    px, py = np.empty((order, _CHUNK)), np.empty((order, _CHUNK))
    for i in range(n):
        px[0, i] = py[0, i] = 1.0
    for p in range(1, order):
        for i in range(n):
            px[p, i], py[p, i] = px[p - 1, i] * kx[i], py[p - 1, i] * ky[i]
    for p in range(order):
        for q in range(p + 3 * ((_MOMENTS + 1 - p) // 3) - 1, p, -3):  # three at a time, which is three times as fast
            for i in range(n):
                a = moments[q, i] + s[i] * moments[q + 1, i]
                b = moments[q - 1, i] + s[i] * a
                moments[q, i], moments[q - 1, i], moments[q - 2, i] = a, b, moments[q - 2, i] + s[i] * b
    for q in range(order):
        for p in range(order - q):
            part = 0.0
            for i in range(n):
                part += px[q, i] * py[p, i] * moments[q + p, i]
            total[q, p] += part


@_compiled
def _expand(ring, models, c, order, top, bottom):
    """Numerator and denominator of N around the velocity c: coefficients of x^q y^p, (ORDER, ORDER) each.

    x and y are the change of velocity times 2 largest / width; terms of `order` and beyond are left out. Away from
    the Nyquist frequency the denominator is constant to rounding, since the Gaussian is sampled densely. The moments
    of a column around the middle of a cell serve every expansion of every shell that comes by.
    """
    cells, size, _ = ring.taps.shape
    nw, half = ring.magnitude.shape[1], size // 2
    f, one, s = np.empty(size), np.empty(_MOMENTS), np.empty(_CHUNK)
    moments, ones = np.zeros((_MOMENTS + 2, _CHUNK)), np.zeros((_MOMENTS + 2, _CHUNK))
    centres = ring.centre + ring.kx * c[0] + ring.ky * c[1]
    top[:] = 0.0
    bottom[:] = 0.0
    clipped = ring.width < DENSE or np.abs(centres).max() > nw - 3 - half
    for start in range(0, centres.size, _CHUNK):
        n = min(_CHUNK, centres.size - start)
        for i in range(n):
            column, centre = ring.columns[start + i], min(max(centres[start + i], -2.0 * nw), 2.0 * nw)  # past the bins
            cell = int(np.rint(centre * cells))
            s[i] = 2 * (centre - cell / cells) / ring.width
            nearest = cell // cells
            first, taps = nearest - half, ring.taps[cell - nearest * cells]
            kept = models.moments[column, cell % _CELLS]
            if models.cells[column, cell % _CELLS] != cell:
                models.cells[column, cell % _CELLS] = cell
                if first < 0 or first + size >= nw:
                    _bins(ring, column, first, f)
                    _moments(f, 0, taps, kept)
                else:
                    _moments(ring.magnitude[column], first, taps, kept)
            for q in range(_MOMENTS):
                moments[q, i] = kept[q]
            if clipped:
                _bins(ring, -1, first, f)
                _moments(f, 0, taps, one)
                ones[:_MOMENTS, i] = one
        kx, ky = ring.kx[start : start + n] / ring.largest, ring.ky[start : start + n] / ring.largest
        _gather(moments, s, kx, ky, n, order, top)
        if clipped:
            _gather(ones, s, kx, ky, n, order, bottom)
    if not clipped:
        bottom[0, 0] = ring.columns.size * ring.width * np.sqrt(np.pi / 2)
    top *= ring.binomials
    bottom *= ring.binomials


@_compiled
def _value(a, x, y):
    """The polynomial with coefficients a of x^q y^p."""
    total = 0.0
    for q in range(ORDER - 1, -1, -1):
        row = 0.0
        for p in range(ORDER - 1 - q, -1, -1):
            row = row * y + a[q, p]
        total = total * x + row
    return total


@_compiled
def _slopes(a, x, y, scale):
    """The polynomial, its gradient and its second derivatives (xx, xy, yy), x and y being velocities times `scale`."""
    v = vx = vy = vxx = vxy = vyy = 0.0
    for q in range(ORDER - 1, -1, -1):
        r = ry = ryy = 0.0
        for p in range(ORDER - 1 - q, -1, -1):
            ryy, ry, r = ryy * y + 2 * ry, ry * y + r, r * y + a[q, p]
        vxx, vxy, vx, vyy, vy, v = vxx * x + 2 * vx, vxy * x + vy, vx * x + v, vyy * x + ryy, vy * x + ry, v * x + r
    return v, scale * vx, scale * vy, scale**2 * vxx, scale**2 * vxy, scale**2 * vyy


class Models(NamedTuple):
    """Expansions of the score of one shell, and moments of the columns of all, made where they are asked for."""

    centres: FloatArray  # (_KEPT, 2)
    radii: FloatArray  # (_KEPT,): how far they hold
    top: FloatArray  # (_KEPT, ORDER, ORDER)
    bottom: FloatArray
    made: IntArray  # how many, which was used last, and whether the search is lost (_score)
    cells: IntArray  # (columns, _CELLS): which one the moments are of
    moments: FloatArray  # (columns, _CELLS, _MOMENTS)


def models(columns: int) -> Models:
    """None yet."""
    return Models(
        np.empty((_KEPT, 2)),
        np.empty(_KEPT),
        np.empty((_KEPT, ORDER, ORDER)),
        np.empty((_KEPT, ORDER, ORDER)),
        np.zeros(3, dtype=np.int64),
        np.full((columns, _CELLS), np.iinfo(np.int64).min),
        np.empty((columns, _CELLS, _MOMENTS)),
    )


@_compiled
def _model(ring, models, c, radius, new):
    """The number of an expansion whose centre is within `radius` (of 2 k.c / width) of c, as far as it holds.

    If need be a `new` one is made, which holds that far.

    The one used last is tried first: a simplex moves little, so that the first try nearly always fits. When all places
    are taken the oldest expansion goes.
    """
    scale = 2 * ring.largest / ring.width
    made = models.made[0]
    for back in range(min(made, _KEPT)):
        n = (models.made[1] - back) % min(made, _KEPT)
        reach = min(radius, models.radii[n]) / scale
        if (models.centres[n, 0] - c[0]) ** 2 + (models.centres[n, 1] - c[1]) ** 2 <= reach * reach:
            models.made[1] = n
            return n
    n = made % _KEPT
    models.centres[n], models.radii[n] = c, new
    _expand(ring, models, c, ORDER if new > _CLOSE else 4, models.top[n], models.bottom[n])
    models.made[0], models.made[1] = made + 1, n
    return n


@_compiled
def _score(ring, models, c):
    """N up to a factor, at c. Where most of G has left the Nyquist range the search is noted as lost."""
    n = _model(ring, models, c, _RADIUS, _RADIUS)
    scale = 2 * ring.largest / ring.width
    x, y = (c[0] - models.centres[n, 0]) * scale, (c[1] - models.centres[n, 1]) * scale
    bottom = _value(models.bottom[n], x, y)
    if not bottom > _LOST * ring.columns.size * ring.width:
        models.made[2] = 1
        return 0.0
    return _value(models.top[n], x, y) / bottom


@_compiled
def _derivatives(ring, models, c, radius, new, out):
    """N up to a factor, gradient and second derivatives (xx, xy, yy) as in nsp.score_derivatives, out (6,).

    They are formed from those of log N, which for a quotient are differences.
    """
    n = _model(ring, models, c, radius, new)
    scale = 2 * ring.largest / ring.width
    x, y = (c[0] - models.centres[n, 0]) * scale, (c[1] - models.centres[n, 1]) * scale
    a, ax, ay, axx, axy, ayy = _slopes(models.top[n], x, y, scale)
    b, bx, by, bxx, bxy, byy = _slopes(models.bottom[n], x, y, scale)
    sx, sy = ax / a - bx / b, ay / a - by / b  # of log N
    out[0] = a / b
    out[1], out[2] = out[0] * sx, out[0] * sy
    out[3] = out[0] * (axx / a - (ax / a) ** 2 - bxx / b + (bx / b) ** 2 + sx * sx)
    out[4] = out[0] * (axy / a - ax * ay / a**2 - bxy / b + bx * by / b**2 + sx * sy)
    out[5] = out[0] * (ayy / a - (ay / a) ** 2 - byy / b + (by / b) ** 2 + sy * sy)


@_compiled
def principal(d):
    """Eigenvalues of the Hessian in d, and the direction (cos, sin) of the first."""
    angle = 0.5 * np.arctan2(2 * d[4], d[3] - d[5])
    mean, radius = (d[3] + d[5]) / 2, np.hypot((d[3] - d[5]) / 2, d[4])
    return mean + radius, mean - radius, np.cos(angle), np.sin(angle)


@_compiled
def _ascend(ring, models, start, lowest, c, d):
    """nsp._ascend from `start` to c, with the derivatives there in d: evaluations, and whether it got there.

    On the way an expansion is used once and small. Close to the end it is made anew, so that the derivatives are
    those at the end itself; but not for a maximum clearly below the `lowest` that matters.
    """
    c[:] = start
    radius = new = _RADIUS
    for count in range(1, 60):
        _derivatives(ring, models, c, radius, new, d)
        first, second, u, v = principal(d)
        largest = max(abs(first), abs(second))
        along, across = u * d[1] + v * d[2], -v * d[1] + u * d[2]
        along = along / abs(first) if abs(first) > 1e-9 * largest else 0.0
        across = across / abs(second) if abs(second) > 1e-9 * largest else 0.0
        length = np.hypot(along, across)
        if not np.isfinite(length):
            break
        step = min(1.0, ring.width / (4 * ring.wavenumber * max(length, 1e-300)))
        c[0] += step * (u * along - v * across)
        c[1] += step * (v * along + u * across)
        if length < 1e-13 * ring.unit or (count > 20 and length < 1e-11 * ring.unit):
            _derivatives(ring, models, c, radius, new, d)
            return count, first <= 1e-9 * largest and second < 0
        if length < _CLOSE * ring.unit:
            if first < 0 and d[0] < 0.999 * lowest:
                break
            radius = _CLOSE
        new = _CLOSE if step < 1 else radius
    return count, False


@_compiled
def climb(ring, models, side, first, c, d):
    """nsp.optimum: velocity c, derivatives d; evaluations, and whether a maximum was reached.

    SciPy's Nelder-Mead on -N (Lagarias coefficients), in units of c0, from a simplex of `side` at `first` (2,) until it
    is at most 1e-8; then Newton.

    Why follow SciPy so closely: where the score has several maxima, which of them a search finds depends on its path,
    and the reference's path is SciPy's. The same evaluations in the same order give the same comparisons, but for
    scores that agree to 2e-11.
    """
    simplex, values, unit = np.zeros((3, 2)), np.empty(3), ring.unit
    trial, other, mean = np.empty(2), np.empty(2), np.empty(2)
    simplex[1, 0] = simplex[2, 1] = side
    simplex += first
    for i in range(3):
        values[i] = -_score(ring, models, simplex[i] * unit)
    used = 3
    while used < 5000:
        size = 0.0
        for i in range(1, 3):  # by insertion: equal values keep their order
            for j in range(i, 0, -1):
                if values[j] < values[j - 1]:
                    values[j], values[j - 1] = values[j - 1], values[j]
                    for axis in range(2):
                        simplex[j, axis], simplex[j - 1, axis] = simplex[j - 1, axis], simplex[j, axis]
        for i in range(1, 3):
            size = max(size, abs(simplex[i, 0] - simplex[0, 0]), abs(simplex[i, 1] - simplex[0, 1]))
        if size <= 1e-8:
            break
        mean[:] = (simplex[0] + simplex[1]) / 2
        trial[:] = 2 * mean - simplex[2]
        value = -_score(ring, models, trial * unit)
        used += 1
        if value < values[1] and not value < values[0]:
            simplex[2], values[2] = trial, value
            continue
        if value < values[0]:  # expand
            other[:] = 3 * mean - 2 * simplex[2]
        elif value < values[2]:  # contract, outside
            other[:] = 1.5 * mean - 0.5 * simplex[2]
        else:  # inside
            other[:] = 0.5 * mean + 0.5 * simplex[2]
        second = -_score(ring, models, other * unit)
        used += 1
        if value < values[0] and not second < value:
            simplex[2], values[2] = trial, value
        elif value < values[0] or (second <= value if value < values[2] else second < values[2]):
            simplex[2], values[2] = other, second
        else:
            for j in range(1, 3):
                simplex[j] = simplex[0] + 0.5 * (simplex[j] - simplex[0])
                values[j] = -_score(ring, models, simplex[j] * unit)
            used += 2
    steps, arrived = _ascend(ring, models, simplex[0] * unit, 0.0, c, d)
    return used + steps, arrived and not models.made[2]


@_compiled
def outdone(ring, models, starts, reach, score):
    """Whether from one of the starts the score rises to a higher maximum within reach."""
    c, d = np.empty(2), np.empty(6)
    for n in range(starts.shape[0]):
        _, arrived = _ascend(ring, models, starts[n, :2], score, c, d)
        if arrived and np.hypot(c[0], c[1]) <= reach and d[0] > score * (1 + 1e-9):
            return True
    return False


@_compiled
def scores(ring, models, velocities):
    """N up to a factor at each of the velocities (n, 2): (n,)."""
    # copies, since for rows of another layout all would be compiled once more
    return np.array([_score(ring, models, velocity.copy()) for velocity in velocities])
