# mypy: disallow-untyped-defs=False
"""Looking for other basins of the score on a coarse lattice, with a bound on the scores in between, compiled.

The score is a sum over columns, each of which depends on one number only: where the centre of its Gaussian is. A table
of each column's part by centre therefore gives the score at any velocity by one look-up a column. Looking at every
point of the lattice would still cost too much; so blocks of nine points are bounded first, and columns are added from
the strongest down, dropping a point as soon as it cannot reach 0.85 of the score that was found. Nothing is dropped
that could: the bounds hold for all scores in between.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leakref._caches import njit

__all__ = ["PLACES", "POOL", "peaks", "pool", "read_off"]

_compiled: Any = njit(nogil=True, error_model="numpy")
_summing: Any = njit(nogil=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"})

POOL = 8  # places of the table of scores, an eighth of the width each
PLACES = 32  # in a block of them


@_summing
def pool(table):
    """A bound on each column's part of the score, P, and on its largest values at all (n,).

    `table` (n, 4 cells) holds P from place 0 up; the bound (n, 2 cells - 1), from as far below 0 on, is on the places
    within POOL = 8 of every fourth or the next three. It needs the fourth ones only, half a width apart: in between,
    log P is at most theta (1 - theta) / 2 above its chord, since it is a sum of Gaussians (Hoelder).

    It is right because P is, for each column, a sum of Gaussians of one width with weights that are not negative; and
    fast because only every fourth place of the table is read.
    """
    n, cells = table.shape[0], table.shape[1] // 4
    pooled, tops = np.empty((n, 2 * cells - 1), dtype=np.float32), np.empty(n)
    place, pair = np.zeros(2 * cells + 4, dtype=np.float32), np.empty(2 * cells + 3, dtype=np.float32)
    flat, slope = np.float32(np.exp(-0.5)), np.float32(1.00001 * np.expm1(0.125) / -np.expm1(-0.5))
    for row in range(n):
        for q in range(cells):
            place[cells + 1 - q], place[cells + 1 + q] = table[n - 1 - row, 4 * q], table[row, 4 * q]
        for q in range(pair.size):  # comparisons and not max(), which minds NaN and takes twice as long
            a, b = place[q], place[q + 1]
            low, high = (a, b) if a < b else (b, a)
            more = low - flat * high
            pair[q] = high + slope * more if more > 0 else high
        top = pair[0]
        for q in range(2 * cells - 1):
            a = pair[q] if pair[q] > pair[q + 1] else pair[q + 1]
            b = pair[q + 2] if pair[q + 2] > pair[q + 3] else pair[q + 3]
            a = a if a > b else b
            pooled[row, q] = a if a > pair[q + 4] else pair[q + 4]
            top = top if top > pooled[row, q] else pooled[row, q]
        tops[row] = top
    return pooled, tops


@_summing
def _drop(table, zero, columns, base, kx, ky, rest, x, y, scores, bar):
    """Add up the table for all columns at the velocities x, y, keeping those that can still reach `bar`. Their number.

    Of places below the `zero`th the table has the mirror image, P(-k, -omega) = P(k, omega). `rest`: how much the
    columns after each may add at most. x, y and scores are shortened in place.

    Columns come strongest first, so most points fall out after a few of them, and the arrays shrink in place: the sum
    over all columns is only ever formed for points that survive. Looking for survivors every eighth column costs less
    than it saves. Without negative places, the common case, the inner loop has no branch.
    """
    live, last, place = x.size, np.int32(table.shape[1] - 1), np.empty(x.size, dtype=np.int32)
    zero, least = np.int32(zero), np.int32(-last if zero else 0)
    scores[:] = 0.0
    for n in range(columns.size):
        a, b, c = kx[n], ky[n], base[n]
        row, mirror = table[columns[n]], table[table.shape[0] - 1 - columns[n]]
        for p in range(live):
            place[p] = min(max(np.int32(np.int32(a * x[p] + b * y[p] + c) - zero), least), last)
        if not zero or (live and place[:live].min() >= 0):
            for p in range(live):
                scores[p] += row[place[p]]
        else:
            for p in range(live):
                scores[p] += row[place[p]] if place[p] >= 0 else mirror[-place[p]]
        if n % 8 == 7 or n == columns.size - 1:
            kept = 0
            for p in range(live):
                if scores[p] + rest[n] >= bar:
                    x[kept], y[kept], scores[kept] = x[p], y[p], scores[p]
                    kept += 1
            live = kept
    return live


@_compiled
def read_off(ring, table, velocities):
    """The coarse score at each of the velocities (n, 2), up to a factor: (n,)."""
    step, found = ring.width / 8, np.zeros(velocities.shape[0])
    for n in range(found.size):
        for i in range(ring.columns.size):
            centre = ring.centre[i] + ring.kx[i] * velocities[n, 0] + ring.ky[i] * velocities[n, 1]
            place, column = abs(int(np.rint(centre / step))), ring.columns[i]
            column = column if centre >= 0 else table.shape[0] - 1 - column
            found[n] += table[column, min(place, table.shape[1] - 1)]
    return found


@_compiled
def peaks(ring, order, tops, table, pooled, reach, found, best):
    """The starts of nsp.another_basin: up to six maxima of a coarse score on a lattice, strongest first, best (7, 3).

    `table` holds each column's part of the score by centre, an eighth of the width apart from zero up; `pooled`
    (`pool`) bounds the score of three by three points at once.

    `order` are the columns by their largest part, `tops` those parts in that order, `found` the velocity (2,) that was
    found (starts within a spacing of it are left out), `reach` how far from zero a velocity may be. The lattice is half
    a width over the wavenumber of the shell apart, so that a peak of the score is several points wide. The number of
    starts is returned.
    """
    step, middle = ring.width / 8, table.shape[1]
    spacing = ring.width / (2 * ring.wavenumber)
    columns, unit = ring.columns[order], spacing / step
    base, kx, ky = ring.centre[order] / step + middle + 0.5, ring.kx[order] * unit, ring.ky[order] * unit
    rest = np.zeros(order.size)
    for n in range(order.size - 1, 0, -1):
        rest[n - 1] = rest[n] + tops[n]
    own = 0.0
    for n in range(order.size):
        place = int((kx[n] * found[0] + ky[n] * found[1]) / spacing + base[n]) - middle
        column = columns[n] if place >= 0 else table.shape[0] - 1 - columns[n]
        own += table[column, min(abs(place), middle - 1)]
    bar, m = 0.85 * own, int(np.ceil(reach / spacing))
    block = 3 if (np.sqrt(2) * ring.largest * unit + 1 <= POOL) else 1
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
        count = _drop(pooled, 0, columns, base / 4 - 1, kx / 4, ky / 4, rest, x, y, scores, bar)
        fine_x, fine_y, fine = np.empty(9 * count), np.empty(9 * count), 0
        for n in range(count):
            for p in range(-1, 2):
                for q in range(-1, 2):
                    fine_x[fine], fine_y[fine] = x[n] + p, y[n] + q
                    fine += np.hypot(x[n] + p, y[n] + q) * spacing <= reach
        x, y, scores = fine_x[:fine], fine_y[:fine], np.empty(fine)
    count = _drop(table, middle, columns, base, kx, ky, rest, x, y, scores, bar)
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
