# mypy: disallow-untyped-defs=False
"""Least squares, and whether a shell holds leakage alone, compiled.

The normal equations of eq:LS1 need five sums over the bins above the threshold, and those are few: columns whose
largest magnitude is below it are passed over without being read. Frequencies are in bins, wavenumbers in bins per
velocity.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leakref._caches import njit

__all__ = ["least_squares", "only_leaked"]

_compiled: Any = njit(nogil=True, error_model="numpy")


@_compiled
def least_squares(ring, largest, threshold, free, out):
    """leastsquares.optimum: out (8,) velocity, C, normal matrix (xx, xy, yy), half the gradient.

    Returns bins used, whether one is close to the threshold, whether there is no number, and the threshold of F.
    `largest` F of each column: most hold nothing above the threshold, and are passed over.

    The first of the two rounds adds up the normal matrix and solves for the velocity, the second the residuals and the
    gradient there, at the same bins. Power is compared with the threshold in the same order of operations as in the
    reference, since a bin exactly on it must fall on the same side.
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
        flat = mean - radius <= free * (mean + radius)
        if flat:
            break
        determinant = xx * yy - xy * xy
        out[0], out[1] = (yy * bx - xy * by) / determinant, (xx * by - xy * bx) / determinant
    return used, close, flat, top * np.sqrt(threshold)


@_compiled
def only_leaked(ring, strongest, c, bar, across, along):
    """Shell.notes: whether something is near, and none of it above what the strongest wave elsewhere may leak there.

    Near is what has a magnitude of at least `bar` (if positive), or is within the width of either branch. `across` (2,
    columns) and `along` (2, nw) are the envelopes of the strongest wave and of its mirror image: their products bound
    what it can leak into a bin. A shell that holds the strongest bin itself never holds leakage alone.
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
