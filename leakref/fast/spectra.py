# mypy: disallow-untyped-defs=False
"""The magnitudes of a spectrum in closed form, compiled: part of `leakref.fast`.

Only the bins of the shells are computed, and all windows come from one pass (`_box_spectrum`, `_taper`). Seen from far
off along omega the waves are one smooth function, known from some thirty nodes (`_Band`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from leakref import leakage
from leakref._base import ComplexArray, FloatArray, IntArray
from leakref._caches import njit
from leakref.grid import Grid
from leakref.sea import Components
from leakref.window import Window

__all__ = ["Disc", "magnitudes"]

_BLOCK = 8  # frequencies in a block of the products, so that it stays in the cache
_GROUPS = 4  # of waves that are no lattice
_NODES = 34.0  # -log of the error of the interpolation along omega

_compiled: Any = njit(nogil=True, error_model="numpy")
_summing: Any = njit(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})


@dataclass(frozen=True)
class Disc:
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


def _in_groups(components: Components) -> list[Components]:
    """Waves that are no lattice in some groups of like frequency: of each, fewer frequencies are near (`_Band`)."""
    if _rows_and_columns(components)[2]:
        return [components]
    parts = np.array_split(np.argsort(components.omega, kind="stable"), _GROUPS)
    return [replace(components, **{name: values[part] for name, values in vars(components).items()})
            for part in parts if part.size]


def _rows_and_columns(components: Components) -> tuple[Any, Any, bool]:
    """Where the waves stand along x and y, first occurrences and inverse, and whether that is a lattice."""
    a, b = (np.unique(k, return_index=True, return_inverse=True)[1:] for k in (components.kx, components.ky))
    return a, b, (a[0].size * b[0].size <= 8 * components.kx.size
                  and np.bincount(a[1] * b[0].size + b[1]).max() == 1)


def _box_spectrum(components: Components, largest: float, grid: Grid, stencil: int, disc: Disc) -> FloatArray:
    """S under the box, planar: (i, j, 2, nt // 2 + 1 + 2 stencil), less the factors that `_Axis` leaves out.

    On a lattice of waves, for each frequency a product of three matrices (leakage.spectrum), real ones on either side.
    Without one the waves stand in a single row, and for each i the two real matrices merge into one. Amplitudes are
    counted in units of the `largest`.
    """
    x, y, t = (_Axis(k / dk, size) for k, dk, size in zip((components.kx, components.ky, components.omega),
                                                          grid.bin_widths, grid.shape, strict=True))
    wave = components.amplitude / largest * np.exp(1j * components.phase)
    wave *= x.factor * y.factor * t.factor.conj()
    extents = disc.extents(stencil)
    mi, mj = extents.size // 2, int(extents.max())
    order = row = column = in_row = in_column = np.arange(wave.size)
    a, b, is_lattice = _rows_and_columns(components)
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


def magnitudes(components: Components, grid: Grid, windows: Sequence[Window], disc: Disc) -> dict[str, FloatArray]:
    """F = |S| on the columns of the disc under each window, (n, nt // 2 + 1), up to a factor."""
    i, j = disc.bins
    found: dict[str, FloatArray] = {}
    if sums := [w for w in windows if w.coefficients]:
        stencil = max(len(w.coefficients) for w in sums) - 1
        parts, largest = _in_groups(components), np.abs(components.amplitude).max() or 1.0
        values = _box_spectrum(parts[0], largest, grid, stencil, disc)
        for part in parts[1:]:
            values += _box_spectrum(part, largest, grid, stencil, disc)
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
