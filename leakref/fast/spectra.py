# mypy: disallow-untyped-defs=False
"""The magnitudes of a spectrum in closed form, in products of matrices and compiled loops: part of `leakref.fast`.

Only the bins of the shells are computed, and all windows come from one pass (`_box_rows`, `_taper`). Seen from far off
along omega the waves are one smooth function, known from some thirty nodes (`_Band`). Waves that are no lattice are
spread over one (`_Axis.spread`).

For each frequency a sum over waves is a product of three matrices: a kernel along x, the waves on their lattice, a
kernel along y. The product along x is done for all frequencies together, and rows of bins are then taken outwards from
the middle, each with its mirror image, so that no more than a few rows are in memory and the tapers are worked in while
they are in the cache. Used by `fast.realize`; `leakage.spectrum` is what it is held against.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any

import numpy as np

from leakref import leakage
from leakref._base import ComplexArray, FloatArray, IntArray
from leakref.fast.kernels import _FINER, _TILE, _WIDE, _mirror, _moving, _spreading, _taper
from leakref.grid import Grid
from leakref.sea import Components
from leakref.window import Window

__all__ = ["Disc", "magnitudes"]

_BLOCK = 8  # frequencies in a block of the products, so that it stays in the cache
_SHAPE = 0.976 * np.pi * _WIDE * (1 - _FINER[1] / (2 * _FINER[0]))  # of the bell
_NODES = 34.0  # -log of the error of the interpolation along omega


@dataclass(frozen=True)
class Disc:
    """The bins (i, j) with |k| <= `radius` in the order of x, then y: the mirror image of number q is -1 - q. `radius`,
    in rad per length of the grid, reaches the outermost shell and all waves.

    """

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
        """Where a wave is on a bin its kernel has no pole, and all that is left of it is a phase."""
        r = np.pi * self.rest
        return np.where(self.on_bin, 1.0, -np.exp(1j * r) * np.sin(r)) * np.exp(-1j * self.angle)

    @property
    def whole_factor(self) -> ComplexArray:
        """With sin(pi u) left to the kernel, as `spread` has it."""
        return (1 - 2 * (self.nearest % 2)) * np.exp(1j * (np.pi * self.rest - self.angle))

    def spread(self, bins: IntArray) -> tuple[FloatArray, IntArray, FloatArray]:
        """The waves as some on a lattice: the kernel of the lattice (bins, points), and of each wave (n,) the first
        point and its parts on _WIDE of them.

        As in a non-uniform FFT, exp(i u x) over the samples is a sum over points of `_bell`s times exp(i point x),
        over the transform of the bell at x.
        """
        fine, coarse = _FINER
        place = self.nearest * fine / coarse + self.rest * fine / coarse
        first = np.floor(place).astype(np.int64) - _WIDE // 2 + 1
        parts = _bell(((place - first)[:, None] - np.arange(_WIDE)) * (2 / _WIDE))
        points = np.arange(first.min(), first.max() + _WIDE)
        distance = np.abs(fine * bins[:, None] - coarse * points)
        kernel = _undone(self.size, int(distance.max()))[distance] * (1 - 2 * (bins % 2))[:, None]
        return kernel, first - first.min(), parts

    def kernel(self, bins: IntArray, waves: IntArray) -> FloatArray:
        """(bins, waves) of these waves; of those exactly on a bin with their factor of zero worked in."""
        d = bins[:, None] - self.nearest[waves]
        turns = np.rint(d / self.size).astype(np.int64)
        d -= self.size * turns
        with np.errstate(divide="ignore"):
            kernel = 1 / np.sin(np.pi / self.size * (d - self.rest[waves]))
        return (1 - 2 * (turns % 2)) * np.where(self.on_bin[waves], self.size * (d == 0), kernel)


def _bell(z: FloatArray) -> FloatArray:
    """What a wave is spread with, over -1 ... 1. It is the exponential of a semicircle: nearly zero at its ends and
    nearly band-limited, which is what lets _WIDE points carry a wave to 1e-15. Written with the root in the denominator
    no digits are lost near the middle.
    """
    return np.exp(-_SHAPE * z * z / (1 + np.sqrt(np.maximum(1 - z * z, 0.0))))  # a root less one, to all digits


@lru_cache(maxsize=16)
def _undone(size: int, reach: int) -> FloatArray:
    """The transform of the box at 0 ... `reach` parts of a bin, _FINER[0] of them, over that of the bell. That undoes
    what the bell has done to the spectrum; it depends on the size alone and is remembered.
    """
    m = (np.arange(size) - (size - 1) / 2) / size
    z = np.arange(-63, 64) / 64
    bell = np.cos(np.pi * _WIDE * _FINER[1] / _FINER[0] * np.outer(m, z)) @ (_bell(z) * _WIDE / 128)
    return np.cos(2 * np.pi / _FINER[0] * np.outer(np.arange(reach + 1), m)) @ (1 / bell)


class _Band:
    """Frequencies at which to sum over waves, and how all others follow.

    With s = tan(pi (n - middle) / N), every kernel along omega is a cosine times a rational function of s with its pole
    at the wave. On the arc of bins at least a margin from all waves, up across the Nyquist frequency and on to below
    zero, a polynomial through Chebyshev nodes thus converges like rho^-nodes.

    So most of the frequencies of a spectrum, those far from all waves, cost a product with a small matrix (`matrix`) in
    place of a sum over waves. `runs` says which bins are near and are copied. The margin is chosen so that bins near
    and nodes together are fewest.
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
        self.runs = np.array(
            [(a, b, unwrapped[a] - self.low, sign[a]) for a, b in pairwise(edges) if not far[a]], dtype=np.int64
        ).reshape(-1, 4)
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


def _rows_and_columns(components: Components) -> tuple[Any, Any, bool]:
    """Where the waves stand along x and y, first occurrences and inverse, and whether that is a lattice."""
    a, b = (np.unique(k, return_index=True, return_inverse=True)[1:] for k in (components.kx, components.ky))
    return a, b, (a[0].size * b[0].size <= 8 * components.kx.size and np.bincount(a[1] * b[0].size + b[1]).max() == 1)


def _placed(components: Components, x: _Axis, y: _Axis, extents: IntArray) -> tuple[Any, ...]:
    """The kernels of a lattice, (i, rows) and (j, columns); of the waves the rows, the columns, the parts if they are
    spread, and the factors; and whether they are too few for that and each has its own row and column. Waves on a
    lattice need a kernel for each row and column only. Others are spread, unless they are so few that a kernel for each
    wave costs less.
    """
    i, j = (np.arange(-m, m + 1) for m in (extents.size // 2, int(extents.max())))
    a, b, is_lattice = _rows_and_columns(components)
    if is_lattice:
        return x.kernel(i, a[0]), y.kernel(j, b[0]), a[1], b[1], (), x.factor * y.factor, False
    (kernel_x, row, parts_x), (kernel_y, column, parts_y) = x.spread(i), y.spread(j)
    cells, n = int(np.sum(2 * extents + 1)), np.arange(row.size)
    if n.size * cells > (i.size * kernel_x.shape[1] + cells) * kernel_y.shape[1]:
        return kernel_x, kernel_y, row, column, (parts_x, parts_y), x.whole_factor * y.whole_factor, False
    return x.kernel(i, n), y.kernel(j, n), n, n, (), x.factor * y.factor, True


def _along(
    kernel_x: FloatArray,
    place: tuple[IntArray, IntArray, int],
    parts: Sequence[FloatArray],
    are_few: bool,
    wave: ComplexArray,
    t: _Axis,
    band: _Band,
) -> FloatArray:
    """The waves summed along x, at the frequencies of the band: (i, 2 frequencies, columns), planar.

    Frequencies near the waves come first, then the nodes. Kernels along omega come from tables of sines and cosines of
    bins (`_seen`), so that no trigonometric function is taken for a wave and a frequency together.
    """
    (row, column, columns), n, count = place, t.size, band.near + band.angles.size
    d = np.pi / n * np.minimum(np.arange(n), np.arange(n, 0, -1))  # sin(pi d / n) = sin(pi - pi d / n), to all digits
    table_sin, table_cos = np.sin(d), np.where(np.arange(n) <= n // 2, 1, -1) * np.cos(d)
    rest = np.pi / n * t.rest
    # a negative d counts from the end of the table
    near = (
        (t.nearest, np.cos(rest), np.sin(rest), t.on_bin, float(n)),
        band.low,
        (np.concatenate([table_sin, -table_sin]), np.concatenate([table_cos, -table_cos])),
    )
    far = (
        (np.zeros_like(t.nearest), np.cos(t.angle), np.sin(t.angle), t.on_bin, 0.0),
        0,
        (np.sin(band.angles), np.cos(band.angles)),
    )
    both = (0, band.near, near), (band.near, band.angles.size, far)
    if parts:
        seen, lattice = np.empty((2, wave.size, count, 1)), np.zeros((kernel_x.shape[1], columns, 2 * count))
        for begin, total, (waves, first, tables) in both:
            _moving(seen[:, :, begin:], total, np.arange(wave.size), 0 * row, wave, *waves, first, *tables)
        ends = np.flatnonzero(np.diff(row // _TILE * columns + column // _TILE, append=-1)) + 1
        _spreading(lattice, ends, row, column, *parts, np.concatenate(seen[..., 0], axis=1))
        return (kernel_x @ lattice.reshape(len(lattice), -1)).reshape(-1, columns, 2 * count).transpose(0, 2, 1)
    along = np.empty((1 if are_few else len(kernel_x), 2, count, columns))
    block = np.zeros((2, 1 if are_few else kernel_x.shape[1], _BLOCK, columns))
    for begin, total, (waves, first, tables) in both:
        for start in range(0, total, _BLOCK):
            size = min(_BLOCK, total - start)
            _moving(block, size, row, column, wave, *waves, first + start, *tables)
            at = slice(begin + start, begin + start + size)
            for p in range(2):
                flat = block[p, :, :size].reshape(block.shape[1], -1)
                along[:, p, at] = (flat if are_few else kernel_x @ flat).reshape(-1, size, columns)
    return along.reshape(-1, 2 * count, columns)


def _box_rows(components: Components, grid: Grid, stencil: int, extents: IntArray) -> Iterator[tuple[FloatArray, ...]]:
    """T under the box in the rows of bins m and -m, m = 0, 1, ...: (j, 2, frequencies -nt // 2 - `stencil` ...) each.

    S is T and its mirror image (`_mirror`), less the factors that `_Axis` leaves out. For each frequency that is a
    product of three matrices (leakage.spectrum), real ones on either side. If there are too few waves for that they
    stand in a single row, and for each m the two real matrices merge into one. The largest amplitude is 1.
    """
    x, y = (
        _Axis(k / dk, size)
        for k, dk, size in zip((components.kx, components.ky), grid.bin_widths, grid.shape, strict=False)
    )
    kernel_x, kernel_y, row, column, parts, factor, are_few = _placed(components, x, y, extents)
    # neighbours in memory beside each other
    order = np.lexsort((column, row, column // _TILE, row // _TILE) if parts else (column, row))
    row, column, parts = row[order] * (not are_few), column[order], [part[order] for part in parts]
    t = _Axis(components.omega[order] / grid.frequency_resolution, grid.shape[2])
    wave = components.amplitude / (np.abs(components.amplitude).max() or 1.0) * np.exp(1j * components.phase)
    wave = (wave * factor)[order] * t.factor.conj()
    band = _Band(t, stencil)
    along = _along(kernel_x, (row, column, kernel_y.shape[1]), parts, are_few, wave, t, band)
    middle, count = kernel_y.shape[0] // 2, band.near + band.angles.size
    for m in range(len(kernel_x) // 2 + 1):
        pair = []
        for r in (len(kernel_x) // 2 + m, len(kernel_x) // 2 - m):
            left = kernel_y[middle - extents[r] : middle + extents[r] + 1]
            left, right = (left * kernel_x[r], along[0].T) if are_few else (left, along[r].T)
            seen = (left @ right).reshape(-1, count)
            everywhere = (seen[:, band.near :] @ band.matrix).reshape(len(left), 2, -1)
            for start, end, source, sign in band.runs:  # the bins near the waves
                everywhere[:, :, start:end] = sign * seen.reshape(-1, 2, count)[:, :, source : source + end - start]
            pair.append(everywhere)
        yield tuple(pair)


def _seen_under(sums: list[Window], components: Components, grid: Grid, disc: Disc) -> dict[str, FloatArray]:
    """`magnitudes` under windows that are sums of cosines, row by row outwards.

    Rows are kept in a ring of `slots`, as many as the widest stencil needs; a row is tapered under every window as soon
    as its last neighbour is there. The box is a stencil of width zero and costs nothing more.
    """
    i, _ = disc.bins
    stencil = max(len(w.coefficients) for w in sums) - 1
    extents, ends = disc.extents(stencil), np.searchsorted(i, np.arange(i.min(), i.max() + 2))
    outermost, middle, slots = int(i.max()), int(extents.max()), 2 * stencil + 1
    phases = np.pi / np.array([grid.shape[0], grid.shape[1], -grid.shape[2]])
    lines = {
        w.name: np.array(
            [a * (-1) ** n / (1 + (n > 0)) * np.exp(1j * n * phases) for n, a in enumerate(w.coefficients)]
        ).T.copy()
        for w in sums
    }
    found: dict[str, FloatArray] = {w.name: np.empty((i.size, grid.shape[2] // 2 + 1)) for w in sums}
    values = np.empty((2 * slots, 2 * middle + 1, 2, grid.shape[2] // 2 + 1 + 2 * stencil))

    def kept(r: int) -> int:
        """Where the latest rows on either side are."""
        return abs(r) % slots + slots * (r < 0)

    for m, (here, there) in enumerate(_box_rows(components, grid, stencil, extents)):
        inside = slice(middle - here.shape[0] // 2, middle + here.shape[0] // 2 + 1)
        _mirror(values[kept(m), inside], here, there, stencil)
        _mirror(values[kept(-m), inside], there, here, stencil)
        for row in {m - stencil, stencil - m} if m >= stencil else ():
            a, b = ends[outermost + row], ends[outermost + row + 1]
            around = np.array([kept(row + n) for n in range(-stencil, stencil + 1)])
            for name, seen in found.items():
                _taper(values, around, (b - a) // 2, lines[name], seen[a:b])
    return found


def magnitudes(components: Components, grid: Grid, windows: Sequence[Window], disc: Disc) -> dict[str, FloatArray]:
    """F = |S| on the columns of the disc under each window, (n, nt // 2 + 1), up to a factor.

    In the order of `disc.bins`; the factor matters to no velocity. Kaiser-Bessel, which is no sum of
    cosines, goes through the reference's closed form.
    """
    i, j = disc.bins
    found: dict[str, FloatArray] = {}
    if sums := [w for w in windows if w.coefficients]:
        found = _seen_under(sums, components, grid, disc)
    for w in windows:
        if not w.coefficients:  # no stencil
            s = leakage.spectrum(components, grid, w.name, largest_wavenumber=disc.radius)
            found[w.name] = np.abs(s.values[i % s.i.size, j % s.j.size])
    return found
