"""Repairs with a figure in them, found from answers beside what they should be: a factor, one a component, an angle.

A code that is wrong by a factor of its own (a unit nobody thought of, a camera turned by some degrees) is on no list.
From one velocity any factor can be had, and from velocities along one line any angle with it: so they must point along
different lines, and what is found must be common to all of them. Used by `cure`.
"""

from __future__ import annotations

import numpy as np

from leakref._base import FloatArray
from leakref.certify.strength.repaired import Repair
from leakref.certify.strength.repairs import factor, turned

__all__ = ["HOLDS", "fits", "spans"]

HOLDS = 1.5
"""Digits to which a factor must be common to all velocities, and to which answers known exactly must come right."""


def fits(found: FloatArray, should: FloatArray, *, angles: bool) -> list[Repair]:
    """The simplest repair that makes of velocities `found` (m, 2) what they `should` be (m, 2), to `HOLDS` digits.

    A factor is simpler than one for each component, and these than an angle with a factor, which is looked for with
    `angles`. None is returned if velocities point along one line, if none is common to all, or if it is 1 (or a sign,
    or a quarter turn, which are repairs with a name).
    """
    if not spans(should):
        return []
    size = float((found**2).sum()) or 1.0
    common = float((found * should).sum()) / size
    known = _agree(found * common, should)
    if known >= HOLDS:
        return [factor(common, common, known)] if abs(abs(common) - 1) > 3 * 10**-known else []
    squares = (found**2).sum(axis=0)
    each = (found * should).sum(axis=0) / np.where(squares > 0, squares, 1.0)
    known = _agree(found * each, should)
    if known >= HOLDS and np.abs(each).min() > 1e-3:
        named = np.abs(np.abs(each) - 1).max() <= 3 * 10**-known
        return [] if named else [factor(float(each[0]), float(each[1]), known)]
    z = np.sum((should @ [1, 1j]) * (found @ [1, -1j])) / size  # least squares of should = z found, as complex numbers
    known = _agree(found @ np.array([[z.real, -z.imag], [z.imag, z.real]]).T, should)
    quarter = np.abs(z**4 / abs(z) ** 4 - 1) <= 3 * 10**-known if z else True
    return [turned(z, known)] if angles and known >= HOLDS and not quarter else []


def spans(velocities: FloatArray) -> bool:
    """Whether two of the velocities (m, 2), but for the slowest, are more than some 17 degrees apart as lines."""
    speed = np.hypot(*velocities.T)
    x, y = (velocities / np.maximum(speed, 1e-300)[:, None])[speed > 0.1 * speed.max(initial=1e-9)].T
    return bool(np.abs(np.outer(x, y) - np.outer(y, x)).max(initial=0.0) > 0.3)


def _agree(found: FloatArray, should: FloatArray) -> float:
    """Digits to which velocities (m, 2) agree, the worst of them against the largest."""
    off = float(np.abs(found - should).max()) / (float(np.abs(should).max()) or 1.0)
    return -float(np.log10(max(off, 1e-12)))
