# mypy: disallow-untyped-defs=False
"""The whole chain in closed form and compiled: what `leakage`, `shell`, `nsp` and `leastsquares` give, sooner.

Those are the reference, and tests hold this against them. What makes it fast:

- Only the bins of the shells are computed, and all windows come from one pass (`_box_spectrum`, `_taper`).
- Seen from far off along omega the waves are one smooth function, known from some thirty nodes (`_Band`).
- Around one velocity the score is a polynomial in the two components of the velocity. One pass over the columns of a
  shell gives its coefficients (`_expand`); after that an evaluation costs the same whatever the size of the shell, so
  that SciPy's Nelder-Mead can be followed step by step (`_climb`).
- Other basins are looked for on a coarse lattice first, with a bound on the scores in between (`_peaks`).

Compiled functions count frequencies in bins and wavenumbers in bins per unit of velocity. The result is the same to the
last bit on one machine as long as the products run on one thread.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from math import comb, factorial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba import njit

from leakref import leakage, nsp
from leakref._base import ComplexArray, FloatArray, IntArray, LeakrefError, positive
from leakref.chain import METHODS
from leakref.dispersion import intrinsic_frequency
from leakref.grid import Grid
from leakref.leastsquares import SOFT, THRESHOLD
from leakref.sea import Components
from leakref.shell import (_ROUNDING, EDGE_MARGIN, HALF_WIDTH, Extraction, Note, Optimum, Shell, checked_wavenumbers,
                           collect, nothing, shell_at, velocity_unit)
from leakref.spectrum import Spectrum
from leakref.window import Window
from leakref.window import window as named_window

__all__ = ["realize"]

_BLOCK = 8  # frequencies in a block of the products, so that it stays in the cache
_NODES = 34.0  # -log of the error of the interpolation along omega
_ORDER = 12  # of an expansion of the score: powers of the velocity below it
_RADIUS = 0.3  # how far an expansion holds, to 2e-11, in standard deviations of the Gaussian
_CLOSE = 1e-4  # the same for one of order 4, to rounding; and the step in c0 after which Newton's method asks for one
_CUT = 4.25  # widths, where the Gaussian ends: 1e-15 of it is left
_DENSE = 3.0  # bins: from this width on the sampled Gaussian has a constant sum
_LOST = 1e-3  # what is left of G, below which the tails that `_CUT` cuts would decide
_CHUNK = 64  # columns at a time
_KEPT = 64  # expansions of one shell
_POOL = 8  # places of the table of scores, an eighth of the width each

_compiled: Any = njit(cache=True, nogil=True, error_model="numpy")
_summing: Any = njit(cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


@dataclass(frozen=True)
class _Disc:
    """The bins (i, j) with |k| <= `radius` in the order of x, then y: the mirror image of number q is -1 - q."""

    grid: Grid
    radius: float

    @cached_property
    def bins(self) -> tuple[IntArray, IntArray]:
        """i and j, (n,) each."""
        dkx, dky, _ = self.grid.bin_widths
        i, j = (np.arange(-(m := int(self.radius / dk) + 1), m + 1) for dk in (dkx, dky))
        a, b = np.nonzero(np.hypot(*np.meshgrid(i * dkx, j * dky, indexing="ij")) <= self.radius)
        return i[a], j[b]

    def extents(self, stencil: int) -> IntArray:
        """Largest |j| of the rows i = -m ... m that a stencil of `stencil` bins on either side reads, (2 m + 1,)."""
        i, j = self.bins
        m = int(i.max()) + stencil
        extents = np.zeros(2 * m + 1, dtype=np.int64)
        for shift in range(-stencil, stencil + 1):
            np.maximum.at(extents, i + m + shift, np.abs(j) + stencil)
        return extents


class _Axis:
    """Waves along one axis of `size` samples, at `nearest` + `rest` bins, |rest| <= 1/2, within +-size/2.

    The transform of a wave at u, seen at bin n (window.dirichlet), is exp(i pi n / size) times the `factor` of the
    wave times a real kernel 1 / sin(pi (n - u) / size). The first is common to all waves and to their mirror images,
    so that it is left out; only a stencil over bins has to know it (`_taper`).
    """

    def __init__(self, position: FloatArray, size: int) -> None:
        nearest = np.rint(position)
        self.size, self.rest = size, position - nearest
        self.nearest = (nearest - size * np.floor(nearest / size + 0.5)).astype(np.int64)
        self.angle, self.on_bin = np.pi * (self.nearest + self.rest) / size, self.rest == 0

    @property
    def factor(self) -> ComplexArray:
        r = np.pi * self.rest
        return np.where(self.on_bin, 1.0, -np.exp(1j * r) * np.sin(r)) * np.exp(-1j * self.angle)

    def kernel(self, bins: IntArray, waves: IntArray) -> FloatArray:
        """(bins, waves) of these waves; of those exactly on a bin with their factor of zero worked in."""
        d = bins[:, None] - self.nearest[waves]
        turns = np.rint(d / self.size).astype(np.int64)
        d -= self.size * turns
        with np.errstate(divide="ignore"):
            kernel = 1 / np.sin(np.pi / self.size * (d - self.rest[waves]))
        return (1 - 2 * (turns % 2)) * np.where(self.on_bin[waves], self.size * (d == 0), kernel)


class _Band:
    """Frequencies at which to sum over waves, and how all others follow.

    With s = tan(pi (n - middle) / N), every kernel along omega is a cosine times a rational function of s with its
    pole at the wave. On the arc of bins at least a margin from all waves, up across the Nyquist frequency and on to
    below zero, a polynomial through Chebyshev nodes thus converges like rho^-nodes.
    """

    def __init__(self, time: _Axis, stencil: int) -> None:
        n, low, high = time.size, int(time.nearest.min()), int(time.nearest.max())
        margin = min(range(1, max(2, n // 2)), key=lambda m: m + self._nodes(n, high - low + 1, m))
        self.low, self.near, nodes = low - margin, high - low + 1 + 2 * margin, self._nodes(n, high - low + 1, margin)
        if self.near + nodes >= n:
            self.low, self.near, nodes = low, n, 0
        first, last = self.low + self.near, self.low + n - 1  # of the arc
        middle, half = (first + last) / 2, np.tan(np.pi * (last - first) / (2 * n))
        chebyshev = np.pi * (2 * np.arange(nodes) + 1) / (2 * max(nodes, 1))
        s = half * np.cos(chebyshev)
        self.angles = np.pi * middle / n + np.arctan(s)
        bins = np.arange(-(n // 2) - stencil, n // 2 + stencil + 1)
        turns = (bins - self.low) // n
        unwrapped, sign = bins - n * turns, 1 - 2 * (turns % 2)  # a kernel changes sign over a whole turn
        far = unwrapped >= first
        edges = np.flatnonzero(np.diff(np.where(far, -1, turns + n), prepend=-2, append=-2))
        self.runs = np.array([(a, b, unwrapped[a] - self.low, sign[a]) for a, b in pairwise(edges) if not far[a]],
                             dtype=np.int64).reshape(-1, 4)
        x = np.pi * (unwrapped[far] - middle) / n
        distance = np.tan(x) - s[:, None]
        hit = np.abs(distance) < 1e-14 * half
        weight = ((-1.0) ** np.arange(nodes) * np.sin(chebyshev))[:, None] / np.where(hit, 1.0, distance)
        weight = np.where(hit.any(axis=0), hit, weight)
        self.matrix = np.zeros((nodes, bins.size))
        self.matrix[:, far] = weight / weight.sum(axis=0) * np.cos(np.arctan(s))[:, None] / np.cos(x) * sign[far]

    @staticmethod
    def _nodes(size: int, width: int, margin: int) -> int:
        """How many are needed for all bins `margin` away from `width` bins."""
        half = (size - width) / 2 - margin
        if half <= 1:
            return size
        pole, end = (np.tan(np.pi * min(h, size / 2 - 0.5) / size) for h in (half + margin, half))
        return int(_NODES / np.arccosh(max(pole / end, 1 + 1e-9))) + 2


@_compiled
def _moving(out, row, column, wave, whole, cos, sin, on_bin, size, first, table_sin, table_cos):
    """The lattice of waves as seen at frequencies first, first + 1, ...: out (rows, 2, frequencies, columns), planar.

    The kernel is 1 / sin(d - r): d from a table, at first + f - whole, and of each wave the cosine and sine of r.
    """
    for f in range(out.shape[2]):
        for w in range(row.size):
            d = first + f - whole[w]
            value = 1 / (table_sin[d] * cos[w] - table_cos[d] * sin[w])
            if on_bin[w]:
                value = size if d == 0 else 0.0
            out[row[w], 0, f, column[w]] = wave[w].real * value
            out[row[w], 1, f, column[w]] = wave[w].imag * value


@_compiled
def _mirror(out, here, there, near_here, near_there, runs, stencil):
    """A wave and its mirror image: S(n) = T(n) + conj T(-n), out (j, 2, frequencies from -`stencil` on).

    T is interpolated, here and there (j, 2, -m ... m), but for runs of bins near the waves, (j, 2, near).
    """
    top, last = here.shape[2] // 2, here.shape[0] - 1
    for j in range(last + 1):
        for part in range(2):
            for run in range(runs.shape[0]):
                begin, end, source, sign = runs[run]
                for b in range(end - begin):
                    here[j, part, begin + b] = sign * near_here[j, part, source + b]
                    there[last - j, part, begin + b] = sign * near_there[last - j, part, source + b]
        for b in range(out.shape[2]):
            n = b - stencil
            out[j, 0, b] = here[j, 0, top + n] + there[last - j, 0, top - n]
            out[j, 1, b] = here[j, 1, top + n] - there[last - j, 1, top - n]


@_summing
def _stencil(out, centre, before, after, weight, real, imaginary, is_first):
    """weight centre + w after + w* before, for a complex w = real + i imaginary; rows are (2, n), planar."""
    for m in range(out.shape[1]):
        re = real * (after[0, m] + before[0, m]) - imaginary * (after[1, m] - before[1, m])
        im = real * (after[1, m] + before[1, m]) + imaginary * (after[0, m] - before[0, m])
        out[0, m] = re + (weight * centre[0, m] if is_first else out[0, m])
        out[1, m] = im + (weight * centre[1, m] if is_first else out[1, m])


@_compiled
def _taper(values, row, extent, lines, phases, magnitude):
    """|S| of one row of bins under a window, (2 extent + 1, nw), from box values (i, j, 2, nw + 2 h), planar.

    The window is a stencil over h bins on either side along each axis (window.Window): `lines` (h + 1,) are its
    weights; `phases` (3,) what a bin's common phase (_Axis) changes by from one bin to the next.
    """
    h, middle, nw = lines.size - 1, values.shape[1] // 2, magnitude.shape[1]
    pad = (values.shape[3] - nw) // 2
    along, both = np.empty((2 * (extent + h) + 1, 2, values.shape[3])), np.empty((2, values.shape[3]))
    for j in range(along.shape[0] if h else 0):
        at = middle - extent - h + j
        for n in range(1, h + 1):
            _stencil(along[j], values[row, at], values[row - n, at], values[row + n, at], lines[0],
                     lines[n] * np.cos(n * phases[0]), lines[n] * np.sin(n * phases[0]), n == 1)
    for j in range(2 * extent + 1):
        last = values[row, middle - extent + j, :, pad : pad + nw]
        if h:
            for n in range(1, h + 1):
                _stencil(both, along[j + h], along[j + h - n], along[j + h + n], lines[0],
                         lines[n] * np.cos(n * phases[1]), lines[n] * np.sin(n * phases[1]), n == 1)
            last = along[j][:, :nw]  # no longer needed
            for n in range(1, h + 1):
                _stencil(last, both[:, pad:], both[:, pad - n :], both[:, pad + n :], lines[0],
                         lines[n] * np.cos(n * phases[2]), lines[n] * np.sin(n * phases[2]), n == 1)
        for m in range(nw):
            magnitude[j, m] = np.sqrt(last[0, m] ** 2 + last[1, m] ** 2)


def _box_spectrum(components: Components, grid: Grid, stencil: int, disc: _Disc) -> FloatArray:
    """S under the box, planar: (i, j, 2, nt // 2 + 1 + 2 stencil), less the factors that `_Axis` leaves out.

    On a lattice of waves, for each frequency a product of three matrices (leakage.spectrum), real ones on either side.
    Without one the waves stand in a single row, and for each i the two real matrices merge into one.
    """
    x, y, t = (_Axis(k / dk, size) for k, dk, size in zip((components.kx, components.ky, components.omega),
                                                          grid.bin_widths, grid.shape, strict=True))
    wave = components.amplitude / (np.abs(components.amplitude).max() or 1.0) * np.exp(1j * components.phase)
    wave *= x.factor * y.factor * t.factor.conj()
    extents = disc.extents(stencil)
    mi, mj = extents.size // 2, int(extents.max())
    order = row = column = in_row = in_column = np.arange(wave.size)
    a, b = (np.unique(k, return_index=True, return_inverse=True)[1:] for k in (components.kx, components.ky))
    is_lattice = a[0].size * b[0].size <= 8 * wave.size and np.bincount(a[1] * b[0].size + b[1]).max() == 1
    if is_lattice:
        order = np.lexsort((b[1], a[1]))  # neighbours in memory beside each other
        (in_row, row), (in_column, column) = (a[0], a[1][order]), (b[0], b[1][order])
    kernel_x, kernel_y = x.kernel(np.arange(-mi, mi + 1), in_row), y.kernel(np.arange(-mj, mj + 1), in_column)
    rows, columns, row = (in_row.size, in_column.size, row) if is_lattice else (1, wave.size, np.zeros_like(row))
    band, n = _Band(t, stencil), grid.shape[2]
    nodes, count = band.angles.size, band.near + band.angles.size
    d = np.pi / n * np.minimum(np.arange(n), np.arange(n, 0, -1))  # sin(pi d / n) = sin(pi - pi d / n), to all digits
    table_sin, table_cos = np.sin(d), np.where(np.arange(n) <= n // 2, 1, -1) * np.cos(d)
    rest, angle, on_bin = np.pi / n * t.rest[order], t.angle[order], t.on_bin[order]
    # a negative d counts from the end of the table
    near = (t.nearest[order], np.cos(rest), np.sin(rest), on_bin, float(n)), band.low, (
        np.concatenate([table_sin, -table_sin]), np.concatenate([table_cos, -table_cos]))
    far = (np.zeros_like(order), np.cos(angle), np.sin(angle), on_bin, 0.0), 0, (
        np.sin(band.angles), np.cos(band.angles))
    along = np.empty((kernel_x.shape[0] if is_lattice else 1, 2, count, columns))
    block, wave = np.zeros((rows, 2, _BLOCK, columns)), wave[order]
    for begin, total, (waves, first, tables) in ((0, band.near, near), (band.near, nodes, far)):
        for start in range(0, total, _BLOCK):
            size = min(_BLOCK, total - start)
            part = block[:, :, :size]
            _moving(*(part, row, column, wave), *waves, first + start, *tables)
            at = slice(begin + start, begin + start + size)
            for p in range(2):
                flat = part[:, p].reshape(rows, -1)
                along[:, p, at] = (kernel_x @ flat if is_lattice else flat).reshape(-1, size, columns)
    values = np.zeros((2 * mi + 1, 2 * mj + 1, 2, n // 2 + 1 + 2 * stencil))
    for m in range(mi + 1):
        inside = slice(mj - extents[mi + m], mj + extents[mi + m] + 1)
        pair = []
        for r in (mi + m, mi - m):
            left, right = (kernel_y[inside], along[r]) if is_lattice else (kernel_y[inside] * kernel_x[r], along[0])
            seen = (left @ right.reshape(2 * count, -1).T).reshape(-1, count)
            pair.append((seen.reshape(-1, 2, count), (seen[:, band.near :] @ band.matrix).reshape(len(left), 2, -1)))
        (near_here, here), (near_there, there) = pair
        _mirror(values[mi + m, inside], here, there, near_here, near_there, band.runs, stencil)
        if m:
            _mirror(values[mi - m, inside], there, here, near_there, near_here, band.runs, stencil)
    return values


def _magnitudes(components: Components, grid: Grid, windows: Sequence[Window], disc: _Disc) -> dict[str, FloatArray]:
    """F = |S| on the columns of the disc under each window, (n, nt // 2 + 1), up to a factor."""
    i, j = disc.bins
    found: dict[str, FloatArray] = {}
    if sums := [w for w in windows if w.coefficients]:
        stencil = max(len(w.coefficients) for w in sums) - 1
        values = _box_spectrum(components, grid, stencil, disc)
        ends = np.searchsorted(i, np.arange(i.min(), i.max() + 2))
        phases = np.pi / np.array([grid.shape[0], grid.shape[1], -grid.shape[2]])
        for w in sums:
            lines = np.array([w.coefficients[0], *(a / 2 * (-1) ** n for n, a in enumerate(w.coefficients) if n)])
            found[w.name] = np.empty((i.size, grid.shape[2] // 2 + 1))
            for row, (a, b) in enumerate(pairwise(ends)):
                _taper(values, stencil + row, (b - a) // 2, lines, phases, found[w.name][a:b])
    for w in windows:
        if not w.coefficients:  # no stencil
            s = leakage.spectrum(components, grid, w.name, largest_wavenumber=disc.radius)
            found[w.name] = np.abs(s.values[i % s.i.size, j % s.j.size])
    return found


class _Ring(NamedTuple):
    """The columns of one shell and what is needed to sum over them. Frequencies in bins, k in bins per velocity."""

    magnitude: FloatArray  # F of all columns of the disc, (all, nw)
    columns: IntArray  # (n,): which of them
    kx: FloatArray
    ky: FloatArray
    centre: FloatArray  # omega0(k), (n,)
    largest: float  # of |k|
    wavenumber: float  # of the shell
    unit: float  # c0
    width: float
    even: bool  # whether the last bin is the Nyquist frequency, half of it a mirror image
    taps: FloatArray  # exp(-2 (j / width)^2), (2 half + 1,)
    powers: FloatArray  # (2 j / width)^p / p!, (_ORDER, 2 half + 1)
    binomials: FloatArray  # (_ORDER, _ORDER)


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


@_summing
def _pulse(f, d, ring, out):
    """f_j exp(-2 ((j - d) / width)^2) over bins j = -half ... half, out (2 half + 1,)."""
    size, s = f.size, 2 * d / ring.width
    ratio, out[0], filled = np.exp(2 * s / ring.width), np.exp(-s * (s / 2 + (size // 2) * 2 / ring.width)), 1
    while filled < size:  # powers by doubling
        for j in range(min(filled, size - filled)):
            out[filled + j] = out[j] * ratio
        ratio *= ratio
        filled *= 2
    for j in range(size):
        out[j] *= f[j] * ring.taps[j]


@_summing
def _gather(pulses, s, kx, ky, powers, order, total):
    """Add to total[q, p] the sums over columns of kx^q ky^p times the coefficient of t^(q + p), q + p < `order`.

    The Gaussian at distance u - s - t from its centre, in standard deviations, is that at u - s times
    exp(u t) exp(-s t - t^2 / 2): moments of the pulses, times Hermite polynomials of s.
    """
    n = s.size
    moments, hermite, series = np.empty((order, n)), np.empty((order, n)), np.empty((order, n))
    px, py = np.empty((order, n)), np.empty((order, n))
    np.dot(powers[:order], pulses.T, moments)
    for i in range(n):
        hermite[0, i] = px[0, i] = py[0, i] = 1.0
        hermite[1, i], px[1, i], py[1, i] = -s[i], kx[i], ky[i]
    for p in range(2, order):
        for i in range(n):
            hermite[p, i] = -(s[i] * hermite[p - 1, i] + hermite[p - 2, i]) / p
            px[p, i], py[p, i] = px[p - 1, i] * kx[i], py[p - 1, i] * ky[i]
    for p in range(order):
        for i in range(n):
            series[p, i] = moments[p, i]
        for q in range(1, p + 1):
            for i in range(n):
                series[p, i] += hermite[q, i] * moments[p - q, i]
    for q in range(order):
        for p in range(order - q):
            part = 0.0
            for i in range(n):
                part += px[q, i] * py[p, i] * series[q + p, i]
            total[q, p] += part


@_compiled
def _expand(ring, c, order, top, bottom):
    """Numerator and denominator of N around the velocity c: coefficients of x^q y^p, (_ORDER, _ORDER) each.

    x and y are the change of velocity times 2 largest / width; terms of `order` and beyond are left out. Away from
    the Nyquist frequency the denominator is constant to rounding, since the Gaussian is sampled densely.
    """
    size, nw = ring.taps.size, ring.magnitude.shape[1]
    half = size // 2
    f, pulses, ones = np.empty(size), np.empty((_CHUNK, size)), np.empty((_CHUNK, size))
    s, centres = np.empty(_CHUNK), ring.centre + ring.kx * c[0] + ring.ky * c[1]
    top[:] = 0.0
    bottom[:] = 0.0
    clipped = ring.width < _DENSE or np.abs(centres).max() > nw - 3 - half
    for start in range(0, centres.size, _CHUNK):
        n = min(_CHUNK, centres.size - start)
        for i in range(n):
            centre, column = centres[start + i], ring.columns[start + i]
            centre = min(max(centre, -2.0 * nw), 2.0 * nw)  # past the bins all is zero
            nearest = int(np.rint(centre))
            s[i] = 2 * (centre - nearest) / ring.width
            first = nearest - half
            if first < 0 or first + size >= nw:
                _bins(ring, column, first, f)
                _pulse(f, centre - nearest, ring, pulses[i])
            else:
                _pulse(ring.magnitude[column, first : first + size], centre - nearest, ring, pulses[i])
            if clipped:
                _bins(ring, -1, first, f)
                _pulse(f, centre - nearest, ring, ones[i])
        kx, ky = ring.kx[start : start + n] / ring.largest, ring.ky[start : start + n] / ring.largest
        _gather(pulses[:n], s[:n], kx, ky, ring.powers, order, top)
        if clipped:
            _gather(ones[:n], s[:n], kx, ky, ring.powers, order, bottom)
    if not clipped:
        bottom[0, 0] = ring.columns.size * ring.width * np.sqrt(np.pi / 2)
    top *= ring.binomials
    bottom *= ring.binomials


@_compiled
def _value(a, x, y):
    """The polynomial with coefficients a of x^q y^p."""
    total = 0.0
    for q in range(_ORDER - 1, -1, -1):
        row = 0.0
        for p in range(_ORDER - 1 - q, -1, -1):
            row = row * y + a[q, p]
        total = total * x + row
    return total


@_compiled
def _slopes(a, x, y, scale):
    """The polynomial, its gradient and its second derivatives (xx, xy, yy), x and y being velocities times `scale`."""
    v = vx = vy = vxx = vxy = vyy = 0.0
    for q in range(_ORDER - 1, -1, -1):
        r = ry = ryy = 0.0
        for p in range(_ORDER - 1 - q, -1, -1):
            ryy, ry, r = ryy * y + 2 * ry, ry * y + r, r * y + a[q, p]
        vxx, vxy, vx, vyy, vy, v = vxx * x + 2 * vx, vxy * x + vy, vx * x + v, vyy * x + ryy, vy * x + ry, v * x + r
    return v, scale * vx, scale * vy, scale**2 * vxx, scale**2 * vxy, scale**2 * vyy


class _Models(NamedTuple):
    """Expansions of the score of one shell, made where they are asked for."""

    centres: FloatArray  # (_KEPT, 2)
    top: FloatArray  # (_KEPT, _ORDER, _ORDER)
    bottom: FloatArray
    made: IntArray  # how many, which was used last, and whether the search is lost (_score)


@_compiled
def _model(ring, models, c, radius):
    """The number of an expansion whose centre is within `radius` (of 2 k.c / width) of c, new if need be."""
    reach = (radius * ring.width / (2 * ring.largest)) ** 2
    made = models.made[0]
    for back in range(min(made, _KEPT)):
        n = (models.made[1] - back) % min(made, _KEPT)
        if (models.centres[n, 0] - c[0]) ** 2 + (models.centres[n, 1] - c[1]) ** 2 <= reach:
            models.made[1] = n
            return n
    n = made % _KEPT
    models.centres[n] = c
    _expand(ring, c, _ORDER if radius > _CLOSE else 4, models.top[n], models.bottom[n])
    models.made[0], models.made[1] = made + 1, n
    return n


@_compiled
def _score(ring, models, c):
    """N up to a factor, at c. Where most of G has left the Nyquist range the search is noted as lost."""
    n = _model(ring, models, c, _RADIUS)
    scale = 2 * ring.largest / ring.width
    x, y = (c[0] - models.centres[n, 0]) * scale, (c[1] - models.centres[n, 1]) * scale
    bottom = _value(models.bottom[n], x, y)
    if not bottom > _LOST * ring.columns.size * ring.width:
        models.made[2] = 1
        return 0.0
    return _value(models.top[n], x, y) / bottom


@_compiled
def _derivatives(ring, models, c, radius, out):
    """N up to a factor, gradient and second derivatives (xx, xy, yy) as in nsp.score_derivatives, out (6,)."""
    n = _model(ring, models, c, radius)
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
def _principal(d):
    """Eigenvalues of the Hessian in d, and the direction (cos, sin) of the first."""
    angle = 0.5 * np.arctan2(2 * d[4], d[3] - d[5])
    mean, radius = (d[3] + d[5]) / 2, np.hypot((d[3] - d[5]) / 2, d[4])
    return mean + radius, mean - radius, np.cos(angle), np.sin(angle)


@_compiled
def _ascend(ring, models, start, c, d):
    """nsp._ascend from `start` to c, with the derivatives there in d: evaluations, and whether it got there.

    Close to the end the expansion is made anew, so that the derivatives are those at the end itself.
    """
    c[:] = start
    radius = _RADIUS
    for count in range(1, 60):
        _derivatives(ring, models, c, radius, d)
        first, second, u, v = _principal(d)
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
            _derivatives(ring, models, c, radius, d)
            return count, first <= 1e-9 * largest and second < 0
        if length < _CLOSE * ring.unit:
            radius = _CLOSE
    return count, False


@_compiled
def _climb(ring, models, c, d):
    """nsp.optimum: velocity c, derivatives d; evaluations, and whether a maximum was reached.

    SciPy's Nelder-Mead on -N (Lagarias coefficients), in units of c0, until the simplex is at most 1e-8; then Newton.
    """
    simplex, values, unit = np.zeros((3, 2)), np.empty(3), ring.unit
    trial, other, mean = np.empty(2), np.empty(2), np.empty(2)
    simplex[1, 0] = simplex[2, 1] = nsp.START
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
    steps, arrived = _ascend(ring, models, simplex[0] * unit, c, d)
    return used + steps, arrived and not models.made[2]


@_summing
def _pool(table):
    """Fill in the lower half of the table of scores from the upper: P(-k, -omega) = P(k, omega).

    Returns for every fourth place the largest within _POOL = 8 of it or the next three, and that of each row.
    """
    n, size = table.shape
    cells, middle = size // 4 + 1, size // 2
    pooled, tops, place = np.empty((n, cells), dtype=table.dtype), np.empty(n), np.zeros(4 * cells, dtype=table.dtype)
    four = np.zeros(cells + 4, dtype=table.dtype)
    for row in range(n):
        table[row, :middle] = table[n - 1 - row, :middle:-1]
        place[:size] = table[row]
        top = place[0]
        for q in range(cells):  # comparisons and not max(), which minds NaN and takes twice as long
            a, b, c, d = place[4 * q], place[4 * q + 1], place[4 * q + 2], place[4 * q + 3]
            a, c = a if a > b else b, c if c > d else d
            four[2 + q] = a if a > c else c
        for q in range(cells):
            a, b, c, d, e = four[q], four[q + 1], four[q + 2], four[q + 3], four[q + 4]
            a, c = a if a > b else b, c if c > d else d
            a = a if a > c else c
            pooled[row, q] = a if a > e else e
            top = top if top > pooled[row, q] else pooled[row, q]
        tops[row] = top
    return pooled, tops


@_summing
def _drop(table, columns, base, kx, ky, rest, x, y, scores, bar):
    """Add up the table for all columns at the velocities x, y, keeping those that can still reach `bar`. Their number.

    `rest`: how much the columns after each may add at most. x, y and scores are shortened in place.
    """
    live, last, place = x.size, np.int32(table.shape[1] - 1), np.empty(x.size, dtype=np.int32)
    scores[:] = 0.0
    for n in range(columns.size):
        row, a, b, c = table[columns[n]], kx[n], ky[n], base[n]
        for p in range(live):
            place[p] = min(max(np.int32(a * x[p] + b * y[p] + c), np.int32(0)), last)
        for p in range(live):
            scores[p] += row[place[p]]
        if n % 8 == 7 or n == columns.size - 1:
            kept = 0
            for p in range(live):
                if scores[p] + rest[n] >= bar:
                    x[kept], y[kept], scores[kept] = x[p], y[p], scores[p]
                    kept += 1
            live = kept
    return live


@_compiled
def _peaks(ring, order, tops, table, pooled, reach, found, best):
    """The starts of nsp._another_basin: up to six maxima of a coarse score on a lattice, strongest first, best (7, 3).

    `table` holds each column's part of the score by centre, an eighth of the width apart; `pooled` the largest part
    within _POOL of every fourth, which bounds the score of three by three points at once.
    """
    step, middle = ring.width / 8, table.shape[1] // 2
    spacing = ring.width / (2 * ring.wavenumber)
    columns, unit = ring.columns[order], spacing / step
    base, kx, ky = ring.centre[order] / step + middle + 0.5, ring.kx[order] * unit, ring.ky[order] * unit
    rest = np.zeros(order.size)
    for n in range(order.size - 1, 0, -1):
        rest[n - 1] = rest[n] + tops[n]
    own = 0.0
    for n in range(order.size):
        place = int((kx[n] * found[0] + ky[n] * found[1]) / spacing + base[n])
        own += table[columns[n], min(max(place, 0), 2 * middle)]
    bar, m = 0.85 * own, int(np.ceil(reach / spacing))
    block = 3 if (np.sqrt(2) * ring.largest * unit + 1 <= _POOL) else 1
    cells = (m + block - 1) // block
    x, y = np.empty((2 * cells + 1) ** 2), np.empty((2 * cells + 1) ** 2)
    count = 0
    for p in range(-cells, cells + 1):
        for q in range(-cells, cells + 1):
            if np.hypot(p, q) * block * spacing <= reach + (1.5 * spacing if block > 1 else 0.0):
                x[count], y[count] = p * block, q * block
                count += 1
    x, y, scores = x[:count], y[:count], np.empty(count)
    if block > 1:
        count = _drop(pooled, columns, base / 4, kx / 4, ky / 4, rest, x, y, scores, bar)
        fine_x, fine_y, fine = np.empty(9 * count), np.empty(9 * count), 0
        for n in range(count):
            for p in range(-1, 2):
                for q in range(-1, 2):
                    fine_x[fine], fine_y[fine] = x[n] + p, y[n] + q
                    fine += np.hypot(x[n] + p, y[n] + q) * spacing <= reach
        x, y, scores = fine_x[:fine], fine_y[:fine], np.empty(fine)
    count = _drop(table, columns, base, kx, ky, rest, x, y, scores, bar)
    grid = np.zeros((2 * m + 3, 2 * m + 3))
    for n in range(count):
        grid[m + 1 + int(x[n]), m + 1 + int(y[n])] = scores[n]
    starts = 0
    for p in range(1, 2 * m + 2):
        for q in range(1, 2 * m + 2):
            if grid[p, q] > bar and grid[p, q] == grid[p - 1 : p + 2, q - 1 : q + 2].max():
                a, b = (p - 1 - m) * spacing, (q - 1 - m) * spacing
                if np.hypot(a - found[0], b - found[1]) > spacing:
                    place = min(starts, 6)  # by insertion, equal ones in order
                    while place > 0 and best[place - 1, 2] < grid[p, q]:
                        best[place] = best[place - 1]
                        place -= 1
                    best[place, 0], best[place, 1], best[place, 2] = a, b, grid[p, q]
                    starts = min(starts + 1, 6)
    return starts


@_compiled
def _outdone(ring, models, starts, reach, score):
    """Whether from one of the starts the score rises to a higher maximum within reach."""
    c, d = np.empty(2), np.empty(6)
    for n in range(starts.shape[0]):
        _, arrived = _ascend(ring, models, starts[n, :2], c, d)
        if arrived and np.hypot(c[0], c[1]) <= reach and d[0] > score * (1 + 1e-9):
            return True
    return False


@_compiled
def _least_squares(ring, largest, threshold, out):
    """leastsquares.optimum: out (8,) velocity, C, normal matrix (xx, xy, yy), half the gradient.

    Returns bins used, whether one is close to the threshold, whether there is no number, and the threshold of F.
    `largest` F of each column: most hold nothing above the threshold, and are passed over.
    """
    top = largest[ring.columns].max()
    out[:] = 0.0
    bx = by = 0.0
    used, close, flat = 0, False, True
    for residuals in range(2):
        for n in range(ring.columns.size):
            if (largest[ring.columns[n]] / top) ** 2 < threshold - 1e-9:
                continue
            row, kx, ky = ring.magnitude[ring.columns[n]], ring.kx[n], ring.ky[n]
            for m in range(row.size):
                power = (row[m] / top) ** 2
                if power < threshold - 1e-9:
                    continue
                close |= abs(power - threshold) < 1e-10
                if power >= threshold and not residuals:
                    used += 1
                    out[3], out[4], out[5] = out[3] + kx * kx, out[4] + kx * ky, out[5] + ky * ky
                    bx, by = bx + kx * (m - ring.centre[n]), by + ky * (m - ring.centre[n])
                elif power >= threshold:
                    r = kx * out[0] + ky * out[1] - (m - ring.centre[n])
                    out[2] += r * r
                    out[6], out[7] = out[6] + kx * r, out[7] + ky * r
        xx, xy, yy = out[3], out[4], out[5]
        mean, radius = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
        flat = mean - radius <= 1e-9 * (mean + radius)
        if flat:
            break
        determinant = xx * yy - xy * xy
        out[0], out[1] = (yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant
    return used, close, flat, top * np.sqrt(threshold)


@_compiled
def _only_leaked(ring, strongest, c, bar, across, along):
    """Shell.notes: whether something is near, and none of it above what the strongest wave elsewhere may leak there.

    Near is what has a magnitude of at least `bar` (if positive), or is within the width of either branch.
    """
    near = False
    for n in range(ring.columns.size):
        if ring.columns[n] == strongest:
            return False
    for n in range(ring.columns.size):
        row, shift = ring.magnitude[ring.columns[n]], ring.kx[n] * c[0] + ring.ky[n] * c[1]
        for m in range(row.size):
            if bar > 0:
                here = row[m] >= bar
            else:
                here = min(abs(m - ring.centre[n] - shift), abs(m + ring.centre[n] - shift)) <= ring.width
            if here:
                near = True
                if row[m] > across[0, ring.columns[n]] * along[0, m] + across[1, ring.columns[n]] * along[1, m]:
                    return False
    return near


@lru_cache(maxsize=32)
def _lobes(window: str, size: int) -> FloatArray:
    """Window.sidelobe_envelope at every distance modulo `size`, (size,): the same for all realisations."""
    return named_window(window).sidelobe_envelope(np.arange(size), size)


class _Seen:
    """The magnitudes under one window, and the two extractions from a shell of them."""

    def __init__(self, disc: _Disc, window: str, magnitude: FloatArray, rings: list[_Ring]) -> None:
        self.disc, self.magnitude, self.width, grid = disc, magnitude, rings[0].width, disc.grid
        fastest = max(ring.centre.max() + ring.largest * nsp._REACH * ring.unit for ring in rings)
        self.furthest = min(fastest, magnitude.shape[1] + 5 * self.width)  # that a centre may be
        self.step, self.even, m = grid.frequency_resolution, grid.shape[2] % 2 == 0, grid.bins(2)
        self.weight = np.where((m == 0) | (2 * m == grid.shape[2]), 0.5, 1.0)
        self.sums, self.largest = magnitude @ self.weight, magnitude.max(axis=1)
        self.strongest = int(self.largest.argmax())
        at = [*(int(bins[self.strongest]) for bins in disc.bins), int(magnitude[self.strongest].argmax())]
        x, y, self.along = (np.stack([lobes[(bins - n) % lobes.size], lobes[(bins + n) % lobes.size]])  # wave, mirror
                            for lobes, bins, n in zip(map(_lobes, 3 * [window], grid.shape), (*disc.bins, m), at,
                                                      strict=True))
        self.across = self.largest[self.strongest] * x * y
        self.models = _Models(np.empty((_KEPT, 2)), np.empty((_KEPT, _ORDER, _ORDER)),
                              np.empty((_KEPT, _ORDER, _ORDER)), np.zeros(3, dtype=np.int64))

    def _shell(self, ring: _Ring) -> Shell:
        """As shell.shell_at makes it."""
        floor = None if (ring.columns == self.strongest).any() else self.across[:, ring.columns].T @ self.along
        return Shell(ring.wavenumber * self.step, ring.kx * self.step, ring.ky * self.step, ring.centre * self.step,
                     self.disc.grid.bins(2) * self.step, self.weight, self.magnitude[ring.columns], floor, False)

    def _is_empty(self, ring: _Ring) -> bool:
        return not self.largest[ring.columns].max() > _ROUNDING * self.largest[self.strongest]

    def nsp(self, ring: _Ring, search: bool) -> Optimum:
        """nsp.optimum."""
        if self._is_empty(ring):
            return nothing(Note.NO_SIGNAL)
        ring, velocity, d = ring._replace(magnitude=self.magnitude), np.empty(2), np.empty(6)
        self.models.made[:] = 0
        used, arrived = _climb(ring, self.models, velocity, d)
        if not arrived:  # rare: let the reference judge
            return nsp.optimum(self._shell(ring), self.width * self.step, ring.unit, search=search)
        score = d[0]
        d *= ring.columns.size * self.weight.sum() / self.sums[ring.columns].sum()
        frequency, note = ring.centre.max() * np.sqrt(ring.wavenumber / ring.largest), Note.NONE
        top = self.magnitude.shape[1] - 1 - frequency - 3 * self.width
        reach = min(nsp._REACH * ring.unit, top / ring.wavenumber)
        if _only_leaked(ring, self.strongest, velocity, 0.0, self.across, self.along):
            note |= Note.LEAKAGE_FLOOR
        if ring.columns.size < nsp._FEW:
            note |= Note.TOO_FEW_BINS
        if -_principal(d)[0] * ring.unit**2 < nsp._SOFT * d[0]:
            note |= Note.FLAT
        if np.hypot(*velocity) > reach:
            note |= Note.EDGE
        if search and reach > 0 and self._another_basin(ring, velocity, score, reach):
            note |= Note.ANOTHER_BASIN
        return velocity, float(d[0]), d[1:3].copy(), d[[3, 4, 4, 5]].reshape(2, 2), int(used), note

    def _another_basin(self, ring: _Ring, velocity: FloatArray, score: float, reach: float) -> bool:
        """nsp._another_basin."""
        table, pooled, tops = self._table
        tops = tops[ring.columns]
        order, best = np.argsort(-tops, kind="stable"), np.empty((7, 3))
        starts = _peaks(ring, order, tops[order], table, pooled, reach, velocity, best)
        return bool(starts and _outdone(ring, self.models, best[:starts], reach, score))

    @cached_property
    def _table(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32], FloatArray]:
        """Each column's part of the score by the centre of the Gaussian, from -p to p eighths of the width.

        Also its largest values nearby, and at all (_pool). In single precision: it only chooses starts.
        """
        eighth, (n, nw) = self.width / 8, self.magnitude.shape
        p, pad = int(self.furthest / eighth) + 2 + _POOL, int(np.ceil(_CUT * self.width)) + 1
        f = np.zeros((n, pad + max(nw, int(p * eighth) + 2 + pad)), dtype=np.float32)
        f[:, pad : pad + nw] = self.magnitude
        f[:, :pad] = self.magnitude[::-1, pad:0:-1]
        if self.even:
            f[:, pad + nw - 1] *= 0.5
        table = np.empty((n, 2 * p + 1), dtype=np.float32)
        for a in range(0, p + 1, 32):
            centres = np.arange(a, min(a + 32, p + 1)) * eighth
            low, high = int(centres[0]), int(centres[-1]) + 2 * pad
            g = np.exp(-2 * ((np.arange(low, high + 1)[:, None] - pad - centres) / self.width) ** 2)
            np.matmul(f[:, low : high + 1], g.astype(np.float32), out=table[:, p + a : p + a + centres.size])
        return table, *_pool(table)

    def ls(self, ring: _Ring, threshold: float) -> Optimum:
        """leastsquares.optimum."""
        if self._is_empty(ring):
            return nothing(Note.NO_SIGNAL)
        ring, out, note = ring._replace(magnitude=self.magnitude), np.empty(8), Note.NONE
        used, close, flat, bar = _least_squares(ring, self.largest, threshold, out)
        if _only_leaked(ring, self.strongest, out, bar, self.across, self.along):
            note |= Note.LEAKAGE_FLOOR
        if close:
            note |= Note.THRESHOLD
        if used < 2:
            note |= Note.TOO_FEW_BINS
        if flat:
            return nothing(note | Note.FLAT)
        mean, radius = (out[3] + out[5]) / 2, np.hypot((out[3] - out[5]) / 2, out[4])
        if mean - radius < SOFT * (mean + radius):
            note |= Note.FLAT
        out[2:] *= self.step**2
        return out[:2], float(out[2]), 2 * out[6:], 2 * out[[3, 4, 4, 5]].reshape(2, 2), 0, note


def _rings(disc: _Disc, wavenumbers: FloatArray, gravity: float, peak_wavenumber: float | None, width: float,
           half_width: float) -> list[_Ring]:
    """The shells, still without magnitudes. Raises LeakrefError as shell.shell_at does."""
    grid, step = disc.grid, disc.grid.frequency_resolution
    dk, nyquist = grid.wavenumber_resolution, min(grid.nyquist[:2])
    kx, ky = (bins * spacing for bins, spacing in zip(disc.bins, grid.bin_widths, strict=False))
    k = np.hypot(kx, ky)
    centre = intrinsic_frequency(k, gravity) / step
    half, orders = int(np.ceil(_CUT * width)), range(_ORDER)
    u = 2 / width * np.arange(-half, half + 1)
    taps, powers = np.exp(-(u**2) / 2), np.array([u**p / factorial(p) for p in orders])
    binomials = np.array([[float(comb(q + p, p)) for p in orders] for q in orders])
    rings = []
    for k_i in wavenumbers:
        columns = np.flatnonzero(np.abs(k - k_i) / dk <= half_width + EDGE_MARGIN)
        if not columns.size or k_i + half_width * dk >= nyquist * (1 - EDGE_MARGIN):
            empty = Spectrum(grid, "box", grid.bins(0), grid.bins(1), np.empty((0, 0, 0), dtype=np.complex128))
            shell_at(empty, k_i, gravity=gravity, half_width=half_width)  # which says what is wrong
        unit = velocity_unit(float(k_i), gravity, peak_wavenumber)
        rings.append(_Ring(np.empty((0, 0)), columns, kx[columns] / step, ky[columns] / step, centre[columns],
                           float(k[columns].max()) / step, float(k_i) / step, unit, float(width),
                           grid.shape[2] % 2 == 0, taps, powers, binomials))
    return rings


def realize(components: Components, grid: Grid, wavenumbers: npt.ArrayLike, *,
            windows: Sequence[str] = ("box", "hann"), methods: Sequence[str] = ("nsp", "ls"), gravity: float = 1.0,
            peak_wavenumber: float | None = 1.0, width: float = nsp.WIDTH, half_width: float = HALF_WIDTH,
            threshold: float = THRESHOLD, search: bool = True) -> dict[tuple[str, str], Extraction]:
    """What `chain.analyse` reports of these waves under every (window, method): velocities to 1e-11, and all notes.

    Settings as in `nsp.extract` and `leastsquares.extract`. `evaluations` are those of this way of climbing; the
    strongest bin (Note.LEAKAGE_FLOOR) is that within the outermost shell or wave. Raises LeakrefError.
    """
    tapers = [named_window(name) for name in windows]
    for name in methods:
        if name not in METHODS:
            raise LeakrefError("realize", f"no method named {name!r}", f"choose one of {', '.join(METHODS)}")
    k = checked_wavenumbers(wavenumbers, "realize")
    positive("realize", gravity=gravity, width=width, half_width=half_width, peak_wavenumber=peak_wavenumber or 1.0)
    if not 0 < threshold <= 1:
        raise LeakrefError("realize", f"threshold = {threshold}",
                           "give a part of the largest power, above 0 and at most 1")
    dk, inside = grid.wavenumber_resolution, min(grid.nyquist[:2]) * (1 - EDGE_MARGIN)
    waves = float(np.hypot(components.kx, components.ky).max()) + dk
    outermost = float(k.max() + half_width * dk)
    disc = _Disc(grid, min(max(outermost, waves), inside) + EDGE_MARGIN * dk)
    rings = _rings(disc, k, gravity, peak_wavenumber, width, half_width)
    found = {}
    for name, magnitude in _magnitudes(components, grid, tapers, disc).items():
        seen = _Seen(disc, name, magnitude, rings)
        for method in methods:
            optima = [seen.nsp(ring, search) if method == "nsp" else seen.ls(ring, threshold) for ring in rings]
            found[name, method] = collect(method, k, optima)
    return {(name, method): found[name, method] for name in windows for method in methods}
