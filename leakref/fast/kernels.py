# mypy: disallow-untyped-defs=False
"""The loops over waves and bins that the spectra are made by, compiled.

Loops that NumPy would do in many passes over memory are done in one here. `_compiled` keeps the order of operations;
`_summing` lets the compiler regroup sums, which is what vectorises them, but not forget about NaN or infinities. The
results are the same on every run on one machine. Complex numbers are planar, real parts and imaginary parts apart,
because loops over neighbours of one kind vectorise and loops over pairs do not. What it all means is in `spectra`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leakref._caches import njit

__all__ = []

_compiled: Any = njit(nogil=True, error_model="numpy")
_summing: Any = njit(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})

_FINER, _WIDE = (5, 2), 16  # points of the lattice a bin, as a ratio, and those that a wave is spread over: to 1e-15
_TILE = 4  # of these points, the waves of which are spread by one product


@_compiled
def _seen(d, w, cos, sin, on_bin, size, table_sin, table_cos):
    """The kernel 1 / sin(d - r): d from a table, and of each wave the cosine and sine of r.

    By sin(d - r) = sin d cos r - cos d sin r no sine is ever taken in the loop. A wave exactly on a bin has a kernel of
    N at its own bin and nothing elsewhere; its factor of zero, which would make 0 / 0 of it, is worked in here.
    """
    if on_bin[w]:
        return size if d == 0 else 0.0
    return 1 / (table_sin[d] * cos[w] - table_cos[d] * sin[w])


@_compiled
def _moving(out, number, row, column, wave, whole, cos, sin, on_bin, size, first, table_sin, table_cos):
    """The lattice of waves as seen at a `number` of frequencies from the `first`: out (2, rows, _BLOCK, columns).

    Waves keep their places on the lattice; what changes from frequency to frequency is only this kernel. A block of
    frequencies at a time, so that the product that follows finds it in the cache.
    """
    for f in range(number):
        for w in range(row.size):
            value = _seen(first + f - whole[w], w, cos, sin, on_bin, size, table_sin, table_cos)
            out[0, row[w], f, column[w]] = wave[w].real * value
            out[1, row[w], f, column[w]] = wave[w].imag * value


@_summing
def _spreading(out, ends, row, column, x, y, seen):
    """Waves `seen` at some frequencies (waves, n) spread over the lattice, out (rows, columns, n), tile by tile.

    x and y (waves, _WIDE) are their parts on points from `row` and `column` on, `ends` where the tiles end.

    Waves are sorted by tile. Within a tile each has its _WIDE by _WIDE parts on a common patch, so that one matrix
    product adds up all its waves at all frequencies, in place of an addition to the lattice for each wave, part and
    frequency.
    """
    side, begin = _TILE + _WIDE - 1, 0
    for end in ends:
        parts = np.zeros((end - begin, side * side))
        first_row, first_column = row[begin] // _TILE * _TILE, column[begin] // _TILE * _TILE
        for w in range(begin, end):
            for a in range(_WIDE):
                at = (row[w] - first_row + a) * side + column[w] - first_column
                for b in range(_WIDE):
                    parts[w - begin, at + b] = x[w, a] * y[w, b]
        patch = np.dot(parts.T, seen[begin:end])
        for a in range(min(side, out.shape[0] - first_row)):
            for b in range(min(side, out.shape[1] - first_column)):
                line, more = out[first_row + a, first_column + b], patch[a * side + b]
                for f in range(more.size):
                    line[f] += more[f]
        begin = end


@_summing
def _mirror(out, here, there, stencil):
    """A wave and its mirror image: S(n) = T(n) + conj T(-n), out (j, 2, frequencies from -`stencil` on).

    T here and at the mirror image of the row, (j, 2, -m ... m).

    A real surface has S(-k, -omega) = conj S(k, omega), so each row needs only one sum over waves, and its mirror
    image, which is computed anyway, has the other.
    """
    top, last = here.shape[2] // 2, here.shape[0] - 1
    for j in range(last + 1):
        a, b, c = out[j], here[j], there[last - j]
        for n in range(out.shape[2]):
            a[0, n] = b[0, top - stencil + n] + c[0, top + stencil - n]
            a[1, n] = b[1, top - stencil + n] - c[1, top + stencil - n]


@_summing
def _stencil(out, centre, before, after, shift, weight, w, is_first):
    """weight centre + w after + w* before, for a complex w; planar rows (2, n), neighbours `shift` bins off.

    The sum begins with the first neighbours; bins without a neighbour are left alone.

    A window that is a sum of cosines is, in the spectrum, a weighted sum of neighbouring bins along each axis: a taper
    of the box spectrum costs a few operations a bin instead of a transform of its own.
    """
    for m in range(shift, out.shape[1] - shift):
        a, b, c, d = after[0, m + shift], before[0, m - shift], after[1, m + shift], before[1, m - shift]
        re, im = w.real * (a + b) - w.imag * (c - d), w.real * (c + d) + w.imag * (a - b)
        if is_first:
            re, im = re + weight * centre[0, m], im + weight * centre[1, m]
        else:
            re, im = re + out[0, m], im + out[1, m]
        out[0, m], out[1, m] = re, im


@_compiled
def _taper(values, rows, extent, lines, magnitude):
    """|S| of one row of bins under a window, (2 extent + 1, nw), from box values (slot, j, 2, nw + 2 pad), planar.

    The window is a stencil over h bins on either side along each axis (window.Window): `lines` (3, h + 1) are its
    weights for the next bins along each axis, turned by what a bin's common phase (_Axis) changes by. `rows`: the slots
    of the row and of those around it.

    The three axes are done one after the other: along i for the rows that j needs, then along j, then along omega, so
    that each sum runs over neighbours in memory. The magnitude is all that is kept of the values.
    """
    h, middle, nw, around = lines.shape[1] - 1, values.shape[1] // 2, magnitude.shape[1], rows.size // 2
    pad = (values.shape[3] - nw) // 2
    along = np.empty((2 * (extent + h) + 1, 2, values.shape[3]))
    both, last = np.empty((2, values.shape[3])), np.empty((2, values.shape[3]))
    for j in range(along.shape[0] if h else 0):
        at = middle - extent - h + j
        for n in range(1, h + 1):
            _stencil(
                along[j],
                values[rows[around], at],
                values[rows[around - n], at],
                values[rows[around + n], at],
                0,
                lines[0, 0].real,
                lines[0, n],
                n == 1,
            )
    for j in range(2 * extent + 1):
        if h:
            for n in range(1, h + 1):
                _stencil(
                    both, along[j + h], along[j + h - n], along[j + h + n], 0, lines[1, 0].real, lines[1, n], n == 1
                )
            for n in range(1, h + 1):
                _stencil(last, both, both, both, n, lines[2, 0].real, lines[2, n], n == 1)
        seen, out = last if h else values[rows[around], middle - extent + j], magnitude[j]
        for m in range(nw):
            out[m] = np.sqrt(seen[0, pad + m] ** 2 + seen[1, pad + m] ** 2)
